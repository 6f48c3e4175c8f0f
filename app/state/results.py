"""What work comes to. A result may come in stages: each holds more than the one before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.belief import Cloud
from ...core.recognition_run import Posterior
from ...core.walk import RISE, Walk
from ...core.windows import Landscape
from ...robot.safety_report import SafetyReport

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CheckedMotion:
    """What a motion asks of the robot."""

    report: SafetyReport
    limited: NDArray[np.float32] | None  # (T, J) within the limits; where that was asked for


@dataclass(frozen=True, eq=False)
class MotionResult:
    """A generated motion; its check comes a moment later, where one was asked for."""

    positions: NDArray[np.float32]  # (T, J)
    check: CheckedMotion | None = None


@dataclass(frozen=True, eq=False)
class LandscapeResult:
    """Coarse, then complete: `values.complete` says which."""

    values: Landscape


@dataclass(frozen=True, eq=False)
class RecognitionTrace:
    """The iterations so far; K trials, S iterations, D = D_PB.

    finished: it came to its own end; then there may be a posterior, round the best PB.
    """

    mu: Array  # (S + 1, K, D), the last row after the last step
    sigma: Array  # (S + 1, K, D)
    pb: Array  # (S, K, D)
    loss: Array  # (S, K)
    kl: Array  # (S, K)
    prediction_error: Array  # (S, K)
    early_update: NDArray[np.bool_]  # (S, K)
    finished: bool = False
    posterior: Posterior | None = None

    @property
    def iterations(self) -> int:
        return len(self.loss)

    @property
    def best(self) -> tuple[int, int]:
        """(iteration, trial) of the lowest loss so far; NaN is never the lowest."""
        loss = np.where(np.isnan(self.loss), np.inf, self.loss)
        iteration, trial = np.unravel_index(int(loss.argmin()), loss.shape)
        return int(iteration), int(trial)

    def first(self, iterations: int) -> RecognitionTrace:
        """The same run after so many iterations."""
        if iterations >= self.iterations:
            return self
        return RecognitionTrace(
            self.mu[: iterations + 1],
            self.sigma[: iterations + 1],
            self.pb[:iterations],
            self.loss[:iterations],
            self.kl[:iterations],
            self.prediction_error[:iterations],
            self.early_update[:iterations],
        )


@dataclass(frozen=True)
class CodebookResult:
    """How far a codebook has grown; seconds: that it took, 0 where it lay in the user's cache."""

    entries: int
    size: int
    seconds: float


@dataclass(frozen=True, eq=False)
class BeliefResult:
    """The belief, and the motions of the explanations that remain."""

    cloud: Cloud
    motions: tuple[NDArray[np.float32], ...]  # of each of the cloud's modes, (T, J)


@dataclass(frozen=True)
class StretchResult:
    """Degrees of mean joint angle a unit of mu; condition: of the Jacobian."""

    degrees: float
    condition: float


@dataclass(frozen=True, eq=False)
class WaysResult:
    """From one motion to another (core/smoothness.py). sought: no shorter way is to come."""

    straight: Walk
    shortest: Walk
    sought: bool

    @property
    def detour(self) -> float:
        """Of the straight line; NaN where both ends are the same motion."""
        length = self.shortest.length
        return self.straight.length / length if length > RISE else float("nan")


@dataclass(frozen=True)
class ExportedFile:
    file_name: str
    content: bytes
    summary: str  # one line on what is in it


Result = (
    MotionResult
    | LandscapeResult
    | RecognitionTrace
    | CodebookResult
    | BeliefResult
    | StretchResult
    | WaysResult
    | ExportedFile
)
