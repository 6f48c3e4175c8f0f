"""What a person or a worker asks of the state. Values are absolute, never deltas.

Each intent is plain data; `update.py` says what it does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.motion import Motion
from ...core.windows import Window
from .document import (
    Array,
    CheckedMotion,
    Colouring,
    ComputedLandscape,
    ExportOptions,
    EyeTrack,
    Init,
    RecognitionTrace,
)


# --- a point of the latent space ---
@dataclass(frozen=True)
class SelectModel:
    index: int


@dataclass(frozen=True)
class SelectMotion:
    """Select a learned motion: mu and sigma jump to it."""

    index: int


@dataclass(frozen=True)
class SetMu:
    dim: int
    value: float


@dataclass(frozen=True)
class SetSigma:
    dim: int
    value: float


@dataclass(frozen=True)
class MoveOnMap:
    """The puck was dragged on the PB map to these coordinates of these principal components."""

    axes: tuple[int, ...]
    to: tuple[float, ...]
    gesture: int  # one number a drag, so that undo takes back the drag as a whole


@dataclass(frozen=True)
class MoveOnLandscape:
    """The puck was dragged on the landscape to these values of its axes."""

    to: tuple[float, ...]
    gesture: int


@dataclass(frozen=True)
class ResetLatent:
    """Back to the selected motion's learned mu and sigma, without noise."""


@dataclass(frozen=True)
class RandomiseLatent:
    """A mu drawn from the spread of the learned ones."""


@dataclass(frozen=True)
class NewNoise:
    """A new epsilon (eq. 1): another sample from the same Gaussian."""


@dataclass(frozen=True)
class ClearNoise:
    """epsilon = 0: the motion at mu itself."""


@dataclass(frozen=True)
class Undo:
    pass


@dataclass(frozen=True)
class Redo:
    pass


# --- playback ---
@dataclass(frozen=True)
class SetPlaying:
    playing: bool


@dataclass(frozen=True)
class TogglePlaying:
    pass


@dataclass(frozen=True)
class Seek:
    frame: int


@dataclass(frozen=True)
class SetSpeed:
    speed: float


@dataclass(frozen=True)
class SetLoop:
    loop: bool


@dataclass(frozen=True)
class Tick:
    """Time went by."""

    seconds: float


# --- what the boards and plots show ---
@dataclass(frozen=True)
class SetMapAxes:
    axes: tuple[int, ...]


@dataclass(frozen=True)
class SetLandscapeAxes:
    axes: tuple[int, ...] | Literal["pca"]


@dataclass(frozen=True)
class SetWindow:
    window: Window


@dataclass(frozen=True)
class SetColouring:
    colouring: Colouring


@dataclass(frozen=True)
class SetJoint:
    joint: str


@dataclass(frozen=True)
class SetUseTarget:
    use_target: bool


@dataclass(frozen=True)
class SetEyes:
    """Colour the robot's eyes as the motion's track says, where it has one."""

    eyes: bool


# --- the robot ---
@dataclass(frozen=True)
class SetSideBySide:
    """The motion as generated and within the limits, on two robots."""

    side_by_side: bool


@dataclass(frozen=True)
class SetExportOption:
    name: Literal["file_format", "safe_posture", "beyond_limits"]
    value: str | bool


@dataclass(frozen=True)
class ExportMotion:
    """Write the motion on the screen as a file, and hand it to the browser."""


@dataclass(frozen=True)
class DownloadMotion:
    """The same as CSV and just as it is, whatever is set for an export."""


# --- recognition ---
@dataclass(frozen=True, eq=False)
class SetTarget:
    """eyes: the colour track that came with the motion. remark: what else is to be known of it."""

    motion: Motion
    eyes: EyeTrack | None = None
    remark: str = ""


@dataclass(frozen=True)
class RefuseTarget:
    """An upload that is no motion."""

    reason: str


@dataclass(frozen=True)
class ClearTarget:
    pass


