"""What a recognition does to the document: its target, its settings, its run. Pure.

The document says which run there is; its iterations are computed (results.RecognitionTrace). As
long as nobody takes the latent into the hand, it is what the run shows: `follow` puts it there. A
run may be computed faster than it is shown: `until` says how far it is followed by now; a pause, a
single step and a slow pace are nothing else.
"""

from __future__ import annotations

from typing import Any, assert_never, get_args

import numpy as np
from msgspec.structs import replace

from ...core.errors import InputError
from ...core.recognition_run import Init, Method
from . import intents as do
from .document import (
    MAX_ADDED,
    MAX_BETA,
    MAX_COUNT,
    MAX_ITERATIONS,
    MAX_TRIALS,
    MIN_OBSERVED,
    Added,
    Document,
    Latent,
    Run,
    vector,
)
from .facts import Facts
from .on_latent import count_draw, end_run, hold_pucks, put_latent
from .results import RecognitionTrace
from .wanted import most_iterations

SMALLEST_SIGMA = 1e-6  # below it, the noise that made a PB cannot be told from rounding


def update_recognition(facts: Facts, document: Document, intent: do.RecognitionIntent) -> Document:
    match intent:
        case do.SetTarget(target):
            return replace(document, target=target, use_target=True, revealed=False, run=None)
        case do.ClearTarget():
            return replace(document, target=None, run=None)
        case do.SetRecognitionOption(name, value):
            return _set_option(facts, document, name, value)
        case do.StartRecognition():
            return _start(facts, document)
        case do.PauseRecognition(paused):
            return _pause(document, paused)
        case do.StepRecognition():
            return advance(_pause(document, True))
        case do.CancelRecognition():
            return end_run(document) if document.running else document
        case do.ScrubRecognition(iteration, trial):
            return _scrub(document, iteration, trial)
        case do.AddToMap(name):
            return _add(document, name)
        case do.RemoveAdded():
            left = tuple(one for one in document.added if one.model != document.active)
            return replace(document, added=left)
        case do.SelectAdded(index):
            return _select_added(document, index)
        case _:
            assert_never(intent)


def _set_option(facts: Facts, document: Document, name: str, value: Any) -> Document:
    """Settings hold from the next start on."""
    if name in ("init", "method"):
        if value not in get_args(Init if name == "init" else Method):
            return document
    elif name == "joints":
        known = facts[document.active].joints
        value = tuple(joint for joint in known if joint in value)
        if not value:
            raise InputError("At least one joint has to be observed")
        value = () if len(value) == len(known) else value
    elif name == "slow":
        value = bool(value)
    elif not np.isfinite(value):
        return document
    elif name == "observed":
        value = float(np.clip(value, MIN_OBSERVED, 1.0))
    elif name == "beta":
        value = float(np.clip(value, 0.0, MAX_BETA))
    else:
        value = int(np.clip(value, 1, MAX_ITERATIONS if name == "iterations" else MAX_TRIALS))
    return replace(document, recognition=replace(document.recognition, **{name: value}))


# --- a run ---
def _start(facts: Facts, document: Document) -> Document:
    """Recognise the target with the active model."""
    target = document.target
    if target is None:
        raise InputError("Upload a motion or choose an example first")
    if target.joints != facts[document.active].joints:
        raise InputError(f"{target.name} has other joints than this model")
    settings = document.recognition
    if most_iterations(document, settings) < 1:
        raise InputError(f"{settings.observed:.0%} of {target.name} leaves no frame to observe")
    seed = (document.seed + document.draws) % (MAX_COUNT + 1)
    run = Run(document.active, settings, seed, until=1 if settings.slow else None)
    document = replace(count_draw(document), run=run, use_target=True, revealed=False, walk=None)
    if settings.method == "live":  # the motion begins to arrive now
        playback = replace(document.playback, playing=True, phase=0.0, speed=1.0)
        document = replace(document, playback=playback)
    return document


def _pause(document: Document, paused: bool) -> Document:
    run = document.run
    if run is None or run.settled:
        return document
    until = run.done if paused else run.done + 1 if run.settings.slow else None
    return replace(document, run=replace(run, paused=paused, until=until))


def advance(document: Document) -> Document:
    """Follow a run that waits for it one iteration further."""
    run = document.run
    if run is None or run.settled or run.until is None:
        return document
    return replace(document, run=replace(run, until=run.done + 1))


