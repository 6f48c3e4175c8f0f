"""A motion, and its CSV file: one row a frame, one column a joint, radians."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .csv_table import CsvTable, Unit, read_csv_bytes
from .errors import InputError
from .files import replacing

MAX_CSV_BYTES = 8_000_000  # ten minutes at 25 Hz with 17 joints and 48 LED columns take 7 MB
MAX_FRAMES = 5_000
MIN_FRAMES = 2


@dataclass(frozen=True)
class Motion:
    """T frames of J joints.

    positions: (T, J) float32, radians; a hand's opening goes from 0 to 1.
    """

    name: str
    joints: tuple[str, ...]
    positions: NDArray[np.float32]
    fps: float = 25.0

    def __post_init__(self) -> None:
        if self.positions.ndim != 2 or self.positions.shape[1] != len(self.joints):
            raise InputError(
                f"motion {self.name!r} has positions of shape {self.positions.shape} "
                f"for {len(self.joints)} joints"
            )

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True)
class MotionLabel:
    """What is known of a training motion besides its frames."""

    behavior_class: str  # the emotion in its name: Happy_4_tr -> Happy
    valence: float | None = None
    arousal: float | None = None


def read_motion(
    path: str | os.PathLike[str],
    joints: tuple[str, ...],
    *,
    fps: float = 25.0,
    unit: Unit = "radians",
    openings: Collection[str] = frozenset(),
) -> Motion:
    """Read one motion from a CSV file; see `parse_motion`.

    Raises:
        InputError: the file cannot be read, or its content is not a motion.
    """
    path = Path(path)
    content = read_csv_bytes(path, MAX_CSV_BYTES)
    return parse_motion(
        content, joints, name=path.stem, source=path.name, fps=fps, unit=unit, openings=openings
    )


def parse_motion(
    content: bytes,
    joints: tuple[str, ...],
    *,
    name: str,
    source: str = "the file",
    fps: float = 25.0,
    unit: Unit = "radians",
    openings: Collection[str] = frozenset(),
) -> Motion:
    """A motion from the bytes of a CSV file.

    With a header the columns go by name, in any order, and others (an index, eye LEDs) are ignored.
    Without a header there must be exactly one column a joint, in the order of `joints`. UTF-8 with
    or without BOM; comma, semicolon or tab.

    Args:
        source: what to call the file in messages.
        unit: of the file's angles; the motion's are radians.
        openings: joints that are no angles but shares from 0 to 1, in any unit.

    Raises:
        InputError: not a motion; the message names the row (as an editor counts lines) and column.
    """
    if len(content) > MAX_CSV_BYTES:
        raise InputError(f"{source} is too large; a motion has at most {MAX_CSV_BYTES / 1e6:g} MB")
    table = CsvTable(content, source, joints)
    frames: list[list[float]] = []
    if table.first_is_header(joints):
        columns = table.columns(joints)
    elif len(table.first.cells) == len(joints):
        columns = list(range(len(joints)))
        frames.append(table.values(table.first, columns, joints, unit, openings))
    else:
        raise InputError(
            f"{source} has no header and {len(table.first.cells)} columns; "
            f"without a header there must be exactly {len(joints)}"
        )
    for row in table:
        if len(frames) == MAX_FRAMES:
            raise InputError(f"{source} has more than {MAX_FRAMES} frames, too many for a motion")
        frames.append(table.values(row, columns, joints, unit, openings))
    check_length(len(frames), source)
    positions = np.array(frames)
    if unit == "degrees":
        angles = [joint not in openings for joint in joints]
        positions[:, angles] = np.radians(positions[:, angles])
    return Motion(name, joints, positions.astype(np.float32), fps)


def check_length(frames: int, what: str) -> None:
    """
    Raises:
        InputError: too short or too long for a motion.
    """
    if not MIN_FRAMES <= frames <= MAX_FRAMES:
        count = "1 frame" if frames == 1 else f"{frames} frames"
        raise InputError(f"{what} has {count}; a motion has from {MIN_FRAMES} to {MAX_FRAMES}")


def format_motion(motion: Motion) -> str:
    """The motion as CSV text: header of joint names, one row a frame, radians."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(motion.joints)
    # Nine significant digits determine a float32.
    writer.writerows([f"{value:.9g}" for value in row] for row in motion.positions.tolist())
    return out.getvalue()


def write_motion(motion: Motion, path: str | os.PathLike[str]) -> None:
    """Write the motion as a CSV file that `read_motion` gives back to the bit.

    Raises:
        InputError: the file cannot be written; one that was there is as it was.
    """
    text = format_motion(motion)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="")
