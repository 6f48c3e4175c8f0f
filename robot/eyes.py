"""Eye-LED colours: 8 segments around each eye, as REBL-Pepper's files carry them.

Columns `R0R, R0G, R0B, L0R, ... L7B` hold intensities from 0 to 1. LED 0 is the first from the top
towards the nose, and they go on round that way on both sides, so that equal colours look symmetric
(NAOqi's groups: 7 and 0 top, 1 and 2 inside, 3 and 4 bottom, 5 and 6 outside).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..core.csv_table import CsvTable, Row, read_csv_bytes
from ..core.data import MIRROR_SUFFIX
from ..core.errors import InputError
from ..core.motion import MAX_CSV_BYTES
from .data import MAX_DATA_BYTES
from .pepper import EYE_COLUMNS, EYE_LEDS


def parse_eye_colors(content: bytes, source: str = "the file") -> NDArray[np.float32] | None:
    """The eye colours in the bytes of a motion's CSV file, where it has them next to the joints.

    Returns:
        (T, 2, 8, 3): frame, right eye and left eye, LED, RGB from 0 to 1; None without LED columns.

    Raises:
        InputError: some LED columns are there and others are not, or a cell is no intensity.
    """
    table = CsvTable(content, source)
    if not set(EYE_COLUMNS) & set(table.first.cells):
        return None
    columns = table.columns(EYE_COLUMNS)
    return _track([_intensities(table, row, columns) for row in table])


def load_eyes(path: str | Path) -> dict[str, NDArray[np.float32]]:
    """The eye colours of the motions that `core.data.load_dataset` finds at a path.

    Returns:
        motion name -> (T, 2, 8, 3), of those that have LED columns.

    Raises:
        InputError: as `parse_eye_colors`.
    """
    path = Path(path)
    for folder in (path, path / "original_animations"):
        if path.is_file() or (folder / "data_raw.csv").is_file():
            return load_rebl_pepper_eyes(folder)
    tracks = {}
    for file in sorted(path.glob("*.csv")):
        track = parse_eye_colors(read_csv_bytes(file, MAX_CSV_BYTES), file.name)
        if track is not None:
            tracks[file.stem] = track
    return tracks


def load_rebl_pepper_eyes(path: str | Path) -> dict[str, NDArray[np.float32]]:
    """The eye colours of every motion in REBL-Pepper's `data_raw.csv`, mirrored ones included.

    Args:
        path: the file, or the folder that holds it.

    Returns:
        motion name -> (T, 2, 8, 3), as `parse_eye_colors`; empty when there are no LED columns.

    Raises:
        InputError: no such file, or not what it should be.
    """
    path = Path(path)
    path = path / "data_raw.csv" if path.is_dir() else path
    table = CsvTable(read_csv_bytes(path, MAX_DATA_BYTES), path.name, ("id", *EYE_COLUMNS))
    if not {"id", *EYE_COLUMNS} <= set(table.first.cells):
        return {}
    [name, *columns] = table.columns(("id", *EYE_COLUMNS))
    frames: dict[str, list[list[float]]] = {}
    for row in table:
        frames.setdefault(row.cells[name], []).append(_intensities(table, row, columns))
    tracks = {motion: _track(rows) for motion, rows in frames.items()}
    mirrored = {motion + MIRROR_SUFFIX: track[:, ::-1] for motion, track in tracks.items()}
    return mirrored | tracks


def _intensities(table: CsvTable, row: Row, columns: Sequence[int]) -> list[float]:
    values = [
        table.number(row.cells[column], f"{row.where}, column {name}")
        for column, name in zip(columns, EYE_COLUMNS, strict=True)
    ]
    for column, value in zip(EYE_COLUMNS, values, strict=True):
        if not 0 <= value <= 1:
            raise InputError(f"{row.where}, column {column}: {value:g} is no intensity (0 to 1)")
    return values


def _track(frames: list[list[float]]) -> NDArray[np.float32]:
    return np.array(frames, dtype=np.float32).reshape(-1, 2, EYE_LEDS, 3)
