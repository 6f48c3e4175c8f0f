"""The one way in for motions: a file's bytes, and what was understood of them.

    bytes -> Raw (by format) -> columns -> motions in it -> clock -> unit -> the model's rate

Whatever a file leaves open is taken from what the caller says, or from its own values where they
are certain; else it is asked (`Unclear`), never guessed. What was not exact is a remark.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from ...core.csv_table import CsvTable, read_csv_bytes
from ...core.errors import InputError
from ...core.motion import MAX_CSV_BYTES, MAX_FRAMES, Motion, check_length
from ..openings import pepper_limits, pepper_openings
from ..pepper import EYE_COLUMNS
from . import ros
from .animations import WEBOTS, read_qianim, read_webots
from .columns import Column, columns_of, joint_columns, matched, named_for
from .documents import read_json
from .foreign import foreign
from .raw import Raw, Unclear, Unit
from .scripts import read_script
from .times import SAME, Clock, goes_up, is_count, resampled, stamped
from .units import Hands, Limits, angle_unit, check_said, hands_unit, hands_words, to_share

Array = NDArray[np.float64]
SUFFIXES = (".csv", ".tsv", ".txt", ".json", ".py", ".qianim", ".motion", ".yaml")
_SCRIPTS = (b"\nNAMES = [", b"names.append(", b"names = list()")  # what else would write that?
MAX_SCRIPT_BYTES = 4_000_000  # the longest motion of Pepper's joints takes 1.2 MB
MOST_ROWS = 20 * MAX_FRAMES  # of a faster recording, or of several motions
DEFAULT_FPS = 25.0  # of key frames, and of files that do not say
MOST_NAMES = 6  # in a line


@dataclass(frozen=True)
class Said:
    """What somebody says of a file; None: nothing."""

    fps: float | None = None
    unit: Unit | None = None
    hands: Hands | None = None


@dataclass(frozen=True, eq=False)
class Reading:
    """What was understood of a file.

    motions: those in it, in radians and shares, at the rate that was asked for.
    renamed: joint -> column, where the names differ. left_out: columns that are no joints.
    fps, unit: as they are in the file, and where that is known from.
    """

    format: str
    motions: tuple[Motion, ...]
    renamed: Mapping[str, str]
    left_out: tuple[str, ...]
    fps: float
    fps_source: str
    unit: Unit
    unit_source: str
    remarks: tuple[str, ...] = ()

    def motion(self, name: str | None = None) -> Motion:
        """The one of this name, or the only one.

        Raises:
            Unclear: there are several, and none is named, or one that is not there.
        """
        names = tuple(motion.name for motion in self.motions)
        if name is None and len(names) == 1:
            return self.motions[0]
        if name in names:
            return self.motions[names.index(name)]
        count = f"{len(names)} motions: {_some(names)}" if len(names) > 1 else f"one: {names[0]}"
        lead = "the file has" if name is None else f"no motion {name[:40]!r} in the file, it has"
        raise Unclear(f"{lead} {count}", "motion", names)


def read_motions(
    content: bytes,
    name: str,
    joints: tuple[str, ...] | None = None,
    *,
    said: Said | None = None,
    fps: float | None = None,
    limits: Limits | None = None,
    openings: Collection[str] | None = None,
    by: str | None = None,
) -> Reading:
    """The motions in a file.

    Args:
        name: of the file; its end tells some formats apart, and it stands in messages.
        joints: of the motions, in this order; None: all that the file moves.
        said: what somebody says of the file.
        fps: frames a second that the motions are to have; None: as in the file.
        limits: of joints, radians; openings: joints that are no angles. By default Pepper's.
        by: the column that names each row's motion, which must be there.

    Raises:
        Unclear: the file can be read in more than one way.
        InputError: no motion of these joints; the message names the row and column.
    """
    said = said or Said()
    limits = pepper_limits() if limits is None else limits
    openings = pepper_openings() if openings is None else openings
    raw = _raw(content, name, joints or (), said.fps or fps or DEFAULT_FPS, by is not None)
    chosen, groups, columns = _understood(raw, joints, by)
    if not raw.length:
        raise InputError(f"{raw.source} has a header and no frames")
    used = {column.index for _, column in chosen}
    free = [column for column in columns if column.index not in used]
    names = tuple(joint for joint, _ in chosen)
    values = np.column_stack([raw.numbers(column.index) for _, column in chosen])
    clock_of, clock_columns = _clock(raw, free, said.fps, fps)
    unit, unit_source, hands, values = _in_radians(raw, chosen, values, said, limits, openings)

    motions, clocks = [], []
    several = len(groups) > 1
    stem = _stem(name)
    for motion_name, rows in groups:
        clock = clock_of(rows)
        clocks.append(clock)
        positions = resampled(values[rows], clock, fps or clock.fps)
        check_length(len(positions), f"motion {motion_name}" if motion_name else raw.source)
        motions.append(
            Motion(motion_name or stem, names, positions.astype(np.float32), fps or clock.fps)
        )
    clock = clocks[0]
    telling = clock_columns | (
        {one.index for one in named_for(free, "motion")} if several else set()
    )
    left_out = tuple(column.name for column in free if column.index not in telling)
    renamed = {joint: column.name for joint, column in chosen if column.name != joint}
    remarks = [*raw.remarks, *_remarks(renamed, left_out, unit, unit_source, hands, raw)]
    if fps is not None and abs(clock.fps / fps - 1) >= SAME:
        remarks.append(f"{clock.fps:g} Hz ({clock.source}), resampled to {fps:g} Hz")
    remarks += [remark for one in clocks for remark in one.remarks][:MOST_NAMES]
    return Reading(
        format=raw.format,
        motions=tuple(motions),
        renamed=renamed,
        left_out=left_out,
        fps=clock.fps,
        fps_source=clock.source,
        unit=unit,
        unit_source=unit_source,
        remarks=tuple(remarks),
    )


def joints_in(content: bytes, name: str) -> tuple[str, ...]:
    """The joints that a file names, whatever their values are.

    Raises:
        InputError: none.
    """
    raw = _raw(content, name, (), DEFAULT_FPS, False)
    return tuple(joint for joint, _ in _understood(raw, None, None)[0])


def read_file(
    path: str | os.PathLike[str],
    joints: tuple[str, ...] | None = None,
    *,
    said: Said | None = None,
    fps: float | None = None,
    limits: Limits | None = None,
    openings: Collection[str] | None = None,
) -> Reading:
    """The motions in a file at a path; see `read_motions`.

    Raises:
        InputError: it cannot be read, or is no motion of these joints.
    """
    path = Path(path)
    content = read_csv_bytes(path, MAX_CSV_BYTES)
    return read_motions(
        content, path.name, joints, said=said, fps=fps, limits=limits, openings=openings
    )


def read_motion(path: str | os.PathLike[str], joints: tuple[str, ...], fps: float = 25.0) -> Motion:
    """The only motion in a file, at a rate.

    Raises:
        InputError: see `read_file`.
    """
    return read_file(path, joints, fps=fps).motion()


# --- formats ---
def _raw(content: bytes, name: str, joints: tuple[str, ...], fps: float, many: bool) -> Raw:
    suffix = PurePosixPath(name).suffix.lower()
    if not content.strip():
        raise InputError(f"{name} is empty; expected a header and one row a frame")
    other = foreign(content)
    if other:
        raise InputError(f"{name} {other}")
    start = content.lstrip(b"\xef\xbb\xbf \t\r\n")
    if content.startswith(WEBOTS.encode()):
        return read_webots(content, name)
    script = suffix == ".py" or any(mark in content[:4000] for mark in _SCRIPTS)
    animation = suffix == ".qianim" or start.startswith((b"<?xml", b"<Animation"))
    if script or animation or suffix == ".json" or re.match(rb'\{\s*"', start):
        if len(content) > MAX_SCRIPT_BYTES:
            limit = f"{MAX_SCRIPT_BYTES / 1e6:g} MB"
            raise InputError(f"{name} is too large; at most {limit} can be read")
        text = _text(content, name)
        if script:
            return read_script(text, name, fps)
        if animation:
            return read_qianim(text, name, fps)
        return read_json(text, name)
    if len(content) > MAX_CSV_BYTES and not many:
        raise InputError(f"{name} is too large; a motion has at most {MAX_CSV_BYTES / 1e6:g} MB")
    if suffix in (".yaml", ".yml", ".txt", "") and ros.is_printed(
        content[:20_000].decode("latin-1")
    ):
        return ros.read_printed(_text(content, name), name)
    return _table(content, name, joints, many)


def _text(content: bytes, name: str) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{name} is no UTF-8 text (byte {error.start})") from error


def _table(content: bytes, name: str, joints: tuple[str, ...], many: bool = False) -> Raw:
    """A table; a motion a file, or several with a column that tells them apart."""
    table = CsvTable(content, name, joints)
    remarks = () if table.encoding == "UTF-8" else (f"not UTF-8, read as {table.encoding}",)
    states = ros.read_table(table)
    if states is not None:
        return replace(states, remarks=remarks)
    cells = table.first.cells
    header = table.first_is_header(joints) or bool(joints and _names_some(cells, joints))
    rows = [] if header else [table.first]
    most = MOST_ROWS * (100 if many else 1)
    for row in table:
        if len(rows) == most:
            raise InputError(f"{name} has more than {most} rows, too many for a motion")
        rows.append(row)

    def label(column: int) -> str:
        return cells[column] if header else joints[column] if joints else str(column + 1)

    def numbers(column: int) -> Array:
        return np.array(
            [table.number(r.cells[column], f"{r.where}, column {label(column)}") for r in rows]
        )

    return Raw(
        format="CSV",
        source=name,
        names=tuple(cells) if header else None,
        length=len(rows),
        numbers=numbers,
        texts=lambda column: [row.cells[column] for row in rows],
        where=lambda row: rows[row].where,
        width=len(cells),
        remarks=remarks,
    )


def _names_some(cells: list[str], joints: tuple[str, ...]) -> bool:
    try:
        return bool(matched(columns_of(cells), joints[:1], ""))
    except InputError:
        return False


# --- columns ---
_Groups = list[tuple[str, NDArray[np.intp]]]


def _understood(
    raw: Raw, joints: tuple[str, ...] | None, by: str | None
) -> tuple[list[tuple[str, Column]], _Groups, list[Column]]:
    """The joints with their columns, the rows of each motion, and all columns."""
    everything = np.arange(raw.length)
    if raw.names is None:
        if joints is None:
            raise InputError(
                f"{raw.source} has no header; expected the names of the joints{_lafan(raw.width)}"
            )
        if raw.width != len(joints):
            raise InputError(
                f"{raw.source} has no header and {raw.width} columns; without a header there must "
                f"be exactly {len(joints)}{_lafan(raw.width)}"
            )
        columns = [Column(i, joint, (), "", None) for i, joint in enumerate(joints)]
        return list(zip(joints, columns, strict=True)), [("", everything)], columns
    columns = columns_of(raw.names)
    groups = [] if by is None else _named_groups(raw, columns, by)
    if joints is not None:
        found = matched(columns, joints, raw.source)
        chosen = list(zip(joints, found, strict=True))
    else:
        chosen = joint_columns(columns, _no_joints(raw, columns), raw.source)
        if not chosen:
            raise InputError(f"{raw.source} names no joints in its header")
    used = {column.index for _, column in chosen}
    free = [column for column in columns if column.index not in used]
    groups = groups or _groups(raw, free)
    return chosen, groups or [("", everything)], columns


def _lafan(width: int) -> str:
    """A word on what people have without names."""
    return (
        " (36 columns are a Unitree G1 with its base, as in LAFAN1; add a header with the joints' "
        "names)"
        if width == 36
        else ""
    )


def _no_joints(raw: Raw, columns: list[Column]) -> set[int]:
    """Columns that their names or words show to be no joints."""
    none = {column.index for column in columns if column.name in EYE_COLUMNS}
    for what in ("time", "count", "motion"):
        none |= {column.index for column in named_for(columns, what)}
    for column in columns:
        if column.index in none:
            continue
        cells = raw.texts(column.index)
        # A column of words is a label; a joint with a broken cell is a broken file.
        if sum(map(_is_word, cells)) > 0.5 * len(cells):
            none.add(column.index)
    return none


def _is_word(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return True
    return False


def _groups(raw: Raw, free: list[Column]) -> _Groups:
    """The rows of each motion, where a column tells several apart."""
    for column in named_for(free, "motion"):
        cells = raw.texts(column.index)
        names = list(dict.fromkeys(cells))
        if "" in names or not 1 < len(names) <= len(cells) // 2:
            continue
        of = np.array([names.index(cell) for cell in cells])
        return [(name, np.flatnonzero(of == i)) for i, name in enumerate(names)]
    return []


def _named_groups(raw: Raw, columns: list[Column], by: str) -> _Groups:
    """The rows of each motion that a column names."""
    column = next((one for one in columns if one.name == by), None)
    if column is None:
        raise InputError(
            f"{raw.source} is not REBL-Pepper's data_raw.csv, it has no column {by}; motions of "
            "one CSV file each go into a folder"
        )
    rows: dict[str, list[int]] = {}
    for i, cell in enumerate(raw.texts(column.index)):
        rows.setdefault(cell, []).append(i)
    if "" in rows:
        row = rows[""][0] + 2
        raise InputError(f"{raw.source}, row {row}, column {by}: no name of a motion")
    return [(name, np.array(of)) for name, of in rows.items()]


# --- time ---
def _clock(
    raw: Raw, columns: list[Column], said: float | None, fps: float | None
) -> tuple[Callable[[NDArray[np.intp]], Clock], set[int]]:
    """How to find the clock of some rows, and the columns that it is read from."""
    if raw.time is not None:
        times = raw.time
        return lambda rows: stamped(times[rows], f"{raw.source}, its time"), set()
    if raw.fps is not None:
        known = Clock(raw.fps, "in the file")
        return lambda rows: known, set()
    if said is not None:
        told = Clock(said, "said")
        return lambda rows: told, set()
    for column in (*named_for(columns, "time"), *named_for(columns, "count")):
        try:
            values = raw.numbers(column.index)
        except InputError:
            continue  # words: no clock
        if is_count(values) or not goes_up(values):
            continue
        where = f"{raw.source}, column {column.name or column.index + 1}"
        return lambda rows, v=values, w=where: stamped(v[rows], w), {column.index}
    assumed = Clock(fps or DEFAULT_FPS, "assumed")
    return lambda rows: assumed, set()


# --- units ---
def _in_radians(
    raw: Raw,
    chosen: list[tuple[str, Column]],
    values: Array,
    said: Said,
    limits: Limits,
    openings: Collection[str],
) -> tuple[Unit, str, Hands, Array]:
    """Unit and how it is known, the hands' unit, and the values (T, J) in radians and shares."""
    joints = [joint for joint, _ in chosen]
    values = values.copy()
    angles = [i for i, joint in enumerate(joints) if joint not in openings]
    named = {chosen[i][1].unit for i in angles} - {None}
    unit: Unit = "radians"
    source = "format"
    if raw.units is not None:
        degrees = [
            i for i, (_, column) in enumerate(chosen) if raw.units[column.index] == "degrees"
        ]
        unit = "degrees" if degrees else "radians"
        if said.unit not in (None, unit):
            raise InputError(f"{raw.source} is in {unit}, as {raw.format} files are")
    else:
        if said.unit is not None:
            unit, source = said.unit, "said"
        elif len(named) == 1:
            unit, source = named.pop() or "radians", "header"
        else:
            unit, source = angle_unit(values, joints, limits, openings, raw.where)
        degrees = angles if unit == "degrees" else []
    values[:, degrees] = np.radians(values[:, degrees])
    check_said(values, joints, openings, raw.where)
    hands: Hands = "share"
    for i, joint in enumerate(joints):
        if joint in openings and i not in degrees:
            found = said.hands or hands_unit(values[:, i], joint, raw.where)
            values[:, i] = to_share(values[:, i], found)
            hands = found if found != "share" else hands
    return unit, source, hands, values


# --- words ---
def _remarks(
    renamed: Mapping[str, str],
    left_out: tuple[str, ...],
    unit: Unit,
    unit_source: str,
    hands: Hands,
    raw: Raw,
) -> list[str]:
    lines = []
    if renamed:
        lines.append(
            "columns taken for joints: "
            + _some([f"{column} for {joint}" for joint, column in renamed.items()], 2)
        )
    eyes = set(EYE_COLUMNS)
    plain = [name for name in left_out if name and name not in eyes]
    if plain:
        lines.append(f"left out: {_some(plain)}")
    if unit == "degrees" and raw.units is None and unit_source != "said":
        lines.append(f"in degrees ({unit_source})")
    if hands != "share":
        lines.append(f"hands in {hands_words(hands)}")
    return lines


def _some(names: Collection[str], most: int = MOST_NAMES) -> str:
    shown = [name[:40] for name in list(names)[:most]]
    more = len(names) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more > 0 else "")


def _stem(name: str) -> str:
    path = PurePosixPath(name)
    return path.stem if path.suffix.lower() in SUFFIXES else name