@dataclass(frozen=True)
class SetRecognitionOption:
    name: Literal["observed", "init", "iterations", "trials"]
    value: float | int | str


@dataclass(frozen=True)
class StartRecognition:
    pass


@dataclass(frozen=True)
class CancelRecognition:
    pass


@dataclass(frozen=True)
class ScrubRecognition:
    """Show one iteration of the run, of the given trial."""

    iteration: int
    trial: int


# --- what workers report ---
@dataclass(frozen=True, eq=False)
class MotionReady:
    model: int
    request: int
    positions: NDArray[np.float32]  # (T, J)
    reference: NDArray[np.float32]  # (T', J)


@dataclass(frozen=True, eq=False)
class MotionChecked:
    model: int
    checked: CheckedMotion


@dataclass(frozen=True)
class ExportReady:
    request: int
    file_name: str
    content: str
    summary: str


@dataclass(frozen=True, eq=False)
class LandscapeReady:
    model: int
    landscape: ComputedLandscape


@dataclass(frozen=True, eq=False)
class RecognitionStepped:
    request: int
    trace: RecognitionTrace


@dataclass(frozen=True)
class RecognitionFinished:
    request: int


@dataclass(frozen=True)
class WorkFailed:
    work: Literal["motion", "landscape", "recognition", "export"]
    request: int
    message: str


# --- the whole screen ---
@dataclass(frozen=True)
class RestoreCode:
    """Restore the screen from a state code."""

    code: str


Intent = (
    SelectModel
    | SelectMotion
    | SetMu
    | SetSigma
    | MoveOnMap
    | MoveOnLandscape
    | ResetLatent
    | RandomiseLatent
    | NewNoise
    | ClearNoise
    | Undo
    | Redo
    | SetPlaying
    | TogglePlaying
    | Seek
    | SetSpeed
    | SetLoop
    | Tick
    | SetMapAxes
    | SetLandscapeAxes
    | SetWindow
    | SetColouring
    | SetJoint
    | SetUseTarget
    | SetEyes
    | SetSideBySide
    | SetExportOption
    | ExportMotion
    | DownloadMotion
    | SetTarget
    | RefuseTarget
    | ClearTarget
    | SetRecognitionOption
    | StartRecognition
    | CancelRecognition
    | ScrubRecognition
    | MotionReady
    | MotionChecked
    | ExportReady
    | LandscapeReady
    | RecognitionStepped
    | RecognitionFinished
    | WorkFailed
    | RestoreCode
)


# --- the work that an update can want ---
@dataclass(frozen=True, eq=False)
class GenerateWork:
    model: int
    request: int
    pb: Array  # (D,)
    steps: int
    motion: int  # whose reconstruction is the reference where there is no target
    target: NDArray[np.float32] | None  # (T, J) the reference
    limited: bool = False  # whether the motion within the robot's limits is wanted, too


@dataclass(frozen=True, eq=False)
class LandscapeWork:
    model: int
    request: int
    center: Array  # (D,) where the window's middle lies
    directions: Array  # (A, D), A = 1 or 2 axes
    zero: Array  # (D,) where the values on the axes are 0
    radius: float
    target: NDArray[np.float32] | None  # (T, J); None = the model's own reconstruction
    motion: int  # whose reconstruction that is


@dataclass(frozen=True, eq=False)
class RecogniseWork:
    model: int
    request: int
    target: NDArray[np.float32]
    observed: float
    init: Init
    iterations: int
    trials: int
    seed: int


@dataclass(frozen=True)
class CancelRecogniseWork:
    pass


@dataclass(frozen=True, eq=False)
class ExportWork:
    model: int
    request: int
    name: str
    positions: NDArray[np.float32]  # (T, J)
    options: ExportOptions


@dataclass(frozen=True)
class SendFile:
    """Hand a file to the browser."""

    file_name: str
    content: str


Work = GenerateWork | LandscapeWork | RecogniseWork | CancelRecogniseWork | ExportWork | SendFile
