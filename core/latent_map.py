"""The map of learned PBs: principal components of the mu_i, and moves in a plane of them.

Figs. 3 and 6 of the paper draw PBs on their first two principal components. Here the map has all
D of them, so that a point of a drawn plane and the components that are not drawn determine a PB.
Everything is float64, so that going to the map and back moves a PB by far less than float32 shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
TYPICAL_QUANTILE = 0.95  # of the nearest-neighbour distances among the learned mu


def spread(mu: ArrayLike) -> float:
    """The scale of a latent space: standard deviation of N learned mu (N, D), mean of dimensions.

    1, the prior's sigma, where there is no deviation.
    """
    points = np.asarray(mu, dtype=np.float64)
    return float(points.std(axis=0, ddof=1).mean()) or 1.0 if len(points) > 1 else 1.0


@dataclass(frozen=True)
class LatentMap:
    """PCA of N learned mu of D dimensions; any N and D from 1.

    mean: (D,).
    components: (D, D), orthonormal rows, by falling variance; also where N < D, the rows that no
        data determine then complete the basis.
    points: (N, D), the learned mu in map coordinates.
    spacing: typical distance from a learned mu to the nearest other.
    """

    mean: Array
    components: Array
    points: Array
    spacing: float

    @classmethod
    def fit(cls, mu: ArrayLike) -> LatentMap:
        """The map of the learned mu, (N, D)."""
        points = np.asarray(mu, dtype=np.float64)
        mean = points.mean(axis=0)
        components = np.linalg.svd(points - mean, full_matrices=True)[2]
        # A singular vector is determined up to its sign; the largest entry decides it.
        largest = np.take_along_axis(components, np.abs(components).argmax(1)[:, None], axis=1)
        components = components * np.where(largest < 0, -1.0, 1.0)
        return cls(mean, components, (points - mean) @ components.T, _spacing(points))

    @property
    def scale(self) -> Array:
        """(D,) standard deviation of the learned mu along each component."""
        scale: Array = self.points.std(axis=0)
        return scale

    def project(self, mu: ArrayLike) -> Array:
        """(..., D) PBs to (..., D) map coordinates."""
        coordinates: Array = (np.asarray(mu, dtype=np.float64) - self.mean) @ self.components.T
        return coordinates

    def unproject(self, coordinates: ArrayLike) -> Array:
        """(..., D) map coordinates to (..., D) PBs."""
        mu: Array = np.asarray(coordinates, dtype=np.float64) @ self.components + self.mean
        return mu

    def move(self, mu: ArrayLike, axes: Sequence[int], to: Sequence[float]) -> Array:
        """(D,) the PB at coordinates `to` along `axes`; its other coordinates are those of `mu`."""
        start = np.asarray(mu, dtype=np.float64)
        axis = list(axes)
        steps = np.asarray(to, dtype=np.float64) - self.project(start)[axis]
        moved: Array = start + steps @ self.components[axis]
        return moved

    def off_plane(self, mu: ArrayLike, axes: Sequence[int]) -> Array:
        """(N,) distance of each learned mu from the slice through `mu` along `axes`."""
        apart = np.delete(self.points - self.project(mu), list(axes), axis=1)
        distance: Array = np.linalg.norm(apart, axis=1)
        return distance

    def ellipse(self, sigma: ArrayLike, axes: Sequence[int]) -> Array:
        """Covariance of N(mu, diag sigma^2) along `axes`: (D,) to (len(axes), len(axes))."""
        drawn = self.components[list(axes)] * np.asarray(sigma, dtype=np.float64)
        covariance: Array = drawn @ drawn.T
        return covariance

    def extrapolation(self, mu: ArrayLike) -> float:
        """Distance from `mu`, (D,), to the nearest learned one in units of `spacing`.

        Above 1, `mu` lies farther from everything learned than learned PBs do from each other.
        """
        nearest = np.linalg.norm(self.points - self.project(mu), axis=1).min()
        return float(nearest / self.spacing)


def _spacing(points: Array) -> float:
    """The 95th percentile of nearest-neighbour distances; 1, the prior's sigma, where none."""
    if len(points) < 2:
        return 1.0
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    np.fill_diagonal(distances, np.inf)
    return float(np.quantile(distances.min(axis=1), TYPICAL_QUANTILE)) or 1.0
