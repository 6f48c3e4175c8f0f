"""What the browser's part shows of a picture, as the messages of `shown.py`. Pure functions."""

from __future__ import annotations

import numpy as np

from ..state.facts import Array, ModelFacts
from ..state.on_recognition import shown_iteration
from ..state.picture import Picture
from ..state.planes import landscape_plane, on_landscape
from ..state.wanted import motion_steps
from .shown import CurvesShown, LandscapeShown, MapShown, PathShown, PlaybackShown, PuckShown
from .words import target_label, window_label

MAP_PADDING = 0.12  # of the learned points' extent, on every side of the map


def map_shown(picture: Picture) -> MapShown:
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
    )


def hidden_axes(picture: Picture) -> tuple[int, ...]:
    """The two components of the map that come after those that are drawn."""
    drawn = picture.document.map_axes
    return tuple(axis for axis in range(picture.model.pb_dim) if axis not in drawn)[:2]


def axis_labels(facts: ModelFacts, axes: tuple[int, ...]) -> tuple[str, ...]:
    """Each component with its share of the learned mu's variance."""
    variance = facts.latent_map.points.var(axis=0)
    shares = variance / max(float(variance.sum()), 1e-12)
    return tuple(f"PC{axis + 1} ({shares[axis]:.0%})" for axis in axes)


def puck_shown(picture: Picture, heard: int | None) -> PuckShown:
    """Where the active model stands.

    Args:
        heard: number of the last move of the page that is in it.
    """
    facts, latent, document = picture.model, picture.choice.latent, picture.document
    latent_map, axes = facts.latent_map, document.map_axes
    at = latent_map.project(latent.mu)
    covariance = np.zeros((2, 2))
    covariance[: len(axes), : len(axes)] = latent_map.ellipse(latent.sigma, axes)
    return PuckShown(
        on_map=_flat(at[list(axes)]),
        on_landscape=_flat(on_landscape(facts, document, latent.mu)),
        hidden=at[list(hidden_axes(picture))],
        covariance=covariance if facts.stochastic else None,
        off_plane=latent_map.off_plane(latent.mu, axes) if facts.pb_dim > 2 else None,
        extrapolation=latent_map.extrapolation(latent.mu),
        heard=heard,
    )


def landscape_shown(picture: Picture) -> LandscapeShown | None:
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
        model=work.model,
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
    )


def path_shown(picture: Picture) -> PathShown:
    """The drawn trial of the active model's recognition; an empty path where there is none."""
    if picture.drawn_run is None:
        return PathShown(None, None, np.zeros(0))
    run, trace = picture.drawn_run
    facts, document = picture.model, picture.document
    axes = list(document.map_axes)
    mu, pb = trace.mu[:, run.trial], trace.pb[:, run.trial]
    return PathShown(
        on_map=_flat(facts.latent_map.project(mu)[:, axes]),
        on_landscape=_flat(on_landscape(facts, document, mu)),
        radii=trace.sigma[:, run.trial].mean(axis=1),
        samples_on_map=_flat(facts.latent_map.project(pb)[:, axes]),
        samples_on_landscape=_flat(on_landscape(facts, document, pb)),
        shown=shown_iteration(run, trace) if trace.iterations else 0,
    )


def curves_shown(picture: Picture) -> CurvesShown:
    """What the time bar draws beside the active model's motion."""
    facts, document = picture.model, picture.document
    reference, seen = picture.reference(), picture.seen_target
    if reference is not None and seen is not None:
        reference = np.pad(
            seen, [(0, len(reference) - len(seen)), (0, 0)], constant_values=np.float32(np.nan)
        )
    return CurvesShown(
        names=facts.joints,
        joint=facts.joints.index(document.joint) if document.joint in facts.joints else None,
        reference=reference,
        observed=None if seen is None else document.recognition.observed,
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
