"""What all works are computed from: the models, their data, the robot."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...core.codebook import Codebook
from ...core.model import RNNPB
from ...core.motion import Motion
from ...robot.description import Robot

REST_SECONDS = 0.15  # a landscape is completed when it has been wanted for this long


@dataclass(frozen=True)
class Sources:
    """
    models: by name. data: of each model's motions: the training motion where the app has it.
    workers: how many pieces can be done at the same time.
    reconstructions: what stands in for training motions, by model and motion, once it is known.
    codebooks: by model, once somebody has asked for one.
    """

    models: Mapping[str, RNNPB]
    data: Mapping[str, Sequence[Motion | None]]
    robot: Robot
    workers: int = 1
    rest_seconds: float = REST_SECONDS
    reconstructions: dict[tuple[str, int], NDArray[np.float32]] = field(default_factory=dict)
    codebooks: dict[str, Codebook] = field(default_factory=dict)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def codebook(self, model: str) -> Codebook:
        """The one codebook of a model, as far as it has grown."""
        with self.lock:
            if model not in self.codebooks:
                self.codebooks[model] = Codebook(self.models[model])
            return self.codebooks[model]
