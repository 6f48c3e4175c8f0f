"""The work that a document wants, and what its motions are compared with. Pure."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ...core.errors import InputError
from ...core.motion import MAX_FRAMES
from ...core.recognition_run import LM_ITERATIONS
from .computed import Computed
from .document import Document, ExportOptions, EyeTrack, RecognitionSettings, Target
from .facts import Facts, ModelFacts
from .planes import landscape_plane
from .results import RecognitionTrace, WaysResult
from .work import (
    BeliefWork,
    CodebookWork,
    ExportWork,
    LandscapeWork,
    MotionWork,
    RecogniseWork,
    Slot,
    StretchWork,
    TakeAway,
    TakeAwayWork,
    Vector,
    WaysWork,
    Work,
)

# Of a work's coordinates, so that a move within a plane, which changes rounding, wants no new work.
DECIMALS = 9
GHOSTS = 8  # samples that are shown around a robot


def wanted(facts: Facts, document: Document, known: Computed | None = None) -> dict[Slot, Work]:
    """Everything that the screen of this document shows and that has to be computed.

    Args:
        known: what there is already: some of what is wanted is computed from it.
    """
    works: dict[Slot, Work] = {}
    for index in range(len(facts)):
        works["motion", index] = motion_work(facts, document, index)
        reference = reference_work(facts, document, index)
        if reference is not None:
            works["reference", index] = reference
        if document.ghosts and facts[index].stochastic:
            for number, work in enumerate(ghost_works(facts, document, index)):
                works["ghost", GHOSTS * index + number] = work
        # A recognition passes through many landscapes; the one where it ends is wanted.
        if not (document.running and document.run is not None and document.run.model == index):
            works["landscape", index] = landscape_work(facts, document, index)
    run = recognise_work(facts, document)
    if run is not None:
        works["recognition", 0] = run
    active = document.active
    if given_target(facts, document, active) is not None:
        works["codebook", active] = CodebookWork(facts[active].name)
        entries = known.codebook_entries(active) if known else 0
        if document.cloud and entries:
            works["belief", active] = belief_work(facts, document, entries)
    for index in document.on_boards:
        ways = ways_work(facts, document, index)
        if ways is not None:
            works["ways", index] = ways
        if ways is not None or document.compare:
            works["stretch", index] = StretchWork(
                facts[index].name, document.models[index].latent.mu
            )
        walk = walk_work(facts, document, index, known_ways(facts, document, index, known))
        if walk is not None:
            works["walk", index] = walk
    return works


# --- what motions are compared with ---
def given_target(facts: Facts, document: Document, index: int) -> Target | None:
    """The motion that a person gave, where a model is compared with it."""
    target = document.target
    used = target is not None and document.use_target and target.joints == facts[index].joints
    return target if used else None


def seen_target(facts: Facts, document: Document, index: int) -> NDArray[np.float32] | None:
    """(T', J) of a target what one may see: what is observed, until all is revealed.

    NaN in the joints that are hidden.
    """
    target = given_target(facts, document, index)
    if target is None or document.revealed:
        return None if target is None else target.array
    settings = document.recognition
    seen = target.array[: max(1, int(settings.observed * len(target)))]
    joints = joint_indices(facts[index], settings.joints)
    if not joints:
        return seen
    hidden = np.full_like(seen, np.nan)
    hidden[:, joints] = seen[:, joints]
    return hidden


def known_reference(facts: Facts, document: Document, index: int) -> NDArray[np.float32] | None:
    """(T, J) what a model's motion is compared with; None = its own reconstruction."""
    target = given_target(facts, document, index)
    if target is not None:
        return target.array
    data = facts[index].data[document.models[index].latent.motion]
    return None if data is None else data.positions


def motion_steps(facts: Facts, document: Document, index: int) -> int:
    """Frames of a model's motion: as many as what it is compared with; of a morph, as both ends."""
    if morphs(facts, document, index):
        goal = facts[index].motions.index(document.goal)
        start = document.models[index].latent.motion
        return min(facts[index].lengths[start] + facts[index].lengths[goal], MAX_FRAMES)
    reference = known_reference(facts, document, index)
    motion = document.models[index].latent.motion
    return facts[index].lengths[motion] if reference is None else len(reference)


def eyes_of(facts: Facts, document: Document, index: int) -> EyeTrack | None:
    """The eye colours that came with what a model's motion is compared with."""
    target = given_target(facts, document, index)
    if target is not None:
        return target.eye_track
    tracks = facts[index].eyes
    return tracks[document.models[index].latent.motion] if tracks else None


# --- the works ---
def motion_work(facts: Facts, document: Document, index: int) -> MotionWork:
    return MotionWork(
        model=facts[index].name,
        pb=document.models[index].latent.pb,
        steps=motion_steps(facts, document, index),
        along=_along(facts, document, index),
        check="limited" if document.side_by_side and index == document.active else "report",
    )


def morphs(facts: Facts, document: Document, index: int) -> bool:
    """Whether a model's motion goes along the straight line to the goal."""
    return document.walk == "morph" and ways_work(facts, document, index) is not None


def _along(facts: Facts, document: Document, index: int) -> tuple[Vector, ...]:
    ways = ways_work(facts, document, index)
    return (ways.start, ways.end) if ways is not None and document.walk == "morph" else ()


def walk_work(
    facts: Facts, document: Document, index: int, ways: WaysResult | None
) -> MotionWork | None:
    """The motion on the shortest way, where the model's own is on the straight line."""
    if document.walk is None or ways is None:
        return None
    pbs = [_vector(pb) for pb in ways.shortest.pbs]
    steps = motion_steps(facts, document, index)
    if document.walk == "morph":
        return MotionWork(facts[index].name, pbs[0], steps, along=tuple(pbs))
    return MotionWork(facts[index].name, pbs[document.walk], steps)


def ghost_works(facts: Facts, document: Document, index: int) -> list[MotionWork]:
    """Samples from N(mu, sigma^2). Their noise stays, so that sigma opens and closes the fan."""
    latent = document.models[index].latent
    noise = np.random.default_rng([document.seed, GHOSTS]).standard_normal((GHOSTS, len(latent.mu)))
    pbs = np.array(latent.mu) + np.array(latent.sigma) * noise
    steps = motion_steps(facts, document, index)
    return [MotionWork(facts[index].name, tuple(pb.tolist()), steps) for pb in pbs]


def reference_work(facts: Facts, document: Document, index: int) -> MotionWork | None:
    """The own reconstruction of the selected motion, at (mu_i, sigma = 0), where it stands in."""
    if known_reference(facts, document, index) is not None:
        return None
    one, motion = facts[index], document.models[index].latent.motion
    return MotionWork(one.name, tuple(one.mu[motion].tolist()), one.lengths[motion])


def landscape_work(facts: Facts, document: Document, index: int) -> LandscapeWork:
    where = landscape_plane(facts[index], document, document.models[index])
    target = given_target(facts, document, index)
    return LandscapeWork(
        model=facts[index].name,
        center=_vector(where.center),
        directions=tuple(_vector(row) for row in where.directions),
        zero=_vector(where.zero),
        radius=where.radius,
        target=target,
        motion=-1 if target is not None else document.models[index].latent.motion,
        labels=where.labels,
    )


def way_ends(facts: ModelFacts, document: Document, motion: int) -> tuple[Vector, Vector] | None:
    """The learned mu of a motion and of the goal; None where there is no way."""
    if document.goal not in facts.motions or facts.motions[motion] == document.goal:
        return None
    goal = facts.motions.index(document.goal)
    return tuple(facts.mu[motion].tolist()), tuple(facts.mu[goal].tolist())


def ways_work(facts: Facts, document: Document, index: int) -> WaysWork | None:
    """From a model's selected motion to the goal; None where it does not know both."""
    ends = way_ends(facts[index], document, document.models[index].latent.motion)
    return None if ends is None else WaysWork(facts[index].name, *ends)


def known_ways(
    facts: Facts, document: Document, index: int, known: Computed | None
) -> WaysResult | None:
    """What was found of a model's ways to the goal."""
    entry = known.entries.get(("ways", index)) if known else None
    work = ways_work(facts, document, index)
    if entry is None or work is None or not entry.answers(work):
        return None  # of another way
    return entry.result if isinstance(entry.result, WaysResult) else None


def joint_indices(facts: ModelFacts, names: tuple[str, ...]) -> tuple[int, ...]:
    """Which of a model's joints are named; () for all of them."""
    chosen = tuple(i for i, joint in enumerate(facts.joints) if joint in names)
    return () if len(chosen) == len(facts.joints) else chosen


def most_iterations(document: Document, settings: RecognitionSettings) -> int:
    """How many iterations a run has at most."""
    if settings.method == "live":
        return 0 if document.target is None else int(settings.observed * len(document.target))
    return settings.iterations if settings.method == "paper" else LM_ITERATIONS


def recognise_work(facts: Facts, document: Document) -> RecogniseWork | None:
    run = document.run
    if run is None or document.target is None:
        return None
    settings = run.settings
    paper, cut = settings.method == "paper", run.settled and not run.finished
    return RecogniseWork(
        model=facts[run.model].name,
        target=document.target,
        method=settings.method,
        observed=settings.observed,
        joints=joint_indices(facts[run.model], settings.joints),
        beta=settings.beta if facts[run.model].stochastic else 0.0,
        init=settings.init if paper else "learned",
        iterations=run.done if cut else settings.iterations if paper else None,
        trials=settings.trials if paper else 1,
        seed=run.seed if paper else 0,
    )


def belief_work(facts: Facts, document: Document, entries: int) -> BeliefWork:
    assert document.target is not None
    settings = document.recognition
    return BeliefWork(
        model=facts[document.active].name,
        target=document.target,
        observed=settings.observed,
        joints=joint_indices(facts[document.active], settings.joints),
        scale=document.error_scale,
        entries=entries,
    )


def take_away_work(
    facts: Facts, document: Document, trace: RecognitionTrace | None, what: TakeAway
) -> TakeAwayWork:
    """What the run came to by now, as a file.

    Raises:
        InputError: there is none.
    """
    run, work = document.run, recognise_work(facts, document)
    if run is None or work is None or trace is None or document.target is None:
        raise InputError("There is no recognition yet: press Start first")
    name = f"{document.target.name} {facts[run.model].name}"
    return TakeAwayWork(work, trace, what, run.trial, name)


def export_work(
    facts: Facts, document: Document, options: ExportOptions | None = None
) -> ExportWork:
    """What is on the screen now, as a file; with the document's own options by default."""
    index = document.active
    one = facts[index]
    motion = dataclasses.replace(motion_work(facts, document, index), check="no")
    to = f" to {document.goal}" if motion.along else ""
    name = f"{one.motions[document.current.latent.motion]}{to} {one.name}"
    return ExportWork(motion, name, document.export if options is None else options)


def _vector(values: NDArray[np.float64]) -> Vector:
    return tuple((np.round(values, DECIMALS) + 0.0).tolist())  # + 0.0: no -0.0
