"""A motion, and its CSV file: one row a frame, one column a joint, radians."""

from __future__ import annotations

import csv
import io
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .errors import InputError

MAX_CSV_BYTES = 8_000_000  # ten minutes at 25 Hz with 17 joints and 48 LED columns take 7 MB
MAX_FRAMES = 5_000
MIN_FRAMES = 2
MAX_ANGLE = 4 * math.pi  # no joint turns twice around; more is degrees or rubbish


@dataclass(frozen=True)
class Motion:
    """T frames of J joints.

    positions: (T, J) float32, radians; Pepper's LHand and RHand are openings from 0 to 1.
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


def read_motion(
    path: str | os.PathLike[str],
    joints: tuple[str, ...],
    *,
    fps: float = 25.0,
    unit: Literal["radians", "degrees"] = "radians",
) -> Motion:
    """Read one motion from a CSV file; see `parse_motion`.

    Raises:
        InputError: the file cannot be read, or its content is not a motion.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAX_CSV_BYTES:
            raise InputError(f"{path} is larger than {MAX_CSV_BYTES} bytes")
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    return parse_motion(content, joints, name=path.stem, source=path.name, fps=fps, unit=unit)


def parse_motion(
    content: bytes,
    joints: tuple[str, ...],
    *,
    name: str,
    source: str,
    fps: float = 25.0,
    unit: Literal["radians", "degrees"] = "radians",
) -> Motion:
    """Parse the bytes of a CSV file as a motion of the given joints.

    With a header, columns go by name in any order and other columns (an index, LEDs) are ignored;
    without one there must be exactly one column a joint, in the order of `joints`. UTF-8 with or
    without BOM; comma, semicolon or tab.

    Args:
        source: what to call the file in messages.

    Raises:
        InputError: not a motion; the message names the row (as an editor counts lines) and column.
    """
    if len(content) > MAX_CSV_BYTES:
        raise InputError(f"{source} is larger than {MAX_CSV_BYTES} bytes")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{source} is not UTF-8 text (byte {error.start})") from error
    first = text.partition("\n")[0]
    delimiter = max(",;\t", key=first.count)
    try:
        rows = [
            (number, [cell.strip() for cell in row])
            for number, row in enumerate(csv.reader(io.StringIO(text), delimiter=delimiter), 1)
            if any(cell.strip() for cell in row)
        ]
    except csv.Error as error:
        raise InputError(f"{source} is not a CSV file: {error}") from error
    if not rows:
        raise InputError(f"{source} is empty; expected a header and one row a frame")

    header = rows[0][1]
    if any(cell and not _is_number(cell) for cell in header):
        missing = [joint for joint in joints if joint not in header]
        if missing:
            raise InputError(f"{source} has no column for {', '.join(missing)}")
        columns = [header.index(joint) for joint in joints]
        rows = rows[1:]
    elif len(header) == len(joints):
        columns = list(range(len(joints)))
    else:
        raise InputError(
            f"{source} has no header and {len(header)} columns; "
            f"without a header there must be exactly {len(joints)}"
        )
    width = len(header)

    if not MIN_FRAMES <= len(rows) <= MAX_FRAMES:
        raise InputError(
            f"{source} has {len(rows)} frames; a motion has from {MIN_FRAMES} to {MAX_FRAMES}"
        )
    limit = MAX_ANGLE if unit == "radians" else math.degrees(MAX_ANGLE)
    positions = np.empty((len(rows), len(joints)), dtype=np.float32)
    for frame, (number, row) in enumerate(rows):
        if len(row) != width:
            raise InputError(f"{source}, row {number}: {len(row)} columns, expected {width}")
        for joint, column in enumerate(columns):
            positions[frame, joint] = _cell(row[column], source, number, joints[joint], limit)
    if unit == "degrees":
        positions = np.radians(positions)
    return Motion(name, joints, positions, fps)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _cell(cell: str, source: str, row: int, column: str, limit: float) -> float:
    try:
        value = float(cell)
    except ValueError:
        raise InputError(
            f"{source}, row {row}, column {column}: {cell[:20]!r} is no number"
        ) from None
    if not math.isfinite(value):
        raise InputError(f"{source}, row {row}, column {column}: {cell} is not finite")
    if abs(value) > limit:
        raise InputError(
            f"{source}, row {row}, column {column}: {value:g} is no plausible angle "
            f"(at most {limit:.3g}); is the file in degrees?"
        )
    return value


def format_motion(motion: Motion) -> str:
    """The motion as CSV text: header of joint names, one row a frame, radians."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(motion.joints)
    writer.writerows([f"{value:.9g}" for value in row] for row in motion.positions)
    return out.getvalue()


def write_motion(motion: Motion, path: str | os.PathLike[str]) -> None:
    """Write the motion as a CSV file that `read_motion` gives back to the bit."""
    Path(path).write_text(format_motion(motion), encoding="utf-8")
