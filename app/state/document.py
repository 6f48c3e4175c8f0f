"""Everything that a person chose on one page, and nothing else: immutable, complete, plain values.

What is not in the document cannot be undone, restored or shared. Undo is an earlier document
(history.py), a state code is a document written down (statecode.py), and what has to be computed
follows from it (wanted.py). A new choice is a new field here, with its bounds: it is then undone,
shared and restored without another line.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import ArrayLike, NDArray

from ...core.belief import ERROR_SCALE, LEAST_SCALE, MOST_SCALE
from ...core.motion import MAX_FRAMES, Motion, check_length
from ...core.recognition_run import Init, Method
from ...core.walk import STEPS
from ...core.windows import Window
from ...robot.formats import Format

Colouring = Literal["class", "valence", "arousal"]
# How one hand moves several models: the active one alone, all as far (in units of mu, or
# of the standard deviation of each one's learned mu), or each the same share of the way to `goal`.
Hand = Literal["alone", "absolute", "sd", "way"]
EyeTrack = NDArray[np.float32]  # (T, 2, 8, 3), as in robot/eyes.py

# The one set of bounds for mu, sigma and epsilon, wherever they come from: far beyond everything
# that a model or a recognition reaches, and safe to compute with.
MAX_PB = 1e6
MAX_SPEED, MIN_SPEED = 3.0, 0.1
MIN_OBSERVED = 0.1
MAX_ITERATIONS, MAX_TRIALS = 300, 10
MAX_BETA = 1e3
MAX_ADDED = 50
MAX_MODELS = 4
MAX_COUNT = 2**32 - 1

Coordinate = Annotated[float, Meta(ge=-MAX_PB, le=MAX_PB)]
Width = Annotated[float, Meta(ge=0, le=MAX_PB)]
Count = Annotated[int, Meta(ge=0, le=MAX_COUNT)]
Metres = Annotated[float, Meta(ge=-1e4, le=1e4)]
Name = Annotated[str, Meta(max_length=255)]  # as long as a file's name can be
Axes = Annotated[tuple[Annotated[int, Meta(ge=0, le=127)], ...], Meta(min_length=1, max_length=2)]


class Latent(Struct, frozen=True, forbid_unknown_fields=True):
    """One point of the latent space and the noise that turns it into a PB (eq. 1); D each."""

    motion: Count  # the selected learned motion
    mu: tuple[Coordinate, ...]
    sigma: tuple[Width, ...]
    epsilon: tuple[Coordinate, ...]  # kept, so that sigma moves the motion smoothly

    @property
    def pb(self) -> tuple[float, ...]:
        return tuple(m + s * e for m, s, e in zip(self.mu, self.sigma, self.epsilon, strict=True))


def vector(values: ArrayLike) -> tuple[float, ...]:
    """(D,) within the bounds, as a document keeps it."""
    clipped: list[float] = np.clip(np.asarray(values, np.float64), -MAX_PB, MAX_PB).tolist()
    return tuple(clipped)


class ModelChoice(Struct, frozen=True, forbid_unknown_fields=True):
    """Which model, and where it stands."""

    name: Name

    latent: Latent
    # (D,) the landscape's middle: a learned mu, or where the puck left the window.
    anchor: tuple[Coordinate, ...]


class Playback(Struct, frozen=True, forbid_unknown_fields=True):
    playing: bool = True
    phase: Annotated[float, Meta(ge=0, le=1)] = 0.0  # it survives a change of length
    speed: Annotated[float, Meta(ge=MIN_SPEED, le=MAX_SPEED)] = 1.0
    loop: bool = True


class Target(Struct, frozen=True, forbid_unknown_fields=True):
    """A motion that a person gave."""

    name: Name
    joints: tuple[Name, ...]
    fps: Annotated[float, Meta(gt=0, le=1000)]
    positions: bytes  # (T, J) little-endian float32, radians
    eyes: bytes = b""  # (T, 2, 8, 3) uint8, or nothing: the colours that came with it

    def __post_init__(self) -> None:
        frame = 4 * len(self.joints)
        if not frame or not self.positions or len(self.positions) % frame:
            raise ValueError("a motion of broken frames")
        check_length(len(self), "the motion")
        if not np.isfinite(np.frombuffer(self.positions, "<f4")).all():
            raise ValueError("a motion with NaN or infinity")
        if self.eyes and len(self.eyes) != len(self) * 48:
            raise ValueError("eye colours of another number of frames")

    def __len__(self) -> int:
        return len(self.positions) // (4 * len(self.joints))

    @property
    def array(self) -> NDArray[np.float32]:
        """(T, J) radians; read-only."""
        return np.frombuffer(self.positions, "<f4").reshape(-1, len(self.joints))

    @property
    def eye_track(self) -> EyeTrack | None:
        """(T, 2, 8, 3) from 0 to 1, where colours came with the motion."""
        if not self.eyes:
            return None
        eyes = np.frombuffer(self.eyes, np.uint8).reshape(-1, 2, 8, 3)
        track: EyeTrack = eyes.astype(np.float32) / np.float32(255)
        return track


def target_of_motion(motion: Motion, eyes: EyeTrack | None = None) -> Target:
    """The motion as a document keeps it."""
    return Target(
        motion.name[:255],
        motion.joints,
        motion.fps,
        np.ascontiguousarray(motion.positions, "<f4").tobytes(),
        b"" if eyes is None else (eyes * 255).round().astype(np.uint8).tobytes(),
    )


class Zoom(Struct, frozen=True, forbid_unknown_fields=True):
    """The part of a board that is looked at, while the board shows what the zoom is of."""

    of: Annotated[str, Meta(max_length=200)]  # the board's axes, in its own words
    left: Coordinate
    right: Coordinate
    bottom: Coordinate
    top: Coordinate

    def __post_init__(self) -> None:
        if not (self.left < self.right and self.bottom < self.top):
            raise ValueError("a zoom without a size")


class Camera(Struct, frozen=True, forbid_unknown_fields=True):
    """Metres; z is up."""

    position: tuple[Metres, Metres, Metres]
    look_at: tuple[Metres, Metres, Metres]

    def __post_init__(self) -> None:
        if np.allclose(self.position, self.look_at):
            raise ValueError("a camera that looks nowhere")


class Seen(Struct, frozen=True, forbid_unknown_fields=True):
    """Where a person looks; None: at the whole, from the front."""

    map: Zoom | None = None
    landscape: Zoom | None = None
    map_2: Zoom | None = None  # of the second of two models side by side
    landscape_2: Zoom | None = None
    camera: Camera | None = None
    tab: Annotated[str, Meta(max_length=40)] = ""  # of the panel; "": the first


class RecognitionSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """What the next run will do.

    joints: names of those that are observed; () means all. beta: weight of the KL term; 0: it is no
    part of what is minimised. init, iterations, trials: of the published procedure alone. slow: the
    iterations are shown one by one, slowly enough to watch.
    """

    method: Method = "global"
    observed: Annotated[float, Meta(ge=MIN_OBSERVED, le=1)] = 0.8
    init: Init = "learned"
    iterations: Annotated[int, Meta(ge=1, le=MAX_ITERATIONS)] = 100
    trials: Annotated[int, Meta(ge=1, le=MAX_TRIALS)] = 1
    joints: tuple[Name, ...] = ()
    beta: Annotated[float, Meta(ge=0, le=MAX_BETA)] = 0.0
    slow: bool = False


class Run(Struct, frozen=True, forbid_unknown_fields=True):
    """A recognition that somebody started; its iterations are computed from this.

    While it is not settled the model's latent is its newest iterate; afterwards the best PB that
    was sampled, the last iterate where it was cancelled, or the one that somebody looks at.
    """

    model: Count
    settings: RecognitionSettings
    seed: Count
    done: Annotated[int, Meta(ge=0, le=MAX_FRAMES)] = 0  # iterations that were followed
    until: Annotated[int, Meta(ge=0, le=MAX_FRAMES)] | None = None  # how far to follow by now
    paused: bool = False
    finished: bool = False  # it came to its own end
    settled: bool = False  # it ended, or somebody ended it after `done` iterations
    follows: bool = True  # the model's latent is what the run shows; a hand on it ends that
    trial: Annotated[int, Meta(ge=0, lt=MAX_TRIALS)] = 0  # the one that is drawn
    # The iteration scrubbed to; None where nobody has.
    shown: Annotated[int, Meta(ge=0, lt=MAX_FRAMES)] | None = None


class Added(Struct, frozen=True, forbid_unknown_fields=True):
    """A point that a person put on a model's map."""

    model: Count
    name: Name
    mu: tuple[Coordinate, ...]
    sigma: tuple[Width, ...]


