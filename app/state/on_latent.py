"""What moves a model through its latent space: selecting, dragging, sliders, noise, undo. Pure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import intents as do
from .document import AppState, Array, Moment, initial_latent
from .slices import fitting_axes, landscape_slice, moved_on_landscape, valid_axes
from .transitions import (
    Facts,
    Update,
    follow_landscape,
    moment,
    notify,
    put_model,
    remember,
    show_latent,
    stop_recognition,
    want_motion,
)

MAX_MU = 20.0  # far beyond every learned mu; nothing sensible is generated out there
MAX_SIGMA = 5.0


def _move(
    facts: Facts,
    state: AppState,
    gesture: str,
    *,
    mu: Array | None = None,
    sigma: Array | None = None,
    epsilon: Array | None = None,
) -> Update:
    """A person moves the active model's latent by hand; a recognition that drives it stops."""
    state, works = stop_recognition(state)
    state = remember(state, gesture)
    old = state.current.latent
    latent = replace(
        old,
        mu=np.clip(old.mu if mu is None else mu, -MAX_MU, MAX_MU),
        sigma=old.sigma if sigma is None else sigma,
        epsilon=old.epsilon if epsilon is None else epsilon,
    )
    state, more = show_latent(facts, state, state.active, latent)
    return state, works + more


def select_model(facts: Facts, state: AppState, intent: do.SelectModel) -> Update:
    if not 0 <= intent.index < len(facts) or intent.index == state.active:
        return state, ()
    state, works = stop_recognition(state)
    state = _activate(facts, remember(state, ""), intent.index)
    if state.side_by_side:
        state, more = want_motion(facts, state, intent.index)
        works += more
    state, more = follow_landscape(facts, state, intent.index)
    return state, works + more


def _activate(facts: Facts, state: AppState, index: int) -> AppState:
    """Have the boards speak of a model, along axes that it has."""
    dim = facts[index].pb_dim
    axes = state.landscape_axes
    return replace(
        state,
        active=index,
        map_axes=fitting_axes(state.map_axes, dim),
        landscape_axes="pca" if axes == "pca" else fitting_axes(axes, dim),
    )


def select_motion(facts: Facts, state: AppState, intent: do.SelectMotion) -> Update:
    if not 0 <= intent.index < len(facts[state.active].motions):
        return state, ()
    state, works = stop_recognition(state)
    state = remember(state, "")
    # Side by side, models show the same motion where both have learnt it.
    name = facts[state.active].motions[intent.index]
    for index, model_facts in enumerate(facts):
        if index == state.active or name in model_facts.motions:
            motion = intent.index if index == state.active else model_facts.motions.index(name)
            latent = initial_latent(model_facts, motion)
            model = replace(state.models[index], latent=latent, anchor=latent.mu)
            state, more = show_latent(facts, put_model(state, index, model), index, latent)
            works += more
    return state, works


def set_mu(facts: Facts, state: AppState, intent: do.SetMu) -> Update:
    mu = state.current.latent.mu.copy()
    if not 0 <= intent.dim < len(mu) or not np.isfinite(intent.value):
        return state, ()
    mu[intent.dim] = intent.value
    return _move(facts, state, f"mu {intent.dim}", mu=mu)


def set_sigma(facts: Facts, state: AppState, intent: do.SetSigma) -> Update:
    latent = state.current.latent
    if not 0 <= intent.dim < len(latent.sigma) or not np.isfinite(intent.value):
        return state, ()
    sigma = latent.sigma.copy()
    sigma[intent.dim] = np.clip(intent.value, 0.0, MAX_SIGMA)
    return _move(facts, state, f"sigma {intent.dim}", sigma=sigma)


def _is_point(values: tuple[float, ...], axes: int) -> bool:
    return len(values) == axes and bool(np.isfinite(values).all())


def move_on_map(facts: Facts, state: AppState, intent: do.MoveOnMap) -> Update:
    latent_map, dim = facts[state.active].latent_map, facts[state.active].pb_dim
    if not valid_axes(intent.axes, dim) or not _is_point(intent.to, len(intent.axes)):
        return state, ()
    mu = latent_map.move(state.current.latent.mu, intent.axes, intent.to)
    return _move(facts, state, f"drag {intent.gesture}", mu=mu)


