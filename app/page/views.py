"""What the browser's part shows of a picture, as the messages of `shown.py`. Pure functions."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.walk import morph_shares
from ..state.document import Document
from ..state.facts import Array, ModelFacts
from ..state.on_recognition import shown_iteration
from ..state.picture import Picture
from ..state.planes import landscape_plane, on_landscape
from ..state.wanted import joint_indices, motion_steps
from .shown import (
    CloudShown,
    CurvesShown,
    LandscapeShown,
    MapShown,
    PathShown,
    PlaybackShown,
    PuckShown,
    WaysShown,
)
from .words import target_label, window_label

DEVIATIONS = 2.0  # half of a band's width
MAP_PADDING = 0.12  # of the learned points' extent, on every side of the map


def map_shown(picture: Picture, slot: int = 0) -> MapShown:
    """The active model's PB map."""
    facts, document = picture.model, picture.document
    axes, hidden = document.map_axes, hidden_axes(picture)
    points = _flat(facts.latent_map.points[:, list(axes)])
    labels = [facts.labels.get(name) for name in facts.motions]
    return MapShown(
        model=picture.active,
        title=facts.name,
        axes=axes,
        hidden_axes=hidden,
        axis_labels=axis_labels(facts, (*axes, *hidden)),
        points=points,
        names=facts.motions,
        colouring=document.colouring,
        classes=tuple(one.behavior_class if one else "" for one in labels),
        values=None
        if document.colouring == "class"
        else np.array([_rating(getattr(one, document.colouring, None)) for one in labels]),
        selected=picture.choice.latent.motion,
        extent=_extent(points),
        pairs=len(picture.document.on_boards),
        **_added(picture),
        slot=slot,
    )


def _added(picture: Picture) -> dict[str, Any]:
    """The points that a person put on the active model's map."""
    axes = list(picture.document.map_axes)
    own = [
        (index, added)
        for index, added in enumerate(picture.document.added)
        if added.model == picture.active
    ]
    mu = np.array([added.mu for _, added in own]).reshape(len(own), picture.model.pb_dim)
    return {
        "added": _flat(picture.model.latent_map.project(mu)[:, axes]),
        "added_names": tuple(added.name for _, added in own),
        "added_index": np.array([index for index, _ in own], dtype=np.int32),
    }


def hidden_axes(picture: Picture) -> tuple[int, ...]:
    """The two components of the map that come after those that are drawn."""
    drawn = picture.document.map_axes
    return tuple(axis for axis in range(picture.model.pb_dim) if axis not in drawn)[:2]


def axis_labels(facts: ModelFacts, axes: tuple[int, ...]) -> tuple[str, ...]:
    """Each component with its share of the learned mu's variance."""
    variance = facts.latent_map.points.var(axis=0)
    shares = variance / max(float(variance.sum()), 1e-12)
    return tuple(f"PC{axis + 1} ({shares[axis]:.0%})" for axis in axes)


def puck_shown(picture: Picture, heard: int | None, slot: int = 0) -> PuckShown:
    """Where the active model stands.

    Args:
        heard: number of the last move of the page that is in it.
    """
    facts, latent, document = picture.model, picture.choice.latent, picture.document
    latent_map, axes = facts.latent_map, document.map_axes
    at = latent_map.project(latent.mu)
    covariance = np.zeros((2, 2))
    belief = picture.posterior
    if belief is None:
        drawn = latent_map.ellipse(latent.sigma, axes)
    else:  # the full ellipse: what the observation leaves open is seldom along one component
        components = latent_map.components[list(axes)]
        drawn = components @ belief.covariance @ components.T
    covariance[: len(axes), : len(axes)] = drawn
    return PuckShown(
        on_map=_flat(at[list(axes)]),
        on_landscape=_flat(on_landscape(facts, document, latent.mu)),
        hidden=at[list(hidden_axes(picture))],
        covariance=covariance if facts.stochastic or belief is not None else None,
        off_plane=latent_map.off_plane(latent.mu, axes) if facts.pb_dim > 2 else None,
        extrapolation=latent_map.extrapolation(latent.mu),
        heard=heard,
        slot=slot,
    )


