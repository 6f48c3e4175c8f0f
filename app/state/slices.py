"""The two planes through the latent space that the boards show. Pure functions of the state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.windows import WINDOW_RADIUS
from .document import AppState, Array, Latent, ModelFacts, ModelState


def fitting_axes(axes: tuple[int, ...], dim: int) -> tuple[int, ...]:
    """The axes, or the first ones where the model has others: models side by side differ in D."""
    return axes if drawable_axes(axes, dim) else (0, 1)[:dim]


@dataclass(frozen=True, eq=False)
class LandscapeSlice:
    """Where the landscape lies: center + a * directions[0] + b * directions[1]."""

    center: Array  # (D,)
    directions: Array  # (A, D), A = 1 or 2
    zero: Array  # (D,) where the values on the axes are 0
    middle: Array  # (A,) values on the axes at the centre
    radius: float
    labels: tuple[str, ...]  # one an axis


def landscape_slice(facts: ModelFacts, state: AppState, model: ModelState) -> LandscapeSlice:
    """The window around the anchor along two axes; the other components as they are now."""
    radius = WINDOW_RADIUS[state.window] * (facts.mu_sd if state.window == "sd" else 1.0)
    if state.landscape_axes == "pca":
        axes = fitting_axes(state.map_axes, facts.pb_dim)
        anchor = facts.latent_map.project(model.anchor)
        center = facts.latent_map.move(model.latent.mu, axes, [anchor[axis] for axis in axes])
        directions = facts.latent_map.components[list(axes)]
        labels = tuple(f"PC{axis + 1}" for axis in axes)
        return LandscapeSlice(
            center, directions, facts.latent_map.mean, anchor[list(axes)], radius, labels
        )
    axes = fitting_axes(state.landscape_axes, facts.pb_dim)
    center = model.latent.mu.copy()
    center[list(axes)] = model.anchor[list(axes)]
    directions = np.eye(facts.pb_dim)[list(axes)]
    labels = tuple(f"μ{axis + 1}" for axis in axes)
    zero = np.zeros(facts.pb_dim)
    return LandscapeSlice(center, directions, zero, center[list(axes)], radius, labels)


def on_landscape(facts: ModelFacts, state: AppState, points: Array) -> Array:
    """(..., A): points (..., D) of the latent space in the landscape's coordinates."""
    if state.landscape_axes == "pca":
        axes = fitting_axes(state.map_axes, facts.pb_dim)
        return facts.latent_map.project(points)[..., list(axes)]
    return np.asarray(points)[..., list(fitting_axes(state.landscape_axes, facts.pb_dim))]


def moved_on_landscape(
    facts: ModelFacts, state: AppState, latent: Latent, to: tuple[float, ...]
) -> Array:
    """(D,): the latent's mu with the landscape's axes at `to`, the other components alone."""
    if state.landscape_axes == "pca":
        return facts.latent_map.move(latent.mu, fitting_axes(state.map_axes, facts.pb_dim), to)
    mu = latent.mu.copy()
    mu[list(fitting_axes(state.landscape_axes, facts.pb_dim))] = to
    return mu


def inside_window(facts: ModelFacts, state: AppState, model: ModelState) -> bool:
    """Whether the puck lies in the landscape's window."""
    where = landscape_slice(facts, state, model)
    offset = on_landscape(facts, state, model.latent.mu) - where.middle
    return bool((np.abs(offset) <= where.radius + 1e-9).all())


def valid_axes(axes: tuple[int, ...], dim: int) -> bool:
    """Whether these are different components of a PB of `dim` dimensions."""
    return 1 <= len(set(axes)) == len(axes) and all(0 <= axis < dim for axis in axes)


def drawable_axes(axes: tuple[int, ...], dim: int) -> bool:
    """Whether a board can be drawn along these: two, or the one that there is."""
    return valid_axes(axes, dim) and len(axes) == min(dim, 2)