def _scrub(document: Document, iteration: int, trial: int) -> Document:
    """Show one iteration again: its mu and sigma, and the motion of the PB sampled there."""
    run = document.run
    if run is None or not run.settled or run.done == 0:
        return document
    iteration = int(np.clip(iteration, 0, run.done - 1))
    trials = run.settings.trials if run.settings.method == "paper" else MAX_TRIALS
    trial = int(np.clip(trial, 0, trials - 1))
    run = replace(run, shown=iteration, trial=trial, follows=True)
    return replace(document, run=run)


def follow(facts: Facts, document: Document, trace: RecognitionTrace) -> Document:
    """The document once its run has come so far: `trace`, the iterations that are there."""
    run = document.run
    if run is None or trace.iterations < 1:
        return document
    if run.settings.method == "paper":  # the same run may have been wanted longer
        trace = trace.first(run.settings.iterations)
    if trace.iterations < run.done or (run.finished and not _came_to_its_end(run, trace)):
        return document  # a run that comes back is computed once more; until then all stays
    if not run.settled:
        done = min(trace.iterations, trace.iterations if run.until is None else run.until)
        ended = _came_to_its_end(run, trace) and done == trace.iterations
        run = replace(run, done=max(done, run.done), settled=ended, finished=ended)
        if ended:
            run = replace(run, trial=trace.best[1])
        document = replace(document, run=run)
    if not run.follows or run.done == 0:
        return document
    old = document.models[run.model].latent
    latent = _best(old, trace) if at_best(run) else _iterate(old, trace, run)
    document = put_latent(document, run.model, latent)
    return hold_pucks(facts, document) if run.settled else document


def _came_to_its_end(run: Run, trace: RecognitionTrace) -> bool:
    """The published procedure ends after so many iterations, the others say themselves when."""
    if run.settings.method == "paper":
        return trace.iterations >= run.settings.iterations
    return trace.finished


def break_off(facts: Facts, document: Document) -> Document:
    """The document whose run failed: it ends where it stands."""
    return hold_pucks(facts, end_run(document))


def at_best(run: Run) -> bool:
    """Whether the run shows the best PB of all trials, which no single iterate is."""
    return run.finished and run.shown is None and run.settings.method != "live"


def shown_iteration(run: Run, trace: RecognitionTrace) -> int:
    """The iteration that is on the screen, from 0: by hand, or by the run itself."""
    if run.shown is not None:
        return min(run.shown, trace.iterations - 1)
    return trace.best[0] if at_best(run) else trace.iterations - 1


def _best(latent: Latent, trace: RecognitionTrace) -> Latent:
    """The best PB sampled in all trials, as the early update jumps to it."""
    iteration, trial = trace.best
    mu, sigma = trace.pb[iteration, trial], trace.sigma[iteration + 1, trial]
    if trace.posterior is not None:
        sigma = trace.posterior.sigma
    return replace(latent, mu=vector(mu), sigma=vector(sigma), epsilon=(0.0,) * len(mu))


def _iterate(latent: Latent, trace: RecognitionTrace, run: Run) -> Latent:
    """The latent at one iteration, with the noise that made the PB sampled there."""
    trace = trace.first(run.done)
    at = shown_iteration(run, trace), min(run.trial, trace.loss.shape[1] - 1)
    mu, sigma = trace.mu[at], trace.sigma[at]
    noise = trace.pb[at] - mu
    epsilon = np.divide(noise, sigma, out=np.zeros_like(mu), where=sigma > SMALLEST_SIGMA)
    return replace(latent, mu=vector(mu), sigma=vector(sigma), epsilon=vector(epsilon))


# --- points of one's own ---
def _add(document: Document, name: str) -> Document:
    if len(document.added) >= MAX_ADDED:
        raise InputError(f"The map takes {MAX_ADDED} points; take some away first")
    latent = document.current.latent
    added = Added(document.active, name[:255], latent.pb, latent.sigma)
    return replace(document, added=(*document.added, added))


def _select_added(document: Document, index: int) -> Document:
    if not 0 <= index < len(document.added):
        return document
    added = document.added[index]
    if added.model != document.active:
        return document
    latent = replace(
        document.current.latent, mu=added.mu, sigma=added.sigma, epsilon=(0.0,) * len(added.mu)
    )
    document = put_latent(document, document.active, latent)
    return end_run(document, by_hand=True)