def landscape_shown(picture: Picture, slot: int = 0) -> LandscapeShown | None:
    """The active model's newest landscape; None until there is one."""
    if picture.landscape is None:
        return None
    work, values = picture.landscape
    facts, document = picture.model, picture.document
    where = landscape_plane(facts, document, picture.choice)
    learned = _flat(on_landscape(facts, document, facts.mu))
    inside = np.flatnonzero(
        ((learned >= [values.x[0], values.y[0]]) & (learned <= [values.x[-1], values.y[-1]])).all(1)
        if len(values.y) > 1
        else (learned[:, 0] >= values.x[0]) & (learned[:, 0] <= values.x[-1])
    )
    same_plane = work.labels == where.labels
    return LandscapeShown(
        model=picture.active,
        correlation=values.correlation,
        x=values.x,
        y=values.y,
        extent=_cells_extent(values.x, values.y),
        complete=picture.landscape_complete,
        axis_labels=work.labels,
        window=window_label(picture),
        target=target_label(picture),
        mean=values.mean,
        area=values.area,
        roughness=values.roughness,
        learned=learned[inside] if same_plane else None,
        learned_index=inside if same_plane else None,
        slot=slot,
    )


def path_shown(picture: Picture, slot: int = 0) -> PathShown:
    """The drawn trial of the active model's recognition; an empty path where there is none."""
    if picture.drawn_run is None:
        return PathShown(None, None, np.zeros(0), slot=slot)
    run, trace = picture.drawn_run
    facts, document = picture.model, picture.document
    axes = list(document.map_axes)
    trial = min(run.trial, trace.loss.shape[1] - 1)
    mu, pb = trace.mu[:, trial], trace.pb[:, trial]
    others = np.delete(trace.mu, trial, axis=1).swapaxes(0, 1)  # (K - 1, S, D)
    return PathShown(
        on_map=_flat(facts.latent_map.project(mu)[:, axes]),
        on_landscape=_flat(on_landscape(facts, document, mu)),
        radii=trace.sigma[:, trial].mean(axis=1),
        samples_on_map=_flat(facts.latent_map.project(pb)[:, axes]),
        samples_on_landscape=_flat(on_landscape(facts, document, pb)),
        shown=shown_iteration(run, trace) if trace.iterations else 0,
        early=trace.early_update[:, trial] if run.settings.method == "paper" else None,
        others_on_map=_flat(facts.latent_map.project(others)[..., axes]) if len(others) else None,
        slot=slot,
    )


def ways_shown(picture: Picture, slot: int = 0) -> WaysShown:
    """The ways from the active model's selected motion to the goal."""
    facts, document = picture.model, picture.document
    ways = picture.ways(picture.active)
    if ways is None:
        return WaysShown(facts.name, slot=slot)
    axes, walk = list(document.map_axes), document.walk
    frames = motion_steps(picture.facts, document, picture.active)
    return WaysShown(
        title=facts.name,
        straight=_flat(facts.latent_map.project(ways.straight.pbs)[:, axes]),
        shortest=_flat(facts.latent_map.project(ways.shortest.pbs)[:, axes]),
        changes=np.rad2deg(ways.straight.steps),
        shortest_changes=np.rad2deg(ways.shortest.steps),
        steepest=ways.straight.steepest,
        at=walk if isinstance(walk, int) else None,
        shares=morph_shares(frames) if walk == "morph" else None,
        slot=slot,
    )


