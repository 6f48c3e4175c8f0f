"""The work that a document can want, as plain values: equal works have equal results.

A work is its own key: results are kept under it, two pages that want the same share one. What a
work needs is all in it, so that it can be done again at any time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.recognition_run import Init
from .document import ExportOptions, Target

Vector = tuple[float, ...]


@dataclass(frozen=True)
class MotionWork:
    """Closed-loop generation from one PB (eqs. 6 to 8), and what the motion asks of the robot."""

    model: int
    pb: Vector  # (D,)
    steps: int
    # Nothing more than the motion; the safety report; the report and the motion within the limits.
    check: Literal["no", "report", "limited"] = "no"


@dataclass(frozen=True)
class LandscapeWork:
    """The correlation landscape (Fig. 4) in a window of the latent space.

    target: what motions are compared with; None: the training motion number `motion` where the app
        has the data, or the model's own reconstruction of it. With a target, `motion` is -1.
    """

    model: int
    center: Vector  # (D,)
    directions: tuple[Vector, ...]  # A rows of (D,), A = 1 or 2 axes
    zero: Vector  # (D,) where the values on the axes are 0
    radius: float
    target: Target | None
    motion: int
    labels: tuple[str, ...] = ()  # of the axes


@dataclass(frozen=True)
class RecogniseWork:
    """The published recognition (section III.D) with one seed.

    The first iterations of a longer run are those of a shorter one: `iterations` says how many are
    wanted, and is no part of what the run is.
    """

    model: int
    target: Target
    observed: float
    init: Init
    iterations: int
    trials: int
    seed: int


@dataclass(frozen=True)
class ExportWork:
    """A motion as a file for a real robot."""

    motion: MotionWork
    name: str
    options: ExportOptions


Work = MotionWork | LandscapeWork | RecogniseWork | ExportWork
# What newer work of a page takes the place of: its motion, reference, landscape of one model, ...
Slot = tuple[Literal["motion", "reference", "ghost", "landscape", "recognition", "export"], int]
