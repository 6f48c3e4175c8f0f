"""Training motions and what is known of them."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .csv_table import CsvTable, Row, read_csv_bytes
from .errors import InputError
from .motion import MAX_CSV_BYTES, Motion, MotionLabel

if TYPE_CHECKING:
    from .model import RNNPB, ModelInfo

MIRROR_SUFFIX = "_tr"  # of the name of a motion that is another one as in a mirror
_Ratings = tuple[float | None, float | None]  # valence, arousal; None where nobody has rated
LABEL_FILES = ("labels_augmented.csv", "labels_raw.csv", "labels.csv")


@dataclass(frozen=True)
class Dataset:
    """Motions sorted by name, which is the order of a model's learned PBs."""

    motions: tuple[Motion, ...]
    labels: dict[str, MotionLabel]
    attribution: str = ""
    remarks: tuple[str, ...] = ()  # what was not plain in the files, a line each

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

        Raises:
            InputError: other joints, or not all the motions that the model has learned.
        """
        motions = self.learned_by(model)
        absent = [name for name, m in zip(model.info.motions, motions, strict=False) if m is None]
        if absent:
            raise InputError(f"the data lack motions the model has learned: {', '.join(absent)}")
        there = tuple(motion for motion in motions if motion is not None)
        labels = {m.name: self.labels[m.name] for m in there if m.name in self.labels}
        return Dataset(there, labels, self.attribution)

    def learned_by(self, model: RNNPB) -> tuple[Motion | None, ...]:
        """(N,) the motion of each of the model's PBs, in the model's joints; None: not in the data.

        A model that knows its motions' names gets them by name; a published one, which does not,
        by the order of the names.

        Raises:
            InputError: joints are missing, or the data of a model without names have not as many
                motions as it has PBs.
        """
        joints = model.info.joints
        missing = [joint for joint in joints if joint not in self.joints]
        if missing:
            raise InputError(f"the data have no joint {', '.join(missing)}, which the model moves")
        order = [self.joints.index(joint) for joint in joints]
        by_name = {
            motion.name: Motion(motion.name, joints, motion.positions[:, order], motion.fps)
            for motion in self.motions
        }
        names = model.info.motions or tuple(by_name)
        if len(names) != model.config.num_motions:
            raise InputError(
                f"the data have {len(names)} motions, the model has learned "
                f"{model.config.num_motions} and does not say their names"
            )
        return tuple(map(by_name.get, names))

    def complete(self, model: RNNPB) -> ModelInfo:
        """What is known of the model, with what a published one does not say of its motions.

        Names, lengths and labels that it does not carry are those of the data.

        Raises:
            InputError: see `learned_by`.
        """
        info, motions = model.info, self.learned_by(model)
        there = [motion for motion in motions if motion is not None]
        if len(there) < len(motions):
            return info
        return replace(
            info,
            motions=info.motions or tuple(motion.name for motion in there),
            lengths=info.lengths or tuple(map(len, there)),
            labels=info.labels or self.labels,
        )


def behavior_class(name: str) -> str:
    """The emotion in a REBL-Pepper name: `Happy_4_tr` -> `Happy`."""
    return re.sub(r"(_\d+)?(_tr)?$", "", name)


def labels_beside(folder: Path, names: list[str]) -> dict[str, MotionLabel]:
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