def cloud_shown(picture: Picture, slot: int = 0) -> CloudShown:
    """The belief over the active model's codebook; nothing where there is none."""
    facts, axes = picture.model, list(picture.document.map_axes)
    if picture.belief is None:
        none = np.zeros((0, 2))
        return CloudShown(
            none[:, 0], none, none[:, :0], none[:, 0], none, none[:, 0], (), 0, slot=slot
        )
    cloud = picture.belief.cloud
    modes = np.array([mode.pb for mode in cloud.modes], dtype=np.float64)
    largest = np.maximum(cloud.weights.max(axis=1, keepdims=True), 1e-30)
    gaps = np.linalg.norm(facts.mu[None] - modes[:, None], axis=2)
    return CloudShown(
        frames=cloud.frames,
        places=_flat(facts.latent_map.project(cloud.pbs)[:, axes]),
        weights=(np.sqrt(cloud.weights / largest) * 255).round().astype(np.uint8),
        entropy=cloud.entropy,
        modes=_flat(facts.latent_map.project(modes)[:, axes]),
        mass=np.array([mode.mass for mode in cloud.modes]),
        near=tuple(facts.motions[index] for index in gaps.argmin(axis=1)),
        entries=cloud.entries,
        slot=slot,
    )


def curves_shown(picture: Picture) -> CurvesShown:
    """What the time bar draws beside the motions of the models on the boards."""
    facts, document = picture.model, picture.document
    there = [picture.facts[index] for index in document.on_boards]
    columns = [[one.joints.index(joint) for joint in facts.joints] for one in there]
    reference, seen = picture.reference(), picture.seen_target
    if reference is not None and seen is not None:
        reference = np.pad(
            seen, [(0, len(reference) - len(seen)), (0, 0)], constant_values=np.float32(np.nan)
        )
    joints = joint_indices(facts, document.recognition.joints)
    unseen = np.ones(len(facts.joints), dtype=bool)
    unseen[list(joints)] = False
    motion, belief = picture.motion(), picture.posterior
    band = None
    if belief is not None and motion is not None and len(belief.deviation) == len(motion):
        band = DEVIATIONS * belief.deviation
    return CurvesShown(
        names=facts.joints,
        low=None if band is None or motion is None else motion - band,
        high=None if band is None or motion is None else motion + band,
        unseen=unseen if joints and seen is not None else None,
        joint=facts.joints.index(document.joint) if document.joint in facts.joints else None,
        reference=reference,
        observed=None if seen is None else document.recognition.observed,
        models=tuple(_curve_name(one, document) for one in there),
        columns=np.array(columns, dtype=np.int32),
        active=document.on_boards.index(picture.active),
    )


def _curve_name(facts: ModelFacts, document: Document) -> str:
    """A model without sigma has no band, and says so where one is looked for."""
    return (
        facts.name if facts.stochastic or not document.ghosts else f"{facts.name} (σ = 0, no band)"
    )


def playback_shown(picture: Picture, number: int) -> PlaybackShown:
    playback = picture.document.playback
    last = max(motion_steps(picture.facts, picture.document, picture.active) - 1, 0)
    return PlaybackShown(
        number, playback.playing, playback.phase * last, playback.speed, playback.loop
    )


def _flat(points: Array) -> Array:
    """(..., 2) of (..., 1 or 2) coordinates: 0 where one component is drawn."""
    missing = 2 - points.shape[-1]
    return np.pad(points, [(0, 0)] * (points.ndim - 1) + [(0, missing)])


def _extent(points: Array) -> Array:
    """(4,) left, right, bottom, top around points (N, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    wide = np.maximum(high - low, 1e-3 * max(float((high - low).max()), 1e-6))
    low, high = low - MAP_PADDING * wide, high + MAP_PADDING * wide
    return np.array([low[0], high[0], low[1], high[1]])


def _cells_extent(x: Array, y: Array) -> Array:
    """(4,) left, right, bottom, top of cells with these centres."""
    half = (x[-1] - x[0]) / (len(x) - 1) / 2
    if len(y) < 2:
        return np.array([x[0] - half, x[-1] + half, -0.5, 0.5])
    return np.array([x[0] - half, x[-1] + half, y[0] - half, y[-1] + half])


def _rating(value: float | None) -> float:
    return np.nan if value is None else value
