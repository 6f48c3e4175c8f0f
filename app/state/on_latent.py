"""What moves a model through its latent space: selecting, dragging, sliders, noise. Pure."""

from __future__ import annotations

from typing import Literal, assert_never

import numpy as np
from msgspec.structs import replace
from numpy.typing import ArrayLike, NDArray

from ...core.walk import STEPS
from . import intents as do
from .document import MAX_COUNT, Document, Latent, vector
from .facts import Facts, ModelFacts
from .on_view import same_joints
from .opening import learned_latent
from .planes import (
    fitting_axes,
    inside_window,
    landscape_plane,
    moved_on_landscape,
    valid_axes,
)
from .wanted import way_ends


def update_latent(facts: Facts, document: Document, intent: do.LatentIntent) -> Document:
    document = _taken_up(facts, document, intent)
    one = facts[document.active]
    latent = document.current.latent
    match intent:
        case do.SelectModel(index):
            return select_model(facts, document, index)
        case do.SelectMotion(_, model) if model not in (None, document.active):
            return document
        case do.SelectMotion(index):
            return _select_motion(facts, document, index)
        case do.ResetLatent():
            return _select_motion(facts, document, latent.motion)
        case do.SetMu(dim, value) if _is_number(value) and 0 <= dim < one.pb_dim:
            moved = _move(document, mu=_with(latent.mu, dim, value))
            return carry(facts, document, moved, on_map=False)
        case do.SetSigma(dim, value) if _is_number(value) and 0 <= dim < one.pb_dim:
            return _move(document, sigma=_with(latent.sigma, dim, max(value, 0.0)))
        case do.MoveOnMap(model, axes, to):
            if model != document.active or not valid_axes(axes, one.pb_dim):
                return document
            if not _is_point(to, len(axes)):
                return document
            moved = _move(document, mu=one.latent_map.move(latent.mu, axes, to))
            return carry(facts, document, moved, on_map=True)
        case do.MoveOnLandscape():
            moved = _move_on_landscape(one, document, intent)
            return carry(facts, document, moved, on_map=document.landscape_axes == "pca")
        case do.RandomiseLatent():
            document, random = _draw(document)
            scale = one.latent_map.scale
            mu = one.latent_map.unproject(random.standard_normal(len(scale)) * scale)
            return _move(document, mu=mu)
        case do.NewNoise():
            document, random = _draw(document)
            return _move(document, epsilon=random.standard_normal(one.pb_dim))
        case do.ClearNoise():
            return _move(document, epsilon=np.zeros(one.pb_dim))
        case do.WalkTo(to):
            return _walk_to(facts, document, to)
        case do.SetMu() | do.SetSigma():
            return document
        case _:
            assert_never(intent)


def _taken_up(facts: Facts, document: Document, intent: do.LatentIntent) -> Document:
    """Of two models side by side, the one whose board a hand is on becomes the active one."""
    match intent:
        case do.MoveOnMap(model) | do.MoveOnLandscape(model) | do.SelectMotion(_, int(model)):
            if model in document.on_boards:
                return select_model(facts, document, model)
    return document


def _move(
    document: Document,
    *,
    mu: ArrayLike | None = None,
    sigma: ArrayLike | None = None,
    epsilon: ArrayLike | None = None,
) -> Document:
    """A person moves the active model's latent by hand; a recognition that drives it stops."""
    changes = {"mu": mu, "sigma": sigma, "epsilon": epsilon}
    latent = replace(
        document.current.latent,
        **{name: vector(values) for name, values in changes.items() if values is not None},
    )
    document = put_latent(document, document.active, latent)
    return end_run(document, by_hand=True)


def carry(facts: Facts, before: Document, after: Document, *, on_map: bool) -> Document:
    """Take the other models along with the active one, which a hand has moved.

    Models differ in D and in what their axes mean. The same amount is that along the first, second,
    .. axis: of the map, where the hand was on it, or of mu.
    """
    active = before.active
    if after.hand == "alone" or after.models[active] == before.models[active]:
        return after
    one = facts[active]
    old, new = (np.array(each.models[active].latent.mu) for each in (before, after))
    step = one.latent_map.project(new) - one.latent_map.project(old) if on_map else new - old
    share = _share_of_way(one, before.goal, before.models[active].latent.motion, new)
    for index, other in enumerate(facts):
        latent = after.models[index].latent
        if index == active:
            continue
        if after.hand == "way":
            mu = _on_way(other, after.goal, latent.motion, share)
        else:
            scale = other.mu_sd / one.mu_sd if after.hand == "sd" else 1.0
            size = min(len(step), other.pb_dim)
            own = np.zeros(other.pb_dim)
            own[:size] = scale * step[:size]
            mu = np.array(latent.mu) + (own @ other.latent_map.components if on_map else own)
        if mu is not None:
            after = put_latent(after, index, replace(latent, mu=vector(mu)))
    return after


