"""The one way in for motions: a file's bytes, and what was understood of them.

    bytes -> Raw (by format) -> columns -> motions in it -> clock -> unit -> the model's rate

Whatever a file leaves open is taken from what the caller says, or from its own values where they
are certain; else it is asked (`Unclear`), never guessed. What was not exact is a remark.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.csv_table import read_csv_bytes
from ...core.errors import InputError
from ...core.motion import MAX_CSV_BYTES, Motion, check_length
from ..openings import pepper_limits, pepper_openings
from ..pepper import EYE_COLUMNS
from .columns import named_for
from .files import SUFFIXES, raw_of
from .layout import layout
from .raw import Unclear, Unit
from .times import SAME, clocks, resampled
from .units import Hands, Limits, Units, hands_words, in_radians

DEFAULT_FPS = 25.0  # of key frames, and of files that do not say
MOST_NAMES = 6  # in a line
MOST_REMARKS = 8


@dataclass(frozen=True)
class Said:
    """What somebody says of a file; None: nothing."""

    fps: float | None = None
    unit: Unit | None = None
    hands: Hands | None = None


NOTHING_SAID = Said()


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
    raw = raw_of(content, name, joints or (), said.fps or fps or DEFAULT_FPS, by is not None)
    found = layout(raw, joints, by)
    if not raw.length:
        raise InputError(f"{raw.source} has a header and no frames")
    names = tuple(joint for joint, _ in found.joints)
    values = np.column_stack([raw.numbers(column.index) for _, column in found.joints])
    clock_of, stamps = clocks(raw, found.free, said.fps, fps or DEFAULT_FPS)
    told = said.unit, said.hands
    units, values = in_radians(raw, found.joints, values, told, limits, openings)

    motions, remarks = [], list(raw.remarks)
    for motion, rows in found.motions:
        clock = clock_of(rows)
        remarks += [one for one in clock.remarks if len(remarks) < MOST_REMARKS]
        positions = resampled(values[rows], clock, fps or clock.fps)
        check_length(len(positions), f"motion {motion}" if motion else raw.source)
        title = motion or _stem(name)
        motions.append(Motion(title, names, positions.astype(np.float32), fps or clock.fps))
    first = clock_of(found.motions[0][1])
    if fps is not None and abs(first.fps / fps - 1) >= SAME:
        remarks.append(f"{first.fps:g} Hz ({first.source}), resampled to {fps:g} Hz")
    telling = {one.index for one in named_for(found.free, "motion") if len(motions) > 1} | stamps
    left_out = tuple(column.name for column in found.free if column.index not in telling)
    renamed = {joint: column.name for joint, column in found.joints if column.name != joint}
    remarks += _remarks(renamed, left_out, units, raw.units is not None)
    return Reading(
        format=raw.format,
        motions=tuple(motions),
        renamed=renamed,
        left_out=left_out,
        fps=first.fps,
        fps_source=first.source,
        unit=units.unit,
        unit_source=units.source,
        remarks=tuple(remarks),
    )


def joints_in(content: bytes, name: str) -> tuple[str, ...]:
    """The joints that a file names, whatever their values are.

    Raises:
        InputError: none.
    """
    raw = raw_of(content, name, (), DEFAULT_FPS)
    return tuple(joint for joint, _ in layout(raw, None).joints)


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


# --- words ---
def _remarks(
    renamed: Mapping[str, str],
    left_out: tuple[str, ...],
    units: Units,
    by_format: bool,
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
    if units.unit == "degrees" and not by_format and units.source != "said":
        lines.append(f"in degrees ({units.source})")
    if units.hands != "share":
        lines.append(f"hands in {hands_words(units.hands)}")
    return lines


def _some(names: Collection[str], most: int = MOST_NAMES) -> str:
    shown = [name[:40] for name in list(names)[:most]]
    more = len(names) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more > 0 else "")


def _stem(name: str) -> str:
    """The name without its end; of an upload it may hold anything, slashes too."""
    end = next((suffix for suffix in SUFFIXES if name.lower().endswith(suffix)), "")
    return name[: len(name) - len(end)]
