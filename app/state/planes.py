"""The two planes through the latent space that the boards draw. Pure functions of the document.

The map's plane goes through the puck along two principal components. The landscape's goes along
two components of mu, or along the map's two; it is a window around an anchor, and the components
that it does not draw are the puck's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...core.windows import window_radius
from .document import Document, ModelChoice
from .facts import Array, ModelFacts


def fitting_axes(axes: tuple[int, ...], dim: int) -> tuple[int, ...]:
    """The axes, or the first ones where the model has others: models side by side differ in D."""
    return axes if drawable_axes(axes, dim) else (0, 1)[:dim]


@dataclass(frozen=True, eq=False)
class LandscapePlane:
    """Where the landscape lies: center + a * directions[0] + b * directions[1]."""

    center: Array  # (D,)
    directions: Array  # (A, D), A = 1 or 2
    zero: Array  # (D,) where the values on the axes are 0
    middle: Array  # (A,) values on the axes at the centre
    radius: float
    labels: tuple[str, ...]  # one an axis


def landscape_plane(facts: ModelFacts, document: Document, choice: ModelChoice) -> LandscapePlane:
    """The window around the anchor along two axes; the other components as they are now."""
    radius = window_radius(facts.mu, document.window)
    mu = np.array(choice.latent.mu)
    if document.landscape_axes == "pca":
        axes = fitting_axes(document.map_axes, facts.pb_dim)
        anchor = facts.latent_map.project(choice.anchor)[list(axes)]
        center = facts.latent_map.move(mu, axes, anchor.tolist())
        directions = facts.latent_map.components[list(axes)]
        labels = tuple(f"PC{axis + 1}" for axis in axes)
        return LandscapePlane(center, directions, facts.latent_map.mean, anchor, radius, labels)
    axes = fitting_axes(document.landscape_axes, facts.pb_dim)
    mu[list(axes)] = np.array(choice.anchor)[list(axes)]
    directions = np.eye(facts.pb_dim)[list(axes)]
    labels = tuple(f"μ{axis + 1}" for axis in axes)
    return LandscapePlane(mu, directions, np.zeros(facts.pb_dim), mu[list(axes)], radius, labels)


def on_landscape(facts: ModelFacts, document: Document, points: ArrayLike) -> Array:
    """(..., A): points (..., D) of the latent space in the landscape's coordinates."""
    if document.landscape_axes == "pca":
        axes = fitting_axes(document.map_axes, facts.pb_dim)
        return facts.latent_map.project(points)[..., list(axes)]
    axes = fitting_axes(document.landscape_axes, facts.pb_dim)
    return np.asarray(points, dtype=np.float64)[..., list(axes)]


def moved_on_landscape(
    facts: ModelFacts, document: Document, mu: ArrayLike, to: tuple[float, ...]
) -> Array:
    """(D,): mu with the landscape's axes at `to`, the other components alone."""
    if document.landscape_axes == "pca":
        return facts.latent_map.move(mu, fitting_axes(document.map_axes, facts.pb_dim), to)
    moved = np.array(mu, dtype=np.float64)
    moved[list(fitting_axes(document.landscape_axes, facts.pb_dim))] = to
    return moved


def inside_window(facts: ModelFacts, document: Document, choice: ModelChoice) -> bool:
    """Whether the puck lies in the landscape's window."""
    where = landscape_plane(facts, document, choice)
    offset = on_landscape(facts, document, choice.latent.mu) - where.middle
    return bool((np.abs(offset) <= where.radius * (1 + 1e-9)).all())


def valid_axes(axes: tuple[int, ...], dim: int) -> bool:
    """Whether these are different components of a PB of `dim` dimensions."""
    return 1 <= len(set(axes)) == len(axes) and all(0 <= axis < dim for axis in axes)


def drawable_axes(axes: tuple[int, ...], dim: int) -> bool:
    """Whether a board can be drawn along these: two, or the one that there is."""
    return valid_axes(axes, dim) and len(axes) == min(dim, 2)
