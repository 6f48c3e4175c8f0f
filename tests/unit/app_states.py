"""Small made-up models, documents and results for the tests of the app; nothing is loaded."""

from __future__ import annotations

from collections.abc import Coroutine, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.computed import Computed, Entry
from rnnpb_explorer.app.state.document import Document, Target, target_of_motion
from rnnpb_explorer.app.state.facts import Facts, ModelFacts
from rnnpb_explorer.app.state.history import History, gesture_of
from rnnpb_explorer.app.state.on_recognition import break_off, follow
from rnnpb_explorer.app.state.opening import opening_document
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.results import LandscapeResult, MotionResult, RecognitionTrace, Result
from rnnpb_explorer.app.state.statecode import decode
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.app.state.wanted import wanted
from rnnpb_explorer.app.state.work import LandscapeWork, MotionWork, Slot, Work
from rnnpb_explorer.core.latent_map import LatentMap
from rnnpb_explorer.core.motion import Motion, MotionLabel
from rnnpb_explorer.core.windows import Landscape

JOINTS = ("a", "b", "c", "d", "e")
NAMES = ("wave", "bow", "rest", "nod")
LENGTHS = (12, 9, 15, 21)
MU = np.array([[0.5, -0.3, 0.2], [-0.4, 0.6, -0.1], [0.1, 0.2, -0.7], [-0.6, -0.5, 0.4]])
SIGMA = np.array([[0.1, 0.2, 0.3], [0.2, 0.2, 0.2], [0.3, 0.1, 0.2], [0.1, 0.1, 0.1]])
MOTION, LANDSCAPE, REFERENCE, RUN, CODEBOOK, BELIEF = (
    ("motion", 0),
    ("landscape", 0),
    ("reference", 0),
    ("recognition", 0),
    ("codebook", 0),
    ("belief", 0),
)


def make_facts(
    dim: int = 3,
    name: str = "tiny",
    names: tuple[str, ...] = NAMES,
    *,
    mu: ArrayLike | None = None,
    stochastic: bool = True,
    joints: tuple[str, ...] = JOINTS,
    data: tuple[Motion | None, ...] | None = None,
) -> ModelFacts:
    """Four motions; with three dimensions the learned PBs are `MU` and `SIGMA`."""
    known = dim == 3 and len(names) == len(MU)
    random = np.random.default_rng(dim)
    drawn = random.normal(size=(len(names), dim)), random.uniform(0.1, 0.5, (len(names), dim))
    learned, sigma = (MU, SIGMA) if known else drawn
    if mu is not None:
        learned = np.asarray(mu, dtype=np.float64)
    return ModelFacts(
        name=name,
        mu=learned,
        sigma=sigma if stochastic else np.zeros_like(learned),
        stochastic=stochastic,
        beta=1e-3 if stochastic else None,
        joints=joints,
        fps=20.0,
        motions=names,
        lengths=LENGTHS[: len(names)],
        labels={one: MotionLabel(one) for one in names},
        latent_map=LatentMap.fit(learned),
        data=data or (None,) * len(names),
    )


FACTS = (make_facts(),)
ONE_DIMENSION = (make_facts(1, "line"),)
TWELVE_DIMENSIONS = (make_facts(12, "wide"),)


# --- documents ---
PUBLISHED = do.SetRecognitionOption("method", "paper")


def opened(facts: Facts = FACTS, *intents: do.DocumentIntent) -> Document:
    """The opening document, and what intents make of it; runs are of the published procedure."""
    return after(facts, opening_document(facts), PUBLISHED, *intents)


def after(facts: Facts, document: Document, *intents: do.DocumentIntent) -> Document:
    for intent in intents:
        document = update(facts, document, intent)
    return document


def newly_wanted(facts: Facts, document: Document, *intents: do.DocumentIntent) -> dict[Slot, Work]:
    """The work that intents ask for and that the document before did not."""
    before = wanted(facts, document)
    works = wanted(facts, after(facts, document, *intents))
    return {slot: work for slot, work in works.items() if before.get(slot) != work}


def motion_of(works: Mapping[Slot, Work], index: int = 0) -> MotionWork:
    work = works["motion", index]
    assert isinstance(work, MotionWork)
    return work


def landscape_of(works: Mapping[Slot, Work], index: int = 0) -> LandscapeWork:
    work = works["landscape", index]
    assert isinstance(work, LandscapeWork)
    return work


def target_motion(
    frames: int = 10, name: str = "given", joints: tuple[str, ...] = JOINTS
) -> Motion:
    positions = np.linspace(0.0, 1.0, frames * len(joints), dtype=np.float32)
    return Motion(name, joints, positions.reshape(frames, len(joints)), fps=20.0)


