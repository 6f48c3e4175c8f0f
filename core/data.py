"""Training motions: REBL-Pepper as published, or a folder of one CSV file a motion.

REBL-Pepper: M. Marmpena, F. Garcia, A. Lim, N. Hemion, T. Wennekers, "Data-driven emotional body
language generation for social robotics", CC BY 4.0. Section IV.A of the paper uses it with each
posture mirrored, 72 motions in all.
"""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import InputError
from .model import MotionLabel
from .motion import MAX_ANGLE, Motion, read_motion

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
# Joints whose axis lies in or normal to the sagittal plane turn the other way in a mirror.
_SIGN_FLIPPED = {"HeadYaw", "HipRoll"} | {
    side + joint for side in "LR" for joint in ("ShoulderRoll", "ElbowRoll", "ElbowYaw", "WristYaw")
}
MIRROR_SUFFIX = "_tr"


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


def load_dataset(
    path: str | os.PathLike[str], joints: tuple[str, ...] | None = None
) -> Dataset:
    """Load REBL-Pepper's `data_raw.csv` (mirrored to 72 motions) or a folder of CSV files.

    Args:
        path: the file, the folder that holds `data_raw.csv`, or a folder of one CSV a motion.
        joints: the joints to read from a folder's files; by default the header of its first file,
            less an index column.

    Raises:
        InputError: nothing there, or a file that is not what it should be.
    """
    path = Path(path)
    if path.is_dir():
        original = path / "data_raw.csv"
        return _load_rebl_pepper(original) if original.is_file() else _load_folder(path, joints)
    if path.is_file():
        return _load_rebl_pepper(path)
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


_TWIN = {"L": "R", "R": "L"}


def behavior_class(name: str) -> str:
    """The emotion in a REBL-Pepper name: `Happy_4_tr` -> `Happy`."""
    return re.sub(r"(_\d+)?(_tr)?$", "", name)


def _load_rebl_pepper(path: Path) -> Dataset:
    frames: dict[str, list[list[float]]] = {}
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.DictReader(file)
        missing = {"id", *PEPPER_JOINTS} - set(reader.fieldnames or ())
        if missing:
            raise InputError(
                f"{path.name} is not REBL-Pepper's data_raw.csv: no column "
                + ", ".join(sorted(missing))
            )
        for row in reader:
            try:
                values = [float(row[joint]) for joint in PEPPER_JOINTS]
            except (TypeError, ValueError) as error:
                raise InputError(f"{path.name}, row {reader.line_num}: {error}") from error
            if not np.all(np.abs(values) < MAX_ANGLE):  # false for NaN, too
                raise InputError(f"{path.name}, row {reader.line_num}: no plausible angles")
            frames.setdefault(row["id"], []).append(values)
    originals = [
        Motion(name, PEPPER_JOINTS, np.array(rows, dtype=np.float32), REBL_PEPPER_FPS)
        for name, rows in frames.items()
    ]
    motions = sorted([*originals, *map(mirror, originals)], key=lambda motion: motion.name)
    return Dataset(
        tuple(motions),
        _labels(path.with_name("labels_augmented.csv"), [motion.name for motion in motions]),
        attribution="REBL-Pepper, M. Marmpena et al., CC BY 4.0; mirrored",
    )


def _load_folder(path: Path, joints: tuple[str, ...] | None) -> Dataset:
    files = sorted(path.glob("*.csv"), key=lambda file: file.stem)
    if not files:
        raise InputError(f"no CSV file in {path}")
    if joints is None:
        with files[0].open(encoding="utf-8-sig", newline="") as file:
            header = file.readline()
        cells = next(csv.reader([header], delimiter=max(",;\t", key=header.count)), [])
        joints = tuple(cell.strip() for cell in cells if cell.strip())
        if any(re.fullmatch(r"[-+.\deE]+", joint) for joint in joints):
            raise InputError(f"{files[0].name} has no header of joint names")
    motions = tuple(read_motion(file, joints) for file in files)
    names = [motion.name for motion in motions]
    return Dataset(motions, {name: MotionLabel(behavior_class(name)) for name in names})


def _labels(path: Path, names: list[str]) -> dict[str, MotionLabel]:
    """Valence and arousal from the label file that lies beside the data, where it does."""
    labels = {name: MotionLabel(behavior_class(name)) for name in names}
    if path.is_file():
        with path.open(encoding="utf-8-sig", newline="") as file:
            for row in csv.DictReader(file):
                if row["id"] in labels:
                    labels[row["id"]] = MotionLabel(
                        behavior_class(row["id"]), float(row["valence"]), float(row["arousal"])
                    )
    return labels
