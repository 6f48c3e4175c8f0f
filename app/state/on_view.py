"""What changes how things are shown: playback, axes, window, colours, and finished work. Pure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import intents as do
from .document import AppState, GeneratedMotion
from .slices import drawable_axes
from .transitions import Facts, Update, follow_landscape, opening_work, put_model

MIN_SPEED, MAX_SPEED = 0.1, 3.0
REST_SECONDS = 0.8  # a slider that rests this long ends its gesture; a drag ends with the button


# --- playback ---
def set_playing(facts: Facts, state: AppState, intent: do.SetPlaying) -> Update:
    playback = replace(state.playback, playing=intent.playing)
    if intent.playing and not playback.loop and playback.phase >= 1.0:
        playback = replace(playback, phase=0.0)
    return replace(state, playback=playback), ()


def toggle_playing(facts: Facts, state: AppState, intent: do.TogglePlaying) -> Update:
    return set_playing(facts, state, do.SetPlaying(not state.playback.playing))


def seek(facts: Facts, state: AppState, intent: do.Seek) -> Update:
    motion = state.current.motion
    if motion is None:
        return state, ()
    last = max(len(motion.positions) - 1, 1)
    phase = float(np.clip(intent.frame / last, 0.0, 1.0))
    return replace(state, playback=replace(state.playback, phase=phase, playing=False)), ()


def set_speed(facts: Facts, state: AppState, intent: do.SetSpeed) -> Update:
    speed = float(np.clip(intent.speed, MIN_SPEED, MAX_SPEED))
    return replace(state, playback=replace(state.playback, speed=speed)), ()


def set_loop(facts: Facts, state: AppState, intent: do.SetLoop) -> Update:
    return replace(state, playback=replace(state.playback, loop=intent.loop)), ()


def tick(facts: Facts, state: AppState, intent: do.Tick) -> Update:
    """The state itself, not its like, where time changes nothing: the session then rests."""
    if state.gesture and not state.gesture.startswith("drag"):
        rested = state.rested + intent.seconds
        gesture = state.gesture if rested <= REST_SECONDS else ""
        state = replace(state, rested=rested, gesture=gesture)
    motion, playback = state.current.motion, state.playback
    if motion is None or not playback.playing:
        return state, ()
    seconds = max(len(motion.positions) - 1, 1) / facts[state.active].fps
    phase = playback.phase + intent.seconds * playback.speed / seconds
    if phase >= 1.0:
        phase = phase % 1.0 if playback.loop else 1.0
        playback = replace(playback, playing=playback.loop)
    return replace(state, playback=replace(playback, phase=phase)), ()


# --- boards and plots ---
def set_map_axes(facts: Facts, state: AppState, intent: do.SetMapAxes) -> Update:
    if not drawable_axes(intent.axes, facts[state.active].pb_dim):
        return state, ()
    return follow_landscape(facts, replace(state, map_axes=intent.axes), state.active)


def set_landscape_axes(facts: Facts, state: AppState, intent: do.SetLandscapeAxes) -> Update:
    if intent.axes != "pca" and not drawable_axes(intent.axes, facts[state.active].pb_dim):
        return state, ()
    return follow_landscape(facts, replace(state, landscape_axes=intent.axes), state.active)


def set_window(facts: Facts, state: AppState, intent: do.SetWindow) -> Update:
    return follow_landscape(facts, replace(state, window=intent.window), state.active)


def set_colouring(facts: Facts, state: AppState, intent: do.SetColouring) -> Update:
    return replace(state, colouring=intent.colouring), ()


def set_joint(facts: Facts, state: AppState, intent: do.SetJoint) -> Update:
    return replace(state, joint=intent.joint), ()


def set_use_target(facts: Facts, state: AppState, intent: do.SetUseTarget) -> Update:
    state = replace(state, use_target=intent.use_target)
    return opening_work(facts, state)


def set_eyes(facts: Facts, state: AppState, intent: do.SetEyes) -> Update:
    return replace(state, eyes=intent.eyes), ()


# --- results ---
def motion_ready(facts: Facts, state: AppState, intent: do.MotionReady) -> Update:
    model = state.models[intent.model]
    if model.motion is not None and model.motion.request >= intent.request:
        return state, ()
    motion = GeneratedMotion(intent.request, intent.positions, intent.reference)
    return put_model(state, intent.model, replace(model, motion=motion)), ()


def landscape_ready(facts: Facts, state: AppState, intent: do.LandscapeReady) -> Update:
    model, new = state.models[intent.model], intent.landscape
    old = model.landscape
    if old is not None and (old.request, old.values.complete) > (new.request, new.values.complete):
        return state, ()
    return put_model(state, intent.model, replace(model, landscape=new)), ()
