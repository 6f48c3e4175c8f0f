"""Training motions: REBL-Pepper as published, or a folder of one CSV file a motion.

REBL-Pepper: M. Marmpena, F. Garcia, A. Lim, N. Hemion, T. Wennekers, "Data-driven emotional body
language generation for social robotics", CC BY 4.0. Section IV.A of the paper uses it with each
posture mirrored, 72 motions in all.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .csv_table import CsvTable, Row, read_csv_bytes
from .errors import InputError
from .motion import MAX_CSV_BYTES, Motion, MotionLabel, check_length, read_motion

if TYPE_CHECKING:
    from .model import RNNPB

REBL_PEPPER_FPS = 25.0
PEPPER_JOINTS = (
    "HeadPitch",
    "HeadYaw",
    "HipPitch",
    "HipRoll",
    "KneePitch",
    "LElbowRoll",
    "LElbowYaw",
    "LHand",
    "LShoulderPitch",
    "LShoulderRoll",
    "LWristYaw",
    "RElbowRoll",
    "RElbowYaw",
    "RHand",
    "RShoulderPitch",
    "RShoulderRoll",
    "RWristYaw",
)
EYE_LEDS = 8  # around each eye; a column each for the intensities of red, green and blue
EYE_COLUMNS = tuple(f"{side}{led}{c}" for side in "RL" for led in range(EYE_LEDS) for c in "RGB")
# Joints whose axis lies in or normal to the sagittal plane turn the other way in a mirror.
_SIGN_FLIPPED = {"HeadYaw", "HipRoll"} | {
    side + joint for side in "LR" for joint in ("ShoulderRoll", "ElbowRoll", "ElbowYaw", "WristYaw")
}
_TWIN = {"L": "R", "R": "L"}
MIRROR_SUFFIX = "_tr"
MAX_DATA_BYTES = 100_000_000
_Ratings = tuple[float | None, float | None]  # valence, arousal; None where nobody has rated
LABEL_FILES = ("labels_augmented.csv", "labels_raw.csv", "labels.csv")
# Columns of a folder's files that count frames or name the motion instead of moving a joint.
_NO_JOINTS = {"", "id", "index", "frame", "time", "timestamp", "t", "unnamed: 0"}


@dataclass(frozen=True)
class Dataset:
    """Motions sorted by name, which is the order of a model's learned PBs."""

    motions: tuple[Motion, ...]
    labels: dict[str, MotionLabel]
    attribution: str = ""

    @property
    def joints(self) -> tuple[str, ...]:
        return self.motions[0].joints

    @property
    def fps(self) -> float:
        return self.motions[0].fps

    @property
    def sha256(self) -> str:
        """A fingerprint of names and values, whatever file they came from."""
        digest = hashlib.sha256()
        for motion in self.motions:
            digest.update(repr((motion.name, motion.joints, motion.positions.shape)).encode())
            digest.update(np.ascontiguousarray(motion.positions, dtype="<f4").tobytes())
        return digest.hexdigest()

    def for_model(self, model: RNNPB) -> Dataset:
        """The motions that the model has learned, in the order of its PBs.

        A model that knows its motions' names gets them by name; a published one, which does not,
        by the order of the names.

        Raises:
            InputError: other joints, or not the motions that the model has learned.
        """
        joints = model.info.joints
        missing = [joint for joint in joints if joint not in self.joints]
        if missing:
            raise InputError(f"the data have no joint {', '.join(missing)}, which the model moves")
        by_name = {motion.name: motion for motion in self.motions}
        names = model.info.motions or tuple(by_name)
        absent = [name for name in names if name not in by_name]
        if absent:
            raise InputError(f"the data lack motions the model has learned: {', '.join(absent)}")
        if len(names) != model.config.num_motions:
            raise InputError(
                f"the data have {len(names)} motions, the model has learned "
                f"{model.config.num_motions} and does not say their names"
            )
        order = [self.joints.index(joint) for joint in joints]
        motions = tuple(
            Motion(name, joints, by_name[name].positions[:, order], by_name[name].fps)
            for name in names
        )
        labels = {name: self.labels[name] for name in names if name in self.labels}
        return Dataset(motions, labels, self.attribution)


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
            return _load_folder(path, joints)
        if path.is_file():
            return _load_rebl_pepper(path)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    raise InputError(f"no data at {path}; give REBL-Pepper's data_raw.csv or a folder of CSV files")


