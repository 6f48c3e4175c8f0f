"""What a recognition does to the document: its target, its settings, its run. Pure.

The document says which run there is; its iterations are computed (results.RecognitionTrace). As
long as nobody takes the latent into the hand, it is what the run shows: `follow` puts it there.
"""

from __future__ import annotations

from typing import Any, assert_never, get_args

import numpy as np
from msgspec.structs import replace

from ...core.errors import InputError
from ...core.recognition_run import Init
from . import intents as do
from .document import (
    MAX_COUNT,
    MAX_ITERATIONS,
    MAX_TRIALS,
    MIN_OBSERVED,
    Document,
    Latent,
    Run,
    vector,
)
from .facts import Facts
from .on_latent import count_draw, end_run, hold_pucks, put_latent
from .results import RecognitionTrace

SMALLEST_SIGMA = 1e-6  # below it, the noise that made a PB cannot be told from rounding


def update_recognition(facts: Facts, document: Document, intent: do.RecognitionIntent) -> Document:
    match intent:
        case do.SetTarget(target):
            return replace(document, target=target, use_target=True, revealed=False, run=None)
        case do.ClearTarget():
            return replace(document, target=None, run=None)
        case do.SetRecognitionOption(name, value):
            return _set_option(document, name, value)
        case do.StartRecognition():
            return _start(facts, document)
        case do.CancelRecognition():
            return end_run(document) if document.running else document
        case do.ScrubRecognition(iteration, trial):
            return _scrub(document, iteration, trial)
        case _:
            assert_never(intent)


def _set_option(document: Document, name: str, value: Any) -> Document:
    """Settings hold from the next start on."""
    if name == "init":
        if value not in get_args(Init):
            return document
    elif not np.isfinite(value):
        return document
    elif name == "observed":
        value = float(np.clip(value, MIN_OBSERVED, 1.0))
    else:
        value = int(np.clip(value, 1, MAX_ITERATIONS if name == "iterations" else MAX_TRIALS))
    return replace(document, recognition=replace(document.recognition, **{name: value}))


def _start(facts: Facts, document: Document) -> Document:
    """Recognise the target with the active model."""
    target = document.target
    if target is None:
        raise InputError("Upload a motion or choose an example first")
    if target.joints != facts[document.active].joints:
        raise InputError(f"{target.name} has other joints than this model")
    seed = (document.seed + document.draws) % (MAX_COUNT + 1)
    run = Run(document.active, document.recognition, seed)
    return replace(count_draw(document), run=run, use_target=True, revealed=False)


def _scrub(document: Document, iteration: int, trial: int) -> Document:
    """Show one iteration again: its mu and sigma, and the motion of the PB sampled there."""
    run = document.run
    if run is None or not run.settled or run.done == 0:
        return document
    iteration = int(np.clip(iteration, 0, run.done - 1))
    trial = int(np.clip(trial, 0, run.settings.trials - 1))
    run = replace(run, shown=iteration, trial=trial, follows=True)
    return replace(document, run=run)


def follow(facts: Facts, document: Document, trace: RecognitionTrace) -> Document:
    """The document once its run has come so far: `trace`, the iterations that are there."""
    run = document.run
    if run is None or trace.iterations < max(run.done, 1):
        return document  # a run that comes back is computed once more; until then all stays
    if not run.settled:
        ended = trace.iterations >= run.settings.iterations
        run = replace(run, done=trace.iterations, settled=ended)
        if ended:
            run = replace(run, trial=trace.best[1])
        document = replace(document, run=run)
    if not run.follows:
        return document
    old = document.models[run.model].latent
    latent = _best(old, trace.first(run.done)) if at_best(run) else _iterate(old, trace, run)
    document = put_latent(document, run.model, latent)
    return hold_pucks(facts, document) if run.settled else document


def break_off(facts: Facts, document: Document) -> Document:
    """The document whose run failed: it ends where it stands."""
    return hold_pucks(facts, end_run(document))


def at_best(run: Run) -> bool:
    """Whether the run shows the best PB of all trials, which no single iterate is."""
    return run.complete and run.shown is None


def shown_iteration(run: Run, trace: RecognitionTrace) -> int:
    """The iteration that is on the screen, from 0: by hand, or by the run itself."""
    if run.shown is not None:
        return min(run.shown, trace.iterations - 1)
    return trace.best[0] if run.complete else trace.iterations - 1


def _best(latent: Latent, trace: RecognitionTrace) -> Latent:
    """The best PB sampled in all trials, as the early update jumps to it."""
    iteration, trial = trace.best
    mu, sigma = trace.pb[iteration, trial], trace.sigma[iteration + 1, trial]
    return replace(latent, mu=vector(mu), sigma=vector(sigma), epsilon=(0.0,) * len(mu))


def _iterate(latent: Latent, trace: RecognitionTrace, run: Run) -> Latent:
    """The latent at one iteration, with the noise that made the PB sampled there."""
    at = shown_iteration(run, trace.first(run.done)), run.trial
    mu, sigma = trace.mu[at], trace.sigma[at]
    noise = trace.pb[at] - mu
    epsilon = np.divide(noise, sigma, out=np.zeros_like(mu), where=sigma > SMALLEST_SIGMA)
    return replace(latent, mu=vector(mu), sigma=vector(sigma), epsilon=vector(epsilon))
