"""What is known of the loaded models; the same for every page, and never changed while it runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.latent_map import LatentMap, spread
from ...core.motion import Motion, MotionLabel
from .document import EyeTrack

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModelFacts:
    """One loaded model."""

    name: str
    mu: Array  # (N, D)
    sigma: Array  # (N, D), zeros for a deterministic model
    stochastic: bool
    beta: float | None
    joints: tuple[str, ...]
    fps: float
    motions: tuple[str, ...]
    lengths: tuple[int, ...]
    labels: dict[str, MotionLabel]
    latent_map: LatentMap
    data: tuple[Motion | None, ...]  # the training motions, where the app was given them
    eyes: tuple[EyeTrack | None, ...] = ()  # their eye colours; () where none have any

    @property
    def pb_dim(self) -> int:
        return int(self.mu.shape[1])

    @property
    def mu_sd(self) -> float:
        """Standard deviation of the learned mu, averaged over dimensions: a window's unit."""
        return spread(self.mu)


Facts = tuple[ModelFacts, ...]
