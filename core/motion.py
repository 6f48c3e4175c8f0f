"""A motion, and its plain file: one row a frame, one column a joint, radians."""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
    """Write the motion as a CSV file that gives it back to the bit.

    Raises:
        InputError: the file cannot be written; one that was there is as it was.
    """
    text = format_motion(motion)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="")
