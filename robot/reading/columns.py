"""What the columns of a file are: joints, time, a count, a motion's name, or something else."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from ...core.errors import InputError
from .raw import Unit

_UNIT = re.compile(r"[\s_]*[\[(]\s*(rad|radians?|deg|degrees?|°|%|m?s|sec)\s*[\])]\s*$", re.I)
_TAIL_UNIT = re.compile(r"[_\s](rad|radians|deg|degrees)$", re.I)
_OTHER_KINDS = {
    "velocity", "velocities", "vel", "speed", "effort", "efforts", "torque", "current", "load",
    "acceleration", "acc", "stiffness", "temperature", "hardness",
}  # fmt: skip
_POSITION = {"position", "positions", "pos", "angle", "value", "sensor", "actuator"}
_TIMES = {
    "time", "times", "t", "timestamp", "stamp", "sec", "secs", "seconds", "timesec", "ms", "timems",
    "nsec", "nsecs", "timens", "timeus", "headerstamp",
}  # fmt: skip
_COUNTS = {
    "", "frame", "frames", "frameindex", "index", "idx", "step", "sample", "seq", "headerseq",
    "unnamed0", "row", "nr", "no", "id",
}  # fmt: skip
_MOTIONS = {
    "id", "motion", "motionid", "motionname", "animation", "animationname", "animationid",
    "episode", "episodeindex", "clip", "trial", "take", "sequence",
}  # fmt: skip


class NoJoints(InputError):
    """A file that has none of the joints that are asked for."""


@dataclass(frozen=True)
class Column:
    """A column's name, taken apart.

    keys: lower case letters and digits of the name, of it without its last word, and of its parts.
    kind: "position", "other" (a velocity, say), or "" where it does not say.
    """

    index: int
    name: str
    keys: tuple[str, ...]
    kind: str
    unit: Unit | None


def columns_of(names: Sequence[str]) -> list[Column]:
    return [_column(i, name) for i, name in enumerate(names)]


def _column(index: int, name: str) -> Column:
    bare, unit = name.strip().lstrip("%"), None
    for found in (_UNIT.search(bare), _TAIL_UNIT.search(bare)):
        if found:
            bare = bare[: found.start()]
            unit = {"r": "radians", "d": "degrees", "°": "degrees"}.get(found[1][0].lower())
    parts = [part for part in re.split(r"[/.:\s]+", bare) if part]
    words = [word for part in parts for word in re.split(r"[_-]+", part) if word]
    last = [key(word) for word in (*words[-1:], *parts[1:])]
    kind = "other" if _OTHER_KINDS & set(last) else "position" if _POSITION & set(last) else ""
    stem = bare
    if words and key(words[-1]) in _POSITION | _OTHER_KINDS and len(words) > 1:
        stem = bare[: bare.rfind(words[-1])].rstrip("/._-: ")
    keys = [key(bare), key(stem), *map(key, parts)]
    return Column(index, name, tuple(dict.fromkeys(keys)), kind, unit)  # type: ignore[arg-type]


def key(name: str) -> str:
    """What is left of a name when its way of writing is not looked at."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def matched(columns: Sequence[Column], joints: Sequence[str], source: str) -> list[Column]:
    """The column of each joint: of exactly its name, else the only one that can be meant.

    Raises:
        InputError: a joint has no column, or more than one.
    """
    found, missing = [], []
    for joint in joints:
        exact = [column for column in columns if column.name == joint]
        if len(exact) > 1:
            raise InputError(f"{source} has more than one column for {joint}")
        alike = exact or _alike(columns, joint)
        if len(alike) > 1:
            names = " or ".join(repr(column.name[:60]) for column in alike[:3])
            raise InputError(f"{source} has more than one column for {joint}: {names}")
        found += alike
        missing += [] if alike else [joint]
    if missing:
        line = f"{source} has no column for {', '.join(missing)}"
        raise NoJoints(line) if len(missing) == len(joints) else InputError(line)
    return found


def _alike(columns: Sequence[Column], joint: str) -> list[Column]:
    wanted = key(joint)
    if not wanted:
        return []
    meant = [column for column in columns if wanted in column.keys and column.kind != "other"]
    whole = [column for column in meant if column.keys[0] == wanted]
    return whole or meant


def joint_columns(
    columns: Sequence[Column], others: Collection[int], source: str
) -> list[tuple[str, Column]]:
    """(joint, column) of all columns that move one, in their order.

    Args:
        others: columns that are known to be something else.

    Raises:
        InputError: two of them have one name.
    """
    found = []
    for column in columns:
        if column.index not in others and column.kind != "other":
            stem = _stem(column)
            found.append((stem, column))
    names = [name for name, _ in found]
    if len(set(names)) < len(names):
        found = [(column.name, column) for _, column in found]
        names = [name for name, _ in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{source} has more than one column for {', '.join(twice)}")
    return found


def _stem(column: Column) -> str:
    """The joint's name in `j1_position`."""
    if column.kind != "position":
        return column.name
    stem = re.sub(r"[/._\-: ]+(position|positions|pos|angle)$", "", column.name, flags=re.I)
    return stem or column.name


def named_for(columns: Sequence[Column], what: str) -> Iterator[Column]:
    """The columns that their names make candidates for `time`, `count` or `motion`."""
    known = {"time": _TIMES, "count": _COUNTS, "motion": _MOTIONS}[what]
    for column in columns:
        keys = column.keys
        if keys and (keys[0] in known or (len(keys) > 2 and keys[-1] in known)):
            yield column
