"""Eye-LED colours: 8 segments around each eye, as REBL-Pepper's files carry them.

Columns `R0R, R0G, R0B, L0R, ... L7B` hold intensities from 0 to 1. LED 0 is the first from the top
towards the nose, and they go on round that way on both sides, so that equal colours look symmetric
(NAOqi's groups: 7 and 0 top, 1 and 2 inside, 3 and 4 bottom, 5 and 6 outside).
"""

from __future__ import annotations

import csv
import io
import os

import numpy as np
from numpy.typing import NDArray

from ..core.errors import InputError

LEDS = 8  # an eye
EYE_COLUMNS = tuple(f"{side}{led}{c}" for side in "RL" for led in range(LEDS) for c in "RGB")


def parse_eye_colors(content: bytes, source: str) -> NDArray[np.float32] | None:
    """The eye colours in the bytes of a motion CSV file, next to the joints.

    Returns:
        (T, 2, 8, 3): frame, right eye and left eye, LED, RGB from 0 to 1; None without LED columns.

    Raises:
        InputError: some LED columns are there and others are not, or a cell is no intensity.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{source} is not UTF-8 text (byte {error.start})") from error
    first = text.partition("\n")[0]
    rows = csv.reader(io.StringIO(text), delimiter=max(",;\t", key=first.count))
    header = [cell.strip() for cell in next(rows, [])]
    missing = [column for column in EYE_COLUMNS if column not in header]
    if len(missing) == len(EYE_COLUMNS):
        return None
    if missing:
        raise InputError(f"{source} has some eye-LED columns, but not {', '.join(missing[:6])}")
    columns = [header.index(column) for column in EYE_COLUMNS]
    frames: list[list[float]] = []
    for row in rows:
        if any(cell.strip() for cell in row):
            frames.append(_intensities(row, columns, f"{source}, row {rows.line_num}"))
    return np.array(frames, dtype=np.float32).reshape(-1, 2, LEDS, 3)


def _intensities(row: list[str], columns: list[int], where: str) -> list[float]:
    values = []
    for name, column in zip(EYE_COLUMNS, columns, strict=True):
        cell = row[column].strip() if column < len(row) else ""
        try:
            value = float(cell)
        except ValueError:
            raise InputError(f"{where}, column {name}: {cell[:20]!r} is no number") from None
        if not 0 <= value <= 1:  # false for NaN, too
            raise InputError(f"{where}, column {name}: {cell} is no intensity from 0 to 1")
        values.append(value)
    return values


def load_rebl_pepper_eyes(path: str | os.PathLike[str]) -> dict[str, NDArray[np.float32]]:
    """The eye colours of every motion in REBL-Pepper's `data_raw.csv`, mirrored ones included.

    Returns:
        motion name -> (T, 2, 8, 3), as `parse_eye_colors`; empty when the file has no LED columns.
    """
    names: list[str] = []
    frames: list[list[float]] = []
    with open(path, encoding="utf-8-sig", newline="") as file:
        rows = csv.reader(file)
        header = [cell.strip() for cell in next(rows, [])]
        if not {"id", *EYE_COLUMNS} <= set(header):
            return {}
        name, columns = header.index("id"), [header.index(column) for column in EYE_COLUMNS]
        for row in rows:
            names.append(row[name])
            frames.append(_intensities(row, columns, f"row {rows.line_num}"))
    colors = np.array(frames, dtype=np.float32).reshape(-1, 2, LEDS, 3)
    labels = np.array(names)
    tracks = {label: colors[labels == label] for label in dict.fromkeys(names)}
    return tracks | {f"{label}_tr": track[:, ::-1] for label, track in tracks.items()}
