"""What a person asks for. Values are absolute, never deltas; each intent is plain data.

What an intent does to the document is said in `update.py`; what is asked of the page itself (undo,
files, codes) in `history.py` and in the page's session.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.windows import Window
from .document import Colouring, Hand, Seen, Target
from .work import TakeAway


# --- a point of the latent space ---
@dataclass(frozen=True)
class SelectModel:
    index: int


@dataclass(frozen=True)
class SelectMotion:
    """Select a learned motion: mu and sigma jump to it. model: whose; None: of the active one."""

    index: int
    model: int | None = None


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
    """The puck was dragged on a model's PB map to coordinates of these principal components."""

    model: int
    axes: tuple[int, ...]
    to: tuple[float, ...]
    gesture: int  # one number a drag, so that undo takes back the drag as a whole


@dataclass(frozen=True)
class MoveOnLandscape:
    """The puck was dragged on a model's landscape to these values of its axes.

    axes: the labels that stood at them; where the landscape has others by now, nothing moves.
    """

    model: int
    axes: tuple[str, ...]
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
class WalkTo:
    """To a step of the way to the goal, or the whole way as one motion; None: neither."""

    to: int | Literal["morph"] | None


LatentIntent = (
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
    | WalkTo
)


# --- playback ---
@dataclass(frozen=True)
class SetPlaying:
    """Play, or rest; from or at a frame, where the browser that plays says one."""

    playing: bool
    frame: float | None = None


@dataclass(frozen=True)
class TogglePlaying:
    pass


@dataclass(frozen=True)
class Seek:
    frame: float


@dataclass(frozen=True)
class SetSpeed:
    speed: float


@dataclass(frozen=True)
class SetLoop:
    loop: bool


PlaybackIntent = SetPlaying | TogglePlaying | Seek | SetSpeed | SetLoop


# --- what the boards, plots and panels show ---
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
class ShowSliders:
    """The page of sliders that begins with this dimension."""

    first: int


@dataclass(frozen=True)
class SetUseTarget:
    use_target: bool


@dataclass(frozen=True)
class SetShowTarget:
    """The uploaded motion on a robot of its own."""

    show_target: bool


@dataclass(frozen=True)
class SetRevealed:
    """What comes after the observed part of the target, too."""

    revealed: bool


@dataclass(frozen=True)
class OpenModel:
    """Show a model of this name: in place of the active one, or beside it, to compare them."""

    name: str
    beside: bool = False


@dataclass(frozen=True)
class CloseModel:
    """Take the active model off the page."""


@dataclass(frozen=True)
class GoToStep:
    """Set the screen as a step of a lesson does; "": no lesson any more."""

    lesson: str
    step: int


@dataclass(frozen=True)
class SetCompare:
    """The boards of two models side by side."""

    compare: bool


@dataclass(frozen=True)
class SetHand:
    """How one hand moves several models."""

    hand: Hand


@dataclass(frozen=True)
class SetGoal:
    """The learned motion at the other end of the way; "": none."""

    goal: str


@dataclass(frozen=True)
class SetCloud:
    """The belief over a codebook on the map."""

    cloud: bool


@dataclass(frozen=True)
class SetExplanations:
    """What the belief is torn between, as ghosts."""

    explanations: bool


@dataclass(frozen=True)
class SetErrorScale:
    """How far off a right explanation may be, in radians."""

    scale: float


@dataclass(frozen=True)
class SetGhosts:
    """Samples from N(mu, sigma^2) around the robot, and their band on the joint curves."""

    ghosts: bool


@dataclass(frozen=True)
class SetEyes:
    """Colour the robot's eyes as the motion's track says, where it has one."""

    eyes: bool


@dataclass(frozen=True)
class SetSideBySide:
    """The motion as generated and within the limits, on two robots."""

    side_by_side: bool


@dataclass(frozen=True)
class Look:
    """Zoomed, turned, or at another tab."""

    seen: Seen


@dataclass(frozen=True)
class ResetView:
    """Look at everything from the front."""


@dataclass(frozen=True)
class SetExportOption:
    name: Literal["file_format", "safe_posture", "beyond_limits"]
    value: str | bool


ViewIntent = (
    SetMapAxes
    | SetLandscapeAxes
    | SetWindow
    | SetColouring
    | SetJoint
    | ShowSliders
    | SetUseTarget
    | SetShowTarget
    | SetRevealed
    | SetCompare
    | SetHand
    | SetGoal
    | SetCloud
    | SetExplanations
    | SetErrorScale
    | SetGhosts
    | SetEyes
    | SetSideBySide
    | Look
    | ResetView
    | SetExportOption
)


# --- recognition ---
@dataclass(frozen=True)
class SetTarget:
    target: Target


@dataclass(frozen=True)
class ClearTarget:
    pass


@dataclass(frozen=True)
class SetRecognitionOption:
    name: Literal["method", "observed", "init", "iterations", "trials", "joints", "beta", "slow"]
    value: float | int | str | tuple[str, ...]


@dataclass(frozen=True)
class StartRecognition:
    pass


@dataclass(frozen=True)
class PauseRecognition:
    """Stand still at the iteration that is shown, or go on."""

    paused: bool


@dataclass(frozen=True)
class StepRecognition:
    """One iteration further, and stand still there."""


@dataclass(frozen=True)
class AddToMap:
    """Put the active model's mu and sigma on its map, as a point of its own."""

    name: str


@dataclass(frozen=True)
class RemoveAdded:
    """Take all points that were added to the active model's map away."""


@dataclass(frozen=True)
class SelectAdded:
    """Go to an added point: index among those of all models."""

    index: int


@dataclass(frozen=True)
class CancelRecognition:
    pass


@dataclass(frozen=True)
class ScrubRecognition:
    """Show one iteration of the run, of the given trial."""

    iteration: int
    trial: int


RecognitionIntent = (
    SetTarget
    | ClearTarget
    | SetRecognitionOption
    | StartRecognition
    | PauseRecognition
    | StepRecognition
    | AddToMap
    | RemoveAdded
    | SelectAdded
    | CancelRecognition
    | ScrubRecognition
)


# --- the way through documents ---
@dataclass(frozen=True)
class Undo:
    pass


@dataclass(frozen=True)
class Redo:
    pass


@dataclass(frozen=True)
class RestoreCode:
    """Put the document of a state code on the screen."""

    code: str


# --- what the page does beside its document ---
@dataclass(frozen=True)
class ExportMotion:
    """Write the motion on the screen as a file, and hand it to the browser."""


@dataclass(frozen=True)
class DownloadMotion:
    """The same as CSV and just as it is, whatever is set for an export."""


@dataclass(frozen=True)
class TakeAwayRun:
    """What the recognition came to, as a file for the browser."""

    what: TakeAway


@dataclass(frozen=True)
class PresentPage:
    """Have others follow this page."""


@dataclass(frozen=True)
class ShowCode:
    """Write the state code of this screen where a person can copy it."""


@dataclass(frozen=True)
class ShowFile:
    """The motions that a file holds that was read."""

    motions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Say:
    """A line for the person."""

    text: str
    good: bool = False


# These need the library of models, or of lessons, so that the session sees to them.
LibraryIntent = OpenModel | CloseModel | GoToStep
DocumentIntent = LatentIntent | PlaybackIntent | ViewIntent | RecognitionIntent
HistoryIntent = Undo | Redo | RestoreCode
PageIntent = ExportMotion | DownloadMotion | TakeAwayRun | PresentPage | ShowCode | ShowFile | Say
Intent = DocumentIntent | LibraryIntent | HistoryIntent | PageIntent
