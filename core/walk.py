"""A way through the latent space, and the motions along it as one. Pure numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STEPS = 40  # of a way
RISE = 1e-6  # radians; below it two motions are the same
REST = 0.25  # of a morph's frames, at each of its ends

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Walk:
    """A way through the latent space, S steps.

    pbs: (S + 1, D). steps: (S,) root mean square changes of the motion, in radians.
    """

    pbs: Array
    steps: Array
    distance: float  # of the motions at its ends

    @property
    def length(self) -> float:
        """Of the way of the motion, in radians."""
        return float(self.steps.sum())

    @property
    def wander(self) -> float:
        """NaN where both ends are the same motion."""
        return self.length / self.distance if self.distance > RISE else float("nan")

    @property
    def cliff(self) -> float:
        mean = float(self.steps.mean())
        return float(self.steps.max()) / mean if mean > RISE / len(self.steps) else float("nan")

    @property
    def steepest(self) -> int:
        """The step with the largest change, from 0."""
        return int(self.steps.argmax())


def morph_shares(frames: int) -> Array:
    """(T,) how far along its way a morph is in each frame, from 0 to 1.

    It rests at both ends for a while, so that the two motions can be told.
    """
    time = np.linspace(0.0, 1.0, frames)
    shares: Array = np.clip((time - REST) / (1 - 2 * REST), 0.0, 1.0)
    return shares


def morph(pbs: Array, frames: int) -> Array:
    """(T, D): one PB a frame, evenly along a way of PBs (S + 1, D)."""
    at = morph_shares(frames) * (len(pbs) - 1)
    number = np.arange(len(pbs))
    moved: Array = np.stack([np.interp(at, number, column) for column in pbs.T], axis=1)
    return moved
