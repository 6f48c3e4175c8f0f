"""Small made-up pictures for the tests of panels, boards and robots; nothing is computed."""

from __future__ import annotations

from collections.abc import Coroutine
from dataclasses import replace
from typing import Any

import numpy as np

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.computed import Computed, Entry
from rnnpb_explorer.app.state.document import Document, Target, target_of_motion
from rnnpb_explorer.app.state.facts import Array, Facts, ModelFacts
from rnnpb_explorer.app.state.on_recognition import follow
from rnnpb_explorer.app.state.opening import opening_document
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.results import (
    CheckedMotion,
    LandscapeResult,
    MotionResult,
    RecognitionTrace,
    Result,
)
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.app.state.wanted import recognise_work, wanted
from rnnpb_explorer.app.state.work import LandscapeWork, MotionWork, Work
from rnnpb_explorer.core.latent_map import LatentMap
from rnnpb_explorer.core.motion import Motion, MotionLabel
from rnnpb_explorer.core.windows import Landscape
from rnnpb_explorer.robot.safety_report import SafetyReport, Violation

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


def opening(facts: Facts = FACTS) -> Picture:
    """The opening screen before anything was computed."""
    return Picture(facts, opening_document(facts), Computed.nothing())


def open_screen(facts: Facts = FACTS) -> Picture:
    """The opening screen with everything that it shows."""
    return answered(opening(facts))


def after(picture: Picture, *asked: do.DocumentIntent) -> Picture:
    """The picture once a person did this; what is computed is behind then."""
    document = picture.document
    for intent in asked:
        document = update(picture.facts, document, intent)
    kept = picture.computed.keep(wanted(picture.facts, document))
    return Picture(picture.facts, document, kept)


def answered(picture: Picture) -> Picture:
    """The picture once motions and landscapes have come; motions are of their first component."""
    computed, works = picture.computed, wanted(picture.facts, picture.document)
    for slot, work in computed.missing(works).items():
        result = made_up(picture.facts, work)
        if result is not None:
            computed = computed.put(works, slot, Entry(work, result, done=True))
    return replace(picture, computed=computed)


def made_up(facts: Facts, work: Work) -> Result | None:
    if isinstance(work, MotionWork):
        shape = work.steps, len(facts[work.model].joints)
        return MotionResult(np.full(shape, work.pb[0], dtype=np.float32), checked_motion())
    if isinstance(work, LandscapeWork):
        axis = np.linspace(-1.0, 1.0, 20)
        return LandscapeResult(Landscape(np.zeros((20, 20), np.float32), axis, axis))
    return None


def checked_motion(*violations: Violation) -> CheckedMotion:
    return CheckedMotion(SafetyReport(violations, ()), None)


def checked(picture: Picture, *violations: Violation, limited: float | None = None) -> Picture:
    """The picture once its motion was checked, and found to break these limits."""
    slot = "motion", picture.active
    entry = picture.computed.entries[slot]
    assert isinstance(entry.result, MotionResult)
    positions = entry.result.positions
    within = None if limited is None else np.full_like(positions, limited)
    check = CheckedMotion(SafetyReport(violations, ()), within)
    entry = replace(entry, result=MotionResult(positions, check))
    return replace(
        picture, computed=replace(picture.computed, entries={**picture.computed.entries, slot: entry})
    )


def came_to(picture: Picture, trace: RecognitionTrace) -> Picture:
    """The picture once its run has come so far."""
    work = recognise_work(picture.document)
    assert work is not None
    works = wanted(picture.facts, picture.document)
    computed = picture.computed.put(works, ("recognition", 0), Entry(work, trace, done=False))
    document = follow(picture.facts, picture.document, trace)
    return Picture(picture.facts, document, computed)


def broke_off(picture: Picture, message: str) -> Picture:
    """The picture once its run has failed, as the session shows it."""
    work = recognise_work(picture.document)
    assert work is not None
    failed = picture.computed.fail(("recognition", 0), work, message)
    ended = update(picture.facts, picture.document, do.CancelRecognition())
    return Picture(picture.facts, ended, failed.keep(wanted(picture.facts, ended)))


def target_motion(
    frames: int = 10, name: str = "given", joints: tuple[str, ...] = JOINTS
) -> Motion:
    positions = np.linspace(0.0, 1.0, frames * len(joints), dtype=np.float32)
    return Motion(name, joints, positions.reshape(frames, len(joints)), fps=20.0)


def given(frames: int = 10, name: str = "given", joints: tuple[str, ...] = JOINTS) -> Target:
    return target_of_motion(target_motion(frames, name, joints))


def make_trace(
    mu: Array, *, loss: Array | None = None, epsilon: float = 0.5, sigma: float = 0.2
) -> RecognitionTrace:
    """A trace along given mu, (S + 1, K, D); every PB is mu + sigma * epsilon."""
    mu = np.asarray(mu, dtype=np.float64)
    steps, trials = len(mu) - 1, mu.shape[1]
    spread = np.full_like(mu, sigma)
    falling = np.linspace(1.0, 0.1, steps * trials).reshape(steps, trials)
    return RecognitionTrace(
        mu=mu,
        sigma=spread,
        pb=(mu + spread * epsilon)[:-1],
        loss=falling if loss is None else np.asarray(loss, dtype=np.float64),
        prediction_error=2 * falling,
        early_update=np.zeros((steps, trials), dtype=np.bool_),
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


class Clock:
    """A clock that a test moves."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def latent_mu(document: Document, index: int | None = None) -> tuple[float, ...]:
    return document.models[document.active if index is None else index].latent.mu