class ExportOptions(Struct, frozen=True, forbid_unknown_fields=True):
    """How a motion becomes a file for a robot."""

    file_format: Format = "csv"
    safe_posture: bool = False  # start from and return to it
    beyond_limits: bool = False  # insist on the motion as it was generated


class Document(Struct, frozen=True, forbid_unknown_fields=True):
    """One page as a person has arranged it."""

    models: Annotated[tuple[ModelChoice, ...], Meta(min_length=1, max_length=MAX_MODELS)]
    active: Count = 0  # the model that the boards, sliders and recognition speak of
    playback: Playback = Playback()
    target: Target | None = None
    use_target: bool = True  # compare with an uploaded motion where there is one
    show_target: bool = True  # on a robot of its own
    revealed: bool = False  # what comes after the observed part of the target, too
    recognition: RecognitionSettings = RecognitionSettings()
    run: Run | None = None
    added: Annotated[tuple[Added, ...], Meta(max_length=MAX_ADDED)] = ()
    cloud: bool = True  # the belief over a codebook on the map, where there is a target
    explanations: bool = True  # those that the belief is torn between, as ghosts
    # Radians: how far off a right explanation may be.
    error_scale: Annotated[float, Meta(ge=LEAST_SCALE, le=MOST_SCALE)] = ERROR_SCALE
    map_axes: Axes = (0, 1)  # principal components, from 0
    landscape_axes: Axes | Literal["pca"] = (0, 1)  # components of mu, or the map's plane
    window: Window = "absolute"
    colouring: Colouring = "class"
    joint: Name = ""  # whose curve the time bar draws; "" = all
    compare: bool = False  # two models' boards side by side
    pair: tuple[Count, Count] = (0, 1)  # whose
    hand: Hand = "alone"
    goal: Name = ""  # the learned motion at the end of a way that begins at the selected one
    # The step of that way at which the models stand, or the whole way as one motion.
    walk: Annotated[int, Meta(ge=0, le=STEPS)] | Literal["morph"] | None = None
    first_slider: Annotated[int, Meta(ge=0, le=127)] = 0  # dimension of the first pair of sliders
    side_by_side: bool = False  # the limited motion on a second robot
    ghosts: bool = False  # samples from N(mu, sigma^2) around the robot
    eyes: bool = True  # colour the eyes where the motion has a track for them
    export: ExportOptions = ExportOptions()
    lesson: Name = ""  # the one that is shown; "": none
    lesson_step: Count = 0
    seen: Seen = Seen()
    seed: Count = 0
    draws: Count = 0  # random draws so far; with the seed, what the next draw will be

    @property
    def current(self) -> ModelChoice:
        return self.models[self.active]

    @property
    def on_boards(self) -> tuple[int, ...]:
        """The models whose boards are shown."""
        return self.pair if self.compare and len(self.models) > 1 else (self.active,)

    @property
    def running(self) -> bool:
        return self.run is not None and not self.run.settled