def make_target(frames: int = 10, name: str = "given", joints: tuple[str, ...] = JOINTS) -> Target:
    return target_of_motion(target_motion(frames, name, joints))


# --- results ---
def motion_result(work: MotionWork, joints: int = len(JOINTS)) -> MotionResult:
    """A motion that stands still at its PB's first component."""
    return MotionResult(np.full((work.steps, joints), work.pb[0], dtype=np.float32))


def landscape_result(*, complete: bool = True) -> LandscapeResult:
    axis = np.linspace(-1.0, 1.0, 20)
    return LandscapeResult(Landscape(np.zeros((20, 20), np.float32), axis, axis, complete=complete))


def make_trace(
    mu: ArrayLike,
    *,
    loss: ArrayLike | None = None,
    epsilon: float = 0.5,
    sigma: float = 0.2,
    finished: bool = False,
) -> RecognitionTrace:
    """A trace along given mu, (S + 1, K, D); every PB is mu + sigma * epsilon."""
    mu = np.asarray(mu, dtype=np.float64)
    steps, trials = len(mu) - 1, mu.shape[1]
    spread = np.full_like(mu, sigma)
    falling = np.linspace(1.0, 0.1, steps * trials).reshape(steps, trials)
    early: NDArray[np.bool_] = np.zeros((steps, trials), dtype=np.bool_)
    return RecognitionTrace(
        mu=mu,
        sigma=spread,
        pb=(mu + spread * epsilon)[:-1],
        loss=falling if loss is None else np.asarray(loss, dtype=np.float64),
        kl=np.zeros_like(falling),
        prediction_error=2 * falling,
        early_update=early,
        finished=finished,
    )


class Page:
    """One page as its session keeps it, without a browser and without an engine."""

    def __init__(self, facts: Facts = FACTS, document: Document | None = None) -> None:
        self.facts, self.now = facts, 0.0
        self.history = History(opened(facts) if document is None else document)
        self.computed = Computed.nothing()

    @property
    def document(self) -> Document:
        return self.history.present

    @property
    def wanted(self) -> dict[Slot, Work]:
        return wanted(self.facts, self.document, self.computed)

    @property
    def missing(self) -> dict[Slot, Work]:
        return self.computed.missing(self.wanted)

    @property
    def picture(self) -> Picture:
        return Picture(self.facts, self.document, self.computed)

    def do(self, *intents: do.DocumentIntent | do.HistoryIntent) -> Page:
        for intent in intents:
            if isinstance(intent, do.Undo):
                self.history = self.history.undo()
            elif isinstance(intent, do.Redo):
                self.history = self.history.redo()
            elif isinstance(intent, do.RestoreCode):
                self.history = self.history.step(decode(self.facts, intent.code), "", self.now)
            else:
                next_one = update(self.facts, self.document, intent)
                self.history = self.history.step(next_one, gesture_of(intent), self.now)
            self._follow()
        return self

    def deliver(
        self, slot: Slot, result: Result, *, done: bool = True, work: Work | None = None
    ) -> Page:
        """A result of this work, by default of the one that is wanted."""
        entry = Entry(self.wanted[slot] if work is None else work, result, done)
        self.computed = self.computed.put(self.wanted, slot, entry)
        self._follow()
        return self

    def fail(self, slot: Slot, message: str) -> Page:
        self.computed = self.computed.fail(slot, self.wanted[slot], message)
        if slot == RUN:
            self.history = self.history.revise(break_off(self.facts, self.document))
        self._follow()
        return self

    def compute(self) -> Page:
        """All that is missing but the iterations of a run."""
        for slot, work in self.missing.items():
            if isinstance(work, MotionWork):
                self.deliver(slot, motion_result(work))
            elif isinstance(work, LandscapeWork):
                self.deliver(slot, landscape_result())
        return self

    def _follow(self) -> None:
        trace = self.picture.whole_trace
        if trace is not None:
            self.history = self.history.revise(follow(self.facts, self.document, trace))
        self.computed = self.computed.keep(self.wanted)


def hand_on(coroutine: Coroutine[Any, Any, None]) -> None:
    """Run a callback of viser's event loop, which hands on and never waits: one step ends it.

    No loop of asyncio's is needed, so that it does not matter whether one runs in this thread.
    """
    try:
        coroutine.send(None)
    except StopIteration:
        return
    coroutine.close()
    raise AssertionError("a callback of viser's event loop waited for something")