def move_on_landscape(facts: Facts, state: AppState, intent: do.MoveOnLandscape) -> Update:
    where = landscape_slice(facts[state.active], state, state.current)
    if not _is_point(intent.to, len(where.middle)):
        return state, ()
    low, high = where.middle - where.radius, where.middle + where.radius
    to = tuple(np.clip(intent.to, low, high).tolist())
    mu = moved_on_landscape(facts[state.active], state, state.current.latent, to)
    return _move(facts, state, f"drag {intent.gesture}", mu=mu)


def reset(facts: Facts, state: AppState, intent: do.ResetLatent) -> Update:
    return select_motion(facts, state, do.SelectMotion(state.current.latent.motion))


def _draw(state: AppState) -> tuple[AppState, np.random.Generator]:
    """A generator made from the seed and the number of draws, so that a session replays."""
    return replace(state, draws=state.draws + 1), np.random.default_rng([state.seed, state.draws])


def randomise(facts: Facts, state: AppState, intent: do.RandomiseLatent) -> Update:
    state, random = _draw(state)
    latent_map = facts[state.active].latent_map
    coordinates = random.standard_normal(len(latent_map.scale)) * latent_map.scale
    return _move(facts, state, "", mu=latent_map.unproject(coordinates))


def new_noise(facts: Facts, state: AppState, intent: do.NewNoise) -> Update:
    state, random = _draw(state)
    epsilon = random.standard_normal(len(state.current.latent.mu))
    return _move(facts, state, "", epsilon=epsilon)


def clear_noise(facts: Facts, state: AppState, intent: do.ClearNoise) -> Update:
    return _move(facts, state, "", epsilon=np.zeros_like(state.current.latent.mu))


def _go_to(facts: Facts, state: AppState, to: Moment) -> Update:
    # Settings were not part of the gesture that is taken back: the next run keeps them.
    recognition = to.recognition.with_settings_of(state.recognition)
    state = replace(state, recognition=recognition, gesture="")
    if to.screen is not None:
        state = _shown_as(state, to.screen)
    state = _activate(facts, state, to.active)
    works: tuple[do.Work, ...] = ()
    for index, latent in enumerate(to.latents):
        state, more = show_latent(facts, state, index, latent)
        works += more
    return state, works


def _shown_as(state: AppState, screen: AppState) -> AppState:
    """All that a state code holds besides the latents, as it was on another screen."""
    models = tuple(
        replace(model, anchor=was.anchor)
        for model, was in zip(state.models, screen.models, strict=True)
    )
    return replace(
        state,
        models=models,
        playback=screen.playback,
        map_axes=screen.map_axes,
        landscape_axes=screen.landscape_axes,
        window=screen.window,
        colouring=screen.colouring,
        joint=screen.joint,
        side_by_side=screen.side_by_side,
        eyes=screen.eyes,
        export=screen.export,
        use_target=screen.use_target,
        seed=screen.seed,
        draws=screen.draws,
    )


def _mirror(state: AppState, to: Moment) -> Moment:
    """The present, as much of it as the way to the other moment changes."""
    return moment(state, whole=to.screen is not None)


def undo(facts: Facts, state: AppState, intent: do.Undo) -> Update:
    if not state.undo:
        return notify(state, "Nothing to undo", good=True), ()
    state, works = stop_recognition(state)
    to = state.undo[-1]
    state = replace(state, redo=(*state.redo, _mirror(state, to)), undo=state.undo[:-1])
    state, more = _go_to(facts, state, to)
    return state, works + more


def redo(facts: Facts, state: AppState, intent: do.Redo) -> Update:
    if not state.redo:
        return notify(state, "Nothing to redo", good=True), ()
    state, works = stop_recognition(state)
    to = state.redo[-1]
    state = replace(state, undo=(*state.undo, _mirror(state, to)), redo=state.redo[:-1])
    state, more = _go_to(facts, state, to)
    return state, works + more