def mirror(motion: Motion) -> Motion:
    """The motion of Pepper as in a mirror: arms swapped, sideways turns reversed."""
    index = {joint: i for i, joint in enumerate(motion.joints)}
    mirrored = np.empty_like(motion.positions)
    for joint, column in index.items():
        twin = _TWIN.get(joint[0], joint[0]) + joint[1:]
        values = motion.positions[:, index.get(twin, column)]
        mirrored[:, column] = -values if joint in _SIGN_FLIPPED else values
    return Motion(motion.name + MIRROR_SUFFIX, motion.joints, mirrored, motion.fps)


def behavior_class(name: str) -> str:
    """The emotion in a REBL-Pepper name: `Happy_4_tr` -> `Happy`."""
    return re.sub(r"(_\d+)?(_tr)?$", "", name)


def _load_rebl_pepper(path: Path) -> Dataset:
    table = CsvTable(read_csv_bytes(path, MAX_DATA_BYTES), path.name, ("id", *PEPPER_JOINTS))
    if "id" not in table.first.cells:
        raise InputError(
            f"{path.name} is not REBL-Pepper's data_raw.csv, it has no column id; motions of one "
            "CSV file each go into a folder"
        )
    [name_column, *columns] = table.columns(("id", *PEPPER_JOINTS))
    frames: dict[str, list[list[float]]] = {}
    for row in table:
        name = row.cells[name_column]
        if not name:
            raise InputError(f"{row.where}, column id: no name of a motion")
        frames.setdefault(name, []).append(table.values(row, columns, PEPPER_JOINTS))
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
        _labels(path.parent, [motion.name for motion in motions]),
        attribution="REBL-Pepper, M. Marmpena et al., CC BY 4.0; mirrored",
    )


def _mirrored(name: str, names: Iterable[str]) -> bool:
    return name.endswith(MIRROR_SUFFIX) or name + MIRROR_SUFFIX in names


def _load_folder(path: Path, joints: tuple[str, ...] | None) -> Dataset:
    files = sorted(
        (
            file
            for file in path.iterdir()
            if file.suffix.lower() == ".csv"
            and not file.name.startswith(".")
            and file.name not in LABEL_FILES
        ),
        key=lambda file: file.stem,
    )
    if not files:
        raise InputError(f"no CSV file in {path}; expected one a motion")
    names = [file.stem for file in files]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InputError(f"{path} has more than one file for {', '.join(sorted(twice))}")
    joints = joints or _joints(files[0])
    motions = tuple(read_motion(file, joints, fps=REBL_PEPPER_FPS) for file in files)
    return Dataset(motions, _labels(path, names))


def _joints(file: Path) -> tuple[str, ...]:
    """The joints that a motion file names in its header."""
    table = CsvTable(read_csv_bytes(file, MAX_CSV_BYTES), file.name, PEPPER_JOINTS)
    if not table.first_is_header(PEPPER_JOINTS):
        raise InputError(f"{file.name} has no header; expected the names of the joints")
    names = table.first.cells
    if set(PEPPER_JOINTS) <= set(names):
        return PEPPER_JOINTS
    joints = tuple(n for n in names if n.lower() not in _NO_JOINTS and n not in EYE_COLUMNS)
    if not joints:
        raise InputError(f"{file.name} names no joints in its header")
    return joints


def _labels(folder: Path, names: list[str]) -> dict[str, MotionLabel]:
    """Valence and arousal from the label file that lies beside the data, where it does."""
    path = next((folder / name for name in LABEL_FILES if (folder / name).is_file()), None)
    rated = {} if path is None else _read_labels(path)
    unknown: _Ratings = (None, None)
    labels = {}
    for name in names:
        # A mirrored motion expresses what its original does.
        ratings = rated.get(name) or rated.get(name.removesuffix(MIRROR_SUFFIX)) or unknown
        labels[name] = MotionLabel(behavior_class(name), *ratings)
    return labels


def _read_labels(path: Path) -> dict[str, _Ratings]:
    table = CsvTable(read_csv_bytes(path, MAX_CSV_BYTES), path.name, ("id", "valence", "arousal"))
    names, valences, arousals = table.columns(("id", "valence", "arousal"))

    def rating(row: Row, column: int) -> float | None:
        cell = row.cells[column]
        where = f"{row.where}, column {table.first.cells[column]}"
        return table.number(cell, where) if cell else None

    return {row.cells[names]: (rating(row, valences), rating(row, arousals)) for row in table}