def _share_of_way(facts: ModelFacts, goal: str, motion: int, mu: ArrayLike) -> float | None:
    """How far mu is along the straight line from a motion to the goal; None where there is none."""
    if goal not in facts.motions:
        return None
    start, end = facts.mu[motion], facts.mu[facts.motions.index(goal)]
    way = end - start
    length = float(way @ way)
    return float((np.asarray(mu) - start) @ way) / length if length else None


def _on_way(
    facts: ModelFacts, goal: str, motion: int, share: float | None
) -> NDArray[np.float64] | None:
    """The same share of another model's way; None where it does not know both ends."""
    if share is None or goal not in facts.motions:
        return None
    start, end = facts.mu[motion], facts.mu[facts.motions.index(goal)]
    mu: NDArray[np.float64] = start + share * (end - start)
    return mu


def _walk_to(facts: Facts, document: Document, to: int | Literal["morph"] | None) -> Document:
    """All models that know both ends stand there, without noise; at the start of a morph."""
    if to is None:
        return replace(document, walk=None)
    if way_ends(facts[document.active], document, document.current.latent.motion) is None:
        return document
    if to != "morph" and not 0 <= to <= STEPS:
        return document
    document = end_run(document, by_hand=True)
    for index, one in enumerate(facts):
        latent = document.models[index].latent
        mu = _on_way(one, document.goal, latent.motion, 0.0 if to == "morph" else to / STEPS)
        if mu is not None:
            latent = replace(latent, mu=vector(mu), epsilon=(0.0,) * one.pb_dim)
            document = put_latent(document, index, latent)
    return replace(document, walk=to)


def put_latent(
    document: Document, index: int, latent: Latent, anchor: tuple[float, ...] | None = None
) -> Document:
    choice = document.models[index]
    choice = replace(choice, latent=latent, anchor=choice.anchor if anchor is None else anchor)
    models = (*document.models[:index], choice, *document.models[index + 1 :])
    return replace(document, models=models)


def end_run(document: Document, *, by_hand: bool = False) -> Document:
    """Stop a recognition that is under way; a hand takes the latent from a finished one, too."""
    run = document.run
    if run is None:
        return document
    run = replace(run, settled=True, follows=run.follows and not by_hand)
    return replace(document, run=run)


def select_model(facts: Facts, document: Document, index: int) -> Document:
    """Have the boards speak of a model, along axes that it has."""
    if index == document.active or not 0 <= index < len(facts):
        return document
    dim = facts[index].pb_dim
    axes = document.landscape_axes
    pair = document.pair
    if document.compare and index not in pair:  # it takes the place of the one that was active
        pair = (index, pair[1]) if document.active == pair[0] else (pair[0], index)
    comparable = same_joints(*(facts[one] for one in pair)) if document.compare else False
    return replace(
        end_run(document),
        active=index,
        pair=pair,
        compare=comparable,
        first_slider=0,
        map_axes=fitting_axes(document.map_axes, dim),
        landscape_axes="pca" if axes == "pca" else fitting_axes(axes, dim),
    )


def _select_motion(facts: Facts, document: Document, motion: int) -> Document:
    """Side by side, models show the same motion where both have learnt it."""
    if not 0 <= motion < len(facts[document.active].motions):
        return document
    name = facts[document.active].motions[motion]
    for index, one in enumerate(facts):
        if index == document.active or name in one.motions:
            own = motion if index == document.active else one.motions.index(name)
            latent = learned_latent(one, own)
            document = put_latent(document, index, latent, anchor=latent.mu)
    return end_run(document, by_hand=True)


def _move_on_landscape(
    facts: ModelFacts, document: Document, intent: do.MoveOnLandscape
) -> Document:
    where = landscape_plane(facts, document, document.current)
    drawn = (intent.model, intent.axes) == (document.active, where.labels)
    if not drawn or not _is_point(intent.to, len(where.middle)):
        return document
    to = np.clip(intent.to, where.middle - where.radius, where.middle + where.radius)
    mu = moved_on_landscape(facts, document, document.current.latent.mu, tuple(to.tolist()))
    return _move(document, mu=mu)


def hold_pucks(facts: Facts, document: Document) -> Document:
    """Move a landscape's window to the puck that has left it."""
    for index, one in enumerate(facts):
        choice = document.models[index]
        if document.run is not None and document.running and document.run.model == index:
            continue  # a recognition passes through; the window waits for where it ends
        if not inside_window(one, document, choice):
            document = put_latent(document, index, choice.latent, anchor=choice.latent.mu)
    return document


def _draw(document: Document) -> tuple[Document, np.random.Generator]:
    """A generator made from the seed and the number of draws, so that a session replays."""
    random = np.random.default_rng([document.seed, document.draws])
    return count_draw(document), random


def count_draw(document: Document) -> Document:
    return replace(document, draws=(document.draws + 1) % (MAX_COUNT + 1))


def _with(values: tuple[float, ...], dim: int, value: float) -> tuple[float, ...]:
    return (*values[:dim], value, *values[dim + 1 :])


def _is_number(value: float) -> bool:
    return bool(np.isfinite(value))


def _is_point(values: tuple[float, ...], axes: int) -> bool:
    return len(values) == axes and bool(np.isfinite(values).all())
