"""Training motions: REBL-Pepper as published, or a folder of one CSV file a motion.

REBL-Pepper: M. Marmpena, F. Garcia, A. Lim, N. Hemion, T. Wennekers, "Data-driven emotional body
language generation for social robotics", CC BY 4.0. Section IV.A of the paper uses it with each
posture mirrored, 72 motions in all.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..core.csv_table import CsvTable, read_csv_bytes
from ..core.data import (
    MIRROR_SUFFIX,
    Dataset,
    labels_beside,
    load_folder,
    motion_files,
    named_joints,
)
from ..core.errors import InputError
from ..core.motion import Motion, check_length
from .openings import pepper_openings
from .pepper import EYE_COLUMNS, PEPPER_JOINTS, mirror

REBL_PEPPER_FPS = 25.0
MAX_DATA_BYTES = 100_000_000


def load_dataset(path: str | os.PathLike[str], joints: tuple[str, ...] | None = None) -> Dataset:
    """Load REBL-Pepper's `data_raw.csv` (mirrored to 72 motions) or a folder of CSV files.

    Args:
        path: the file, the folder that holds `data_raw.csv`, or a folder of one CSV a motion.
        joints: the joints to read from a folder's files. By default Pepper's where the first file
            has them all, else all its named columns that are no index.

    Raises:
        InputError: nothing there, or a file that is not what it should be.
    """
    path = Path(path)
    try:
        if path.is_dir():
            for folder in (path, path / "original_animations"):  # as in the published repository
                if (folder / "data_raw.csv").is_file():
                    return _load_rebl_pepper(folder / "data_raw.csv")
            return load_folder(path, joints or _joints(path), pepper_openings())
        if path.is_file():
            return _load_rebl_pepper(path)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    raise InputError(f"no data at {path}; give REBL-Pepper's data_raw.csv or a folder of CSV files")


def _joints(folder: Path) -> tuple[str, ...]:
    """Pepper's joints where a folder's first file has them all, else all that it names."""
    named = named_joints(motion_files(folder)[0], EYE_COLUMNS)
    return PEPPER_JOINTS if set(PEPPER_JOINTS) <= set(named) else named


def _load_rebl_pepper(path: Path) -> Dataset:
    table = CsvTable(read_csv_bytes(path, MAX_DATA_BYTES), path.name, ("id", *PEPPER_JOINTS))
    if "id" not in table.first.cells:
        raise InputError(
            f"{path.name} is not REBL-Pepper's data_raw.csv, it has no column id; motions of one "
            "CSV file each go into a folder"
        )
    [name_column, *columns] = table.columns(("id", *PEPPER_JOINTS))
    frames: dict[str, list[list[float]]] = {}
    openings = pepper_openings()
    for row in table:
        name = row.cells[name_column]
        if not name:
            raise InputError(f"{row.where}, column id: no name of a motion")
        values = table.values(row, columns, PEPPER_JOINTS, openings=openings)
        frames.setdefault(name, []).append(values)
    if not frames:
        raise InputError(f"{path.name} has a header and no frames")
    for name, rows in frames.items():
        check_length(len(rows), f"{path.name}, motion {name}")
    motions = [
        Motion(name, PEPPER_JOINTS, np.array(rows, dtype=np.float32), REBL_PEPPER_FPS)
        for name, rows in frames.items()
    ]
    # The published data_augmented.csv has the mirrored motions already.
    motions += [mirror(m) for m in motions if not _mirrored(m.name, frames)]
    motions.sort(key=lambda motion: motion.name)
    return Dataset(
        tuple(motions),
        labels_beside(path.parent, [motion.name for motion in motions]),
        attribution="REBL-Pepper, M. Marmpena et al., CC BY 4.0; mirrored",
    )


def _mirrored(name: str, names: Iterable[str]) -> bool:
    return name.endswith(MIRROR_SUFFIX) or name + MIRROR_SUFFIX in names
