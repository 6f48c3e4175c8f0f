"""What a recognition does to the state: its target, its settings, its steps, its end. Pure."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from . import intents as do
from .document import AppState, Array, Latent, Recognition, RecognitionTrace
from .transitions import (
    Facts,
    Update,
    follow_landscape,
    notify,
    opening_work,
    put_model,
    remember,
    show_latent,
    stop_recognition,
    want_motion,
)

MIN_OBSERVED, MAX_OBSERVED = 0.1, 1.0
MAX_ITERATIONS = 1000
MAX_TRIALS = 20
SMALLEST_SIGMA = 1e-6  # below it, the noise that made a PB cannot be told from rounding


def set_target(facts: Facts, state: AppState, intent: do.SetTarget) -> Update:
    """A motion to recognise; what was found for the last one stays in reach of undo."""
    state, works = stop_recognition(state)
    state = remember(state, "")
    recognition = replace(
        state.recognition,
        target=intent.motion,
        eyes=intent.eyes,
        status="idle",
        trace=None,
        shown=None,
        trial=0,
        message="",
    )
    state = notify(
        replace(state, recognition=recognition, use_target=True),
        f"{intent.motion.name}: {len(intent.motion)} frames, ready to recognise{intent.remark}",
        good=True,
    )
    state, more = opening_work(facts, state)
    return state, works + more


def refuse_target(facts: Facts, state: AppState, intent: do.RefuseTarget) -> Update:
    """The notice says why; the line on the last run is of that run."""
    return notify(state, intent.reason), ()


def clear_target(facts: Facts, state: AppState, intent: do.ClearTarget) -> Update:
    state, works = stop_recognition(state)
    state = remember(state, "")
    state = replace(state, recognition=Recognition().with_settings_of(state.recognition))
    state, more = opening_work(facts, state)
    return state, works + more


def set_option(facts: Facts, state: AppState, intent: do.SetRecognitionOption) -> Update:
    """Settings hold from the next start on."""
    value: Any = intent.value
    if intent.name == "observed":
        value = float(np.clip(value, MIN_OBSERVED, MAX_OBSERVED))
    elif intent.name == "iterations":
        value = int(np.clip(value, 1, MAX_ITERATIONS))
    elif intent.name == "trials":
        value = int(np.clip(value, 1, MAX_TRIALS))
    elif value not in ("learned", "baseline", "random"):
        return state, ()
    return replace(state, recognition=replace(state.recognition, **{intent.name: value})), ()


def start(facts: Facts, state: AppState, intent: do.StartRecognition) -> Update:
    """Recognise the target with the active model."""
    recognition = state.recognition
    target = recognition.target
    if target is None:
        return notify(state, "Upload a motion or choose an example first"), ()
    if target.joints != facts[state.active].joints:
        return notify(state, f"{target.name} has other joints than this model"), ()
    state, works = stop_recognition(state)
    state = remember(state, "")
    request = state.requests + 1
    recognition = replace(
        state.recognition,
        status="running",
        request=request,
        model=state.active,
        planned=state.recognition.iterations,
        trace=None,
        shown=None,
        trial=0,
        message="",
    )
    state = replace(
        state,
        recognition=recognition,
        requests=request,
        draws=state.draws + 1,
        use_target=True,
    )
    work = do.RecogniseWork(
        model=state.active,
        request=request,
        target=target.positions,
        observed=recognition.observed,
        init=recognition.init,
        iterations=recognition.iterations,
        trials=recognition.trials,
        seed=state.seed + state.draws - 1,
    )
    state, more = follow_landscape(facts, state, state.active)  # the target may not have been used
    return state, (*works, work, *more)


def cancel(facts: Facts, state: AppState, intent: do.CancelRecognition) -> Update:
    """Stop where it is; the path so far stays, and the landscape catches up."""
    state, works = stop_recognition(state)
    if not works:
        return state, ()
    state, more = follow_landscape(facts, state, state.recognition.model)
    return state, works + more


def stepped(facts: Facts, state: AppState, intent: do.RecognitionStepped) -> Update:
    """Follow the newest iterate. The landscape waits until the end."""
    recognition = state.recognition
    if recognition.request != intent.request or recognition.status != "running":
        return state, ()
    recognition = replace(recognition, trace=intent.trace)
    state = replace(state, recognition=recognition)
    model = state.models[recognition.model]
    latent = iterate(model.latent, intent.trace, intent.trace.iterations - 1, recognition.trial)
    state = put_model(state, recognition.model, replace(model, latent=latent))
    return want_motion(facts, state, recognition.model)


def finished(facts: Facts, state: AppState, intent: do.RecognitionFinished) -> Update:
    """Go to the best PB sampled in all trials, as the early update does, and draw its landscape."""
    recognition = state.recognition
    if recognition.request != intent.request or recognition.status != "running":
        return state, ()
    trace = recognition.trace
    if trace is None:
        return replace(state, recognition=replace(recognition, status="finished")), ()
    iteration, trial = trace.best
    recognition = replace(
        recognition,
        status="finished",
        trial=trial,
        message=_best_line(trace),
    )
    state = replace(state, recognition=recognition)
    latent = replace(
        state.models[recognition.model].latent,
        mu=trace.pb[iteration, trial],
        sigma=trace.sigma[iteration + 1, trial],
        epsilon=np.zeros_like(trace.pb[iteration, trial]),
    )
    return show_latent(facts, state, recognition.model, latent)


def _best_line(trace: RecognitionTrace) -> str:
    iteration, trial = trace.best
    predicted = trace.prediction_error[iteration, trial]
    parts = [
        f"best iterate: {iteration + 1} of trial {trial + 1}",
        f"loss {trace.loss[iteration, trial]:.5f}",
        f"prediction error {predicted:.5f}"
        if np.isfinite(predicted)
        else "nothing left to predict",
    ]
    return ", ".join(parts)


def scrub(facts: Facts, state: AppState, intent: do.ScrubRecognition) -> Update:
    """Show one iteration again: its mu and sigma, and the motion of the PB sampled there."""
    recognition = state.recognition
    trace = recognition.trace
    if trace is None or recognition.status == "running":
        return state, ()
    iteration = int(np.clip(intent.iteration, 0, trace.iterations - 1))
    trial = int(np.clip(intent.trial, 0, trace.loss.shape[1] - 1))
    state = remember(state, "scrub")
    state = replace(state, recognition=replace(recognition, shown=iteration, trial=trial))
    return _show_iterate(facts, state, iteration, trial)


def _show_iterate(facts: Facts, state: AppState, iteration: int, trial: int) -> Update:
    recognition = state.recognition
    assert recognition.trace is not None
    index = recognition.model
    latent = iterate(state.models[index].latent, recognition.trace, iteration, trial)
    return show_latent(facts, state, index, latent)


def iterate(latent: Latent, trace: RecognitionTrace, iteration: int, trial: int) -> Latent:
    """The latent at one iteration, with the noise that made the PB sampled there."""
    mu: Array = trace.mu[iteration, trial]
    sigma: Array = trace.sigma[iteration, trial]
    noise = trace.pb[iteration, trial] - mu
    epsilon = np.divide(noise, sigma, out=np.zeros_like(mu), where=sigma > SMALLEST_SIGMA)
    return replace(latent, mu=mu, sigma=sigma, epsilon=epsilon)


def failed(facts: Facts, state: AppState, intent: do.WorkFailed) -> Update:
    """Work broke off. A recognition that is still wanted ends; the message is shown in any case."""
    recognition = state.recognition
    if intent.work == "recognition":
        if recognition.request != intent.request or recognition.status != "running":
            return state, ()
        recognition = replace(recognition, status="failed", message=intent.message)
        state = notify(replace(state, recognition=recognition), intent.message)
        return follow_landscape(facts, state, recognition.model)
    return notify(state, intent.message), ()
