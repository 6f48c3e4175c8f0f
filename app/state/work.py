"""The work that a document can want, as plain values: equal works have equal results.

A work is its own key: results are kept under it, two pages that want the same share one. What a
work needs is all in it, so that it can be done again at any time. `model` is a model's name: pages
show different ones, in places of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.recognition_run import Init, Method
from .document import ExportOptions, Target
from .results import RecognitionTrace

Vector = tuple[float, ...]


@dataclass(frozen=True)
class MotionWork:
    """Closed-loop generation from one PB (eqs. 6 to 8), and what the motion asks of the robot."""

    model: str
    pb: Vector  # (D,)
    steps: int
    # Nothing more than the motion; the safety report; the report and the motion within the limits.
    check: Literal["no", "report", "limited"] = "no"
    # PBs, each of (D,), that it goes along while it is generated; () stays at `pb` (core/walk.py).
    along: tuple[Vector, ...] = ()


@dataclass(frozen=True)
class LandscapeWork:
    """The correlation landscape (Fig. 4) in a window of the latent space.

    target: what motions are compared with; None: the training motion number `motion` where the app
        has the data, or the model's own reconstruction of it. With a target, `motion` is -1.
    """

    model: str
    center: Vector  # (D,)
    directions: tuple[Vector, ...]  # A rows of (D,), A = 1 or 2 axes
    zero: Vector  # (D,) where the values on the axes are 0
    radius: float
    target: Target | None
    motion: int
    labels: tuple[str, ...] = ()  # of the axes


@dataclass(frozen=True)
class RecogniseWork:
    """A recognition: the published one (section III.D) with a seed, or one of the others.

    The first iterations of a longer run are those of a shorter one: `iterations` says how many are
    wanted, and is no part of what the run is. None: as many as it takes until it ends by itself.

    joints: indices of those that are observed; () means all. init, trials, seed: only of the
    published one.
    """

    model: str
    target: Target
    method: Method
    observed: float
    joints: tuple[int, ...]
    beta: float
    init: Init
    iterations: int | None
    trials: int
    seed: int

    def is_met_by(self, trace: RecognitionTrace) -> bool:
        """Whether nothing is left to compute."""
        if self.iterations is None:
            return trace.finished
        return trace.iterations >= self.iterations


@dataclass(frozen=True)
class CodebookWork:
    """The codebook of a model; it grows while it is used."""

    model: str


@dataclass(frozen=True)
class BeliefWork:
    """The belief over a codebook while the observed part of a target comes in.

    joints: indices of those that are observed; () means all. scale: of errors, radians. entries: of
    the codebook, so that a larger one is asked for anew.
    """

    model: str
    target: Target
    observed: float
    joints: tuple[int, ...]
    scale: float
    entries: int


@dataclass(frozen=True)
class StretchWork:
    """How far the motion moves for a small step from mu (core/smoothness.py)."""

    model: str
    mu: Vector  # (D,)


@dataclass(frozen=True)
class WaysWork:
    """The straight line and the shortest way from one motion's mu to another's."""

    model: str
    start: Vector  # (D,)
    end: Vector


@dataclass(frozen=True)
class ExportWork:
    """A motion as a file for a real robot."""

    motion: MotionWork
    name: str
    options: ExportOptions


TakeAway = Literal["path", "arrays", "png", "svg"]


@dataclass(frozen=True)
class TakeAwayWork:
    """What a recognition came to, as a file: its path, all of it as arrays, a figure as Fig. 5."""

    run: RecogniseWork
    trace: RecognitionTrace  # as far as it was shown
    what: TakeAway
    trial: int
    name: str


Work = (
    MotionWork
    | LandscapeWork
    | RecogniseWork
    | CodebookWork
    | BeliefWork
    | StretchWork
    | WaysWork
    | ExportWork
    | TakeAwayWork
)
# What newer work of a page takes the place of: its motion, reference, landscape of one model, ...
Slot = tuple[
    Literal[
        "motion",
        "reference",
        "ghost",
        "landscape",
        "recognition",
        "codebook",
        "belief",
        "stretch",
        "ways",
        "walk",
        "export",
    ],
    int,
]
