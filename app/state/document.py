"""What is on one browser's screen, as plain values.

The state holds no handles, no locks and no tensors. `update.py` alone makes a new one from an old
one. What never changes while the app runs (the learned PBs, names, lengths) stands in `ModelFacts`,
beside the state.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ...core.latent_map import LatentMap, spread
from ...core.motion import Motion, MotionLabel
from ...core.windows import Landscape, Window
from ...robot.formats import Format
from ...robot.safety_report import SafetyReport

if TYPE_CHECKING:
    from .intents import LandscapeWork

Array = NDArray[np.float64]
EyeTrack = NDArray[np.float32]  # (T, 2, 8, 3), as in robot/eyes.py
Colouring = Literal["class", "valence", "arousal"]
RecognitionStatus = Literal["idle", "running", "finished", "cancelled", "failed"]
Init = Literal["learned", "baseline", "random"]


@dataclass(frozen=True, eq=False)
class ModelFacts:
    """What is known of one loaded model; the same for every browser."""

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


@dataclass(frozen=True, eq=False)
class Latent:
    """One point of the latent space and the noise that turns it into a PB (eq. 1)."""

    motion: int  # the selected learned motion
    mu: Array  # (D,)
    sigma: Array  # (D,)
    epsilon: Array  # (D,), kept so that sigma moves the motion smoothly

    @property
    def pb(self) -> Array:
        return self.mu + self.sigma * self.epsilon


@dataclass(frozen=True, eq=False)
class GeneratedMotion:
    """A finished generation and the request that asked for it."""

    request: int
    positions: NDArray[np.float32]  # (T, J)
    reference: NDArray[np.float32]  # (T', J) what it is compared with: the target


@dataclass(frozen=True, eq=False)
class CheckedMotion:
    """What a generated motion asks of the robot, and the request that generated it."""

    request: int
    report: SafetyReport
    limited: NDArray[np.float32] | None  # (T, J) within the limits; where both are to be seen


@dataclass(frozen=True, eq=False)
class ComputedLandscape:
    """A landscape, coarse or complete, and the request that asked for it."""

    request: int
    values: Landscape


@dataclass(frozen=True)
class Playback:
    playing: bool = True
    phase: float = 0.0  # 0 .. 1 through the motion, so that it survives a change of length
    speed: float = 1.0
    loop: bool = True


@dataclass(frozen=True, eq=False)
class RecognitionTrace:
    """The iterations so far; K trials, S iterations, D = D_PB."""

    mu: Array  # (S + 1, K, D), the last row after the last step
    sigma: Array  # (S + 1, K, D)
    pb: Array  # (S, K, D)
    loss: Array  # (S, K)
    prediction_error: Array  # (S, K)
    early_update: NDArray[np.bool_]  # (S, K)

    @property
    def iterations(self) -> int:
        return len(self.loss)

    @property
    def best(self) -> tuple[int, int]:
        """(iteration, trial) of the lowest loss so far; NaN is never the lowest."""
        loss = np.where(np.isnan(self.loss), np.inf, self.loss)
        iteration, trial = np.unravel_index(int(loss.argmin()), loss.shape)
        return int(iteration), int(trial)


@dataclass(frozen=True, eq=False)
class Recognition:
    """The target a person gave, the settings, and the run."""

    target: Motion | None = None
    eyes: EyeTrack | None = None  # that came with the target
    observed: float = 0.8
    init: Init = "learned"
    iterations: int = 100
    trials: int = 1
    status: RecognitionStatus = "idle"
    request: int = 0
    model: int = 0  # the model that the run belongs to
    planned: int = 0  # iterations of the run; `iterations` may be set anew meanwhile
    trace: RecognitionTrace | None = None
    trial: int = 0  # the trial that is drawn
    shown: int | None = None  # the iteration scrubbed to; None where nobody has
    message: str = ""

    @property
    def iteration(self) -> int:
        """The iteration that was put on the screen last, from 0: by hand, or by the run."""
        if self.trace is None:
            return 0
        if self.shown is not None:
            return self.shown
        return self.trace.best[0] if self.status == "finished" else self.trace.iterations - 1

    def with_settings_of(self, other: Recognition) -> Recognition:
        """This target and run, but what is set for the next run as in another recognition."""
        return replace(
            self,
            observed=other.observed,
            init=other.init,
            iterations=other.iterations,
            trials=other.trials,
        )


@dataclass(frozen=True, eq=False)
class ModelState:
    """One model on the screen and what was computed for it."""

    latent: Latent
    anchor: Array  # (D,) the landscape's middle: the learned mu, or where the puck left the window
    motion: GeneratedMotion | None = None
    checked: CheckedMotion | None = None
    landscape: ComputedLandscape | None = None
    motion_request: int = 0
    landscape_request: int = 0
    landscape_asked: LandscapeWork | None = None  # the last one, whether it has come or not


@dataclass(frozen=True)
class ExportOptions:
    """How a motion becomes a file for a robot. `written` says what the last one was."""

    file_format: Format = "csv"
    safe_posture: bool = False  # start from and return to it
    beyond_limits: bool = False  # insist on the motion as it was generated
    request: int = 0
    written: str = ""


@dataclass(frozen=True)
class Notice:
    """A line for the person; `number` tells one notice from the next with the same words."""

    number: int
    text: str
    good: bool = False


@dataclass(frozen=True, eq=False)
class AppState:
    """Everything on the screen of one browser."""

    models: tuple[ModelState, ...]
    active: int = 0  # the model that the boards, sliders and recognition speak of
    playback: Playback = field(default_factory=Playback)
    recognition: Recognition = field(default_factory=Recognition)
    map_axes: tuple[int, ...] = (0, 1)  # principal components, from 0
    landscape_axes: tuple[int, ...] | Literal["pca"] = (0, 1)  # mu dimensions, or the map's plane
    window: Window = "absolute"
    colouring: Colouring = "class"
    joint: str = ""  # shown in the Joints panel; "" = those that move most
    side_by_side: bool = False  # the limited motion on a second robot
    eyes: bool = True  # colour the eyes where the motion has a track for them
    export: ExportOptions = field(default_factory=ExportOptions)
    use_target: bool = True  # the landscape compares with an uploaded motion where there is one
    seed: int = 0
    draws: int = 0  # random draws so far; with the seed, what the next draw will be
    requests: int = 0  # the last request number given out
    undo: tuple[Moment, ...] = ()
    redo: tuple[Moment, ...] = ()
    gesture: str = ""  # the gesture whose beginning the last undo entry holds
    rested: float = 0.0  # seconds since the gesture last moved the latent
    notice: Notice | None = None

    @property
    def current(self) -> ModelState:
        return self.models[self.active]


@dataclass(frozen=True, eq=False)
class Moment:
    """What undo goes back to."""

    active: int
    latents: tuple[Latent, ...]
    recognition: Recognition
    screen: AppState | None = None  # where a state code replaced all of it


def initial_latent(facts: ModelFacts, motion: int) -> Latent:
    """The learned PB of a motion without noise: its reconstruction."""
    return Latent(
        motion=motion,
        mu=facts.mu[motion].copy(),
        sigma=facts.sigma[motion].copy(),
        epsilon=np.zeros(facts.pb_dim),
    )


def initial_state(facts: tuple[ModelFacts, ...], seed: int = 0, motion: int = 0) -> AppState:
    """The screen as it opens: one motion, playing; the same of every model that has learnt it."""
    first = facts[0]
    name = first.motions[min(motion, len(first.motions) - 1)]
    models = tuple(
        ModelState(latent, anchor=latent.mu)
        for one in facts
        for index in [one.motions.index(name) if name in one.motions else motion]
        for latent in [initial_latent(one, min(index, len(one.motions) - 1))]
    )
    axes = (0, 1)[: first.pb_dim]
    return AppState(models=models, map_axes=axes, landscape_axes=axes, seed=seed)
