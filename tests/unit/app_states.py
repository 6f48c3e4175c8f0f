"""Small made-up screens for the tests of the app's logic; nothing is loaded or computed."""

from __future__ import annotations

from collections.abc import Coroutine, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import (
    AppState,
    Array,
    ComputedLandscape,
    ModelFacts,
    RecognitionTrace,
    initial_state,
)
from rnnpb_explorer.app.state.transitions import Facts, Update, opening_work
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.core.latent_map import LatentMap
from rnnpb_explorer.core.motion import Motion, MotionLabel
from rnnpb_explorer.core.windows import Landscape

JOINTS = ("a", "b", "c", "d", "e")
NAMES = ("wave", "bow", "rest", "nod")
LENGTHS = (12, 9, 15, 21)
MU = np.array([[0.5, -0.3, 0.2], [-0.4, 0.6, -0.1], [0.1, 0.2, -0.7], [-0.6, -0.5, 0.4]])
SIGMA = np.array([[0.1, 0.2, 0.3], [0.2, 0.2, 0.2], [0.3, 0.1, 0.2], [0.1, 0.1, 0.1]])


def make_facts(
    dim: int = 3,
    name: str = "tiny",
    names: tuple[str, ...] = NAMES,
    *,
    stochastic: bool = True,
    joints: tuple[str, ...] = JOINTS,
    data: tuple[Motion | None, ...] | None = None,
) -> ModelFacts:
    """Four motions; with three dimensions the learned PBs are `MU` and `SIGMA`."""
    mu, sigma = MU, SIGMA
    if dim != 3 or len(names) != len(MU):
        random = np.random.default_rng(dim)
        mu = random.normal(size=(len(names), dim))
        sigma = random.uniform(0.1, 0.5, size=(len(names), dim))
    return ModelFacts(
        name=name,
        mu=mu,
        sigma=sigma if stochastic else np.zeros_like(mu),
        stochastic=stochastic,
        beta=1e-3 if stochastic else None,
        joints=joints,
        fps=20.0,
        motions=names,
        lengths=LENGTHS[: len(names)],
        labels={one: MotionLabel(one) for one in names},
        latent_map=LatentMap.fit(mu),
        data=data or (None,) * len(names),
    )


FACTS = (make_facts(),)
ONE_DIMENSION = (make_facts(1, "line"),)
TWELVE_DIMENSIONS = (make_facts(12, "wide"),)


def open_screen(facts: Facts = FACTS) -> AppState:
    """The opening screen, its first motions and landscapes computed."""
    state, works = opening_work(facts, initial_state(facts))
    return answer(facts, state, works)


def answer(facts: Facts, state: AppState, works: Sequence[do.Work]) -> AppState:
    """What a worker that does everything would make of the screen."""
    for work in works:
        if isinstance(work, do.GenerateWork):
            state = after(facts, state, motion_result(work))
        elif isinstance(work, do.LandscapeWork):
            state = after(facts, state, landscape_result(work))
    return state


def motion_result(work: do.GenerateWork, joints: int = len(JOINTS)) -> do.MotionReady:
    positions = np.full((work.steps, joints), work.request, dtype=np.float32)
    reference = work.target if work.target is not None else positions
    return do.MotionReady(work.model, work.request, positions, reference)


def landscape_result(work: do.LandscapeWork, *, complete: bool = True) -> do.LandscapeReady:
    axis = np.linspace(-1.0, 1.0, 20)
    values = Landscape(np.zeros((20, 20), np.float32), axis, axis, complete=complete)
    return do.LandscapeReady(work.model, ComputedLandscape(work.request, values))


def after(facts: Facts, state: AppState, *intents: do.Intent) -> AppState:
    """The state after some intents, whatever work they want."""
    for intent in intents:
        state, _ = update(facts, state, intent)
    return state


def wanted(update_: Update) -> list[tuple[type, int]]:
    """Kind and model of the work that an update wants."""
    _, works = update_
    return [(type(work), getattr(work, "model", -1)) for work in works]


def landscapes(works: Sequence[do.Work]) -> list[do.LandscapeWork]:
    return [work for work in works if isinstance(work, do.LandscapeWork)]


def motions(works: Sequence[do.Work]) -> list[do.GenerateWork]:
    return [work for work in works if isinstance(work, do.GenerateWork)]


def target_motion(
    frames: int = 10, name: str = "given", joints: tuple[str, ...] = JOINTS
) -> Motion:
    positions = np.linspace(0.0, 1.0, frames * len(joints), dtype=np.float32)
    return Motion(name, joints, positions.reshape(frames, len(joints)), fps=20.0)


def make_trace(
    mu: Array, *, loss: Array | None = None, epsilon: float = 0.5, sigma: float = 0.2
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
        prediction_error=2 * falling,
        early_update=early,
    )


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
