"""Steps from one state to the next that several intents share, and the work they want. Pure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...core.motion import Motion
from . import intents as do
from .document import AppState, Array, EyeTrack, Latent, ModelFacts, ModelState, Moment, Notice
from .slices import inside_window, landscape_slice

Facts = tuple[ModelFacts, ...]
Update = tuple[AppState, tuple[do.Work, ...]]

MAX_UNDO = 100


def opening_work(facts: Facts, state: AppState) -> Update:
    """Ask for every model's motion and landscape."""
    works: tuple[do.Work, ...] = ()
    for index in range(len(state.models)):
        state, motion = want_motion(facts, state, index)
        state, landscape = want_landscape(facts, state, index)
        works += motion + landscape
    return state, works


def given_target(facts: Facts, state: AppState, index: int) -> Motion | None:
    """The motion that a person gave, where a model is compared with it."""
    target = state.recognition.target
    used = target is not None and state.use_target and target.joints == facts[index].joints
    return target if used else None


def target_of(facts: Facts, state: AppState, index: int) -> NDArray[np.float32] | None:
    """(T, J) what a model's motion is compared with; None = its own reconstruction."""
    target = given_target(facts, state, index)
    data = facts[index].data[state.models[index].latent.motion] if target is None else target
    return None if data is None else data.positions


def eyes_of(facts: Facts, state: AppState, index: int) -> EyeTrack | None:
    """The eye colours that came with what a model's motion is compared with."""
    if given_target(facts, state, index) is not None:
        return state.recognition.eyes
    tracks = facts[index].eyes
    return tracks[state.models[index].latent.motion] if tracks else None


def want_motion(facts: Facts, state: AppState, index: int) -> Update:
    model = state.models[index]
    target = target_of(facts, state, index)
    steps = facts[index].lengths[model.latent.motion] if target is None else len(target)
    request = state.requests + 1
    state = replace(
        put_model(state, index, replace(model, motion_request=request)), requests=request
    )
    return state, (
        do.GenerateWork(
            index,
            request,
            model.latent.pb,
            steps,
            model.latent.motion,
            target,
            limited=state.side_by_side and index == state.active,
        ),
    )


def want_landscape(facts: Facts, state: AppState, index: int) -> Update:
    """Ask for a model's landscape, in a window that holds the puck."""
    state = hold_puck(facts, state, index)
    model = state.models[index]
    request = state.requests + 1
    work = _landscape_work(facts, state, index, request)
    model = replace(model, landscape_request=request, landscape_asked=work)
    return replace(put_model(state, index, model), requests=request), (work,)


def follow_landscape(facts: Facts, state: AppState, index: int) -> Update:
    """Ask for a model's landscape where it has become another than the last one asked for."""
    state = hold_puck(facts, state, index)
    asked = state.models[index].landscape_asked
    if asked is not None and _same(asked, _landscape_work(facts, state, index, asked.request)):
        return state, ()
    return want_landscape(facts, state, index)


def hold_puck(facts: Facts, state: AppState, index: int) -> AppState:
    """Move the landscape's window to the puck that has left it."""
    model = state.models[index]
    if inside_window(facts[index], state, model):
        return state
    return put_model(state, index, replace(model, anchor=model.latent.mu))


def _landscape_work(facts: Facts, state: AppState, index: int, request: int) -> do.LandscapeWork:
    model = state.models[index]
    where = landscape_slice(facts[index], state, model)
    return do.LandscapeWork(
        model=index,
        request=request,
        center=where.center,
        directions=where.directions,
        zero=where.zero,
        radius=where.radius,
        target=target_of(facts, state, index),
        motion=model.latent.motion,
    )


def _same(one: do.LandscapeWork, other: do.LandscapeWork) -> bool:
    """Whether two requests have one result. A move within the plane changes rounding alone."""
    return (
        one.target is other.target
        and (one.motion == other.motion or one.target is not None)
        and one.radius == other.radius
        and one.directions.shape == other.directions.shape
        and np.allclose(one.directions, other.directions, atol=1e-9)
        and np.allclose(one.center, other.center, atol=1e-9)
    )


def put_model(state: AppState, index: int, model: ModelState) -> AppState:
    models = (*state.models[:index], model, *state.models[index + 1 :])
    return replace(state, models=models)


def notify(state: AppState, text: str, *, good: bool = False) -> AppState:
    number = 1 if state.notice is None else state.notice.number + 1
    return replace(state, notice=Notice(number, text, good))


def remember(state: AppState, gesture: str, *, whole: bool = False) -> AppState:
    """Keep the present for undo, unless the same gesture (one drag, one slider) goes on.

    Args:
        whole: keep all that a state code replaces, not the latents and the recognition alone.
    """
    if gesture and gesture == state.gesture:
        return replace(state, rested=0.0)
    undo = (*state.undo, moment(state, whole=whole))[-MAX_UNDO:]
    return replace(state, undo=undo, redo=(), gesture=gesture, rested=0.0)


def moment(state: AppState, *, whole: bool = False) -> Moment:
    latents = tuple(model.latent for model in state.models)
    screen = replace(state, undo=(), redo=()) if whole else None
    return Moment(state.active, latents, state.recognition, screen)


def show_latent(
    facts: Facts, state: AppState, index: int, latent: Latent, anchor: Array | None = None
) -> Update:
    """Put a model at a point; ask for its motion, and for its landscape where that changed.

    The landscape depends on the components across its plane and on its anchor: a move within the
    plane leaves it as it is.
    """
    state = put_model(state, index, replace(state.models[index], latent=latent))
    state, works = want_motion(facts, state, index)
    state, more = follow_landscape(facts, state, index)
    return state, works + more


def stop_recognition(state: AppState) -> Update:
    if state.recognition.status != "running":
        return state, ()
    recognition = replace(state.recognition, status="cancelled")
    return replace(state, recognition=recognition), (do.CancelRecogniseWork(),)
