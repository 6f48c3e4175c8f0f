"""What changes how things are shown: playback, axes, window, colours, the robot. Pure."""

from __future__ import annotations

from typing import assert_never, get_args

import numpy as np
from msgspec.structs import replace

from ...core.belief import LEAST_SCALE, MOST_SCALE
from ...core.errors import InputError
from ...robot.formats import FORMATS
from . import intents as do
from .document import MAX_SPEED, MIN_SPEED, Document, Hand
from .facts import Facts, ModelFacts
from .planes import drawable_axes
from .wanted import motion_steps


def update_playback(facts: Facts, document: Document, intent: do.PlaybackIntent) -> Document:
    playback = document.playback
    last = max(motion_steps(facts, document, document.active) - 1, 1)
    match intent:
        case do.SetPlaying(playing, frame):
            phase = playback.phase if frame is None else _phase(frame, last, playback.phase)
            if playing and not playback.loop and phase >= 1.0:
                phase = 0.0
            playback = replace(playback, playing=playing, phase=phase)
        case do.TogglePlaying():
            return update_playback(facts, document, do.SetPlaying(not playback.playing))
        case do.Seek(frame):
            playback = replace(playback, playing=False, phase=_phase(frame, last, playback.phase))
        case do.SetSpeed(speed) if not np.isfinite(speed):
            return document
        case do.SetSpeed(speed):
            playback = replace(playback, speed=float(np.clip(speed, MIN_SPEED, MAX_SPEED)))
        case do.SetLoop(loop):
            playback = replace(playback, loop=loop)
        case _:
            assert_never(intent)
    return replace(document, playback=playback)


def update_view(facts: Facts, document: Document, intent: do.ViewIntent) -> Document:
    one = facts[document.active]
    dim = one.pb_dim
    match intent:
        case do.SetMapAxes(axes):
            return replace(document, map_axes=axes) if drawable_axes(axes, dim) else document
        case do.SetLandscapeAxes(axes):
            fit = axes == "pca" or drawable_axes(axes, dim)
            return replace(document, landscape_axes=axes) if fit else document
        case do.SetWindow(window):
            return replace(document, window=window)
        case do.SetColouring(colouring):
            return replace(document, colouring=colouring)
        case do.SetJoint(joint):
            known = joint in ("", *one.joints)
            return replace(document, joint=joint) if known else document
        case do.ShowSliders(first):
            return replace(document, first_slider=first) if 0 <= first < dim else document
        case do.SetUseTarget(use_target):
            return replace(document, use_target=use_target)
        case do.SetShowTarget(show_target):
            return replace(_facing(document), show_target=show_target)
        case do.SetRevealed(revealed):
            return replace(document, revealed=revealed)
        case do.SetCompare(wanted):
            return compare(facts, document, wanted)
        case do.SetHand(hand):
            return replace(document, hand=hand) if hand in get_args(Hand) else document
        case do.SetGoal(goal):
            known = goal in ("", *one.motions)
            return replace(document, goal=goal, walk=None) if known else document
        case do.SetCloud(cloud):
            return replace(document, cloud=cloud)
        case do.SetExplanations(explanations):
            return replace(document, explanations=explanations)
        case do.SetErrorScale(scale):
            if not np.isfinite(scale):
                return document
            return replace(document, error_scale=float(np.clip(scale, LEAST_SCALE, MOST_SCALE)))
        case do.SetGhosts(ghosts):
            return replace(document, ghosts=ghosts)
        case do.SetEyes(eyes):
            return replace(document, eyes=eyes)
        case do.SetSideBySide(side_by_side):
            return replace(_facing(document), side_by_side=side_by_side)
        case do.Look(seen):
            return replace(document, seen=seen)
        case do.ResetView():
            return _facing(document)
        case do.SetExportOption(name, value):
            if name == "file_format" and value not in FORMATS:
                return document
            value = value if name == "file_format" else bool(value)
            return replace(document, export=replace(document.export, **{name: value}))
        case _:
            assert_never(intent)


def compare(facts: Facts, document: Document, wanted: bool) -> Document:
    """Two models' boards, and one hand for both, unless a person has chosen how it moves them.

    Raises:
        InputError: they move other joints.
    """
    if len(document.models) < 2:
        return document
    active, pair = document.active, document.pair
    if active not in pair:
        pair = (pair[0], active)
    one, other = (facts[index] for index in pair)
    if wanted and not same_joints(one, other):
        apart = len(set(one.joints) ^ set(other.joints))
        raise InputError(
            f"{one.name} and {other.name} cannot be compared: they move other joints, "
            f"{apart} of them are moved by one of the two alone"
        )
    hand = "absolute" if wanted and document.hand == "alone" else document.hand
    return replace(document, compare=wanted, pair=pair, hand=hand)


def same_joints(one: ModelFacts, other: ModelFacts) -> bool:
    """Whether motions of two models can be told apart by how, not by what they move."""
    return set(one.joints) == set(other.joints)


def _facing(document: Document) -> Document:
    """Seen from the front, all robots in view."""
    return replace(document, seen=replace(document.seen, camera=None))


def _phase(frame: float, last: int, otherwise: float) -> float:
    return float(np.clip(frame / last, 0.0, 1.0)) if np.isfinite(frame) else otherwise
