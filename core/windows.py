"""A landscape's window: where its cells lie, and the values that they take.

Arrays alone; what computes the values is `correlation.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError
from .latent_map import spread

NEAR_MAXIMUM = 0.9  # `area` counts the cells above this share of the maximum

# Half of a window: as the paper has it, or in standard deviations of the learned mu, which takes
# the scale of a model's space out of a comparison.
Window = Literal["absolute", "sd"]
WINDOW_RADIUS: dict[Window, float] = {"absolute": 1.0, "sd": 0.7}


def window_radius(mu: ArrayLike, window: Window) -> float:
    """Half of a window in the space of N learned mu, (N, D), in units of the PB."""
    return WINDOW_RADIUS[window] * (spread(mu) if window == "sd" else 1.0)


@dataclass(frozen=True, eq=False)
class Landscape:
    """correlation: (grid, grid) in -1..1, row = second axis, column = first axis, both ascending.

    x, y: (grid,) values along the first and the second axis. A model of one dimension has no second
    axis: correlation is (1, grid) then, and y is [0].
    complete: false for a coarse stage, whose cells are filled with the nearest one computed.
    """

    correlation: NDArray[np.float32]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    complete: bool = True

    @property
    def mean(self) -> float:
        return float(self.correlation.mean(dtype=np.float64))

    @property
    def area(self) -> float:
        """Share of cells above 0.9 times the maximum."""
        return float((self.correlation > NEAR_MAXIMUM * self.correlation.max()).mean())

    @property
    def roughness(self) -> float:
        """Mean absolute difference of neighbouring cells; 0 where there is one cell."""
        along = [np.abs(np.diff(self.correlation, axis=axis)).ravel() for axis in (0, 1)]
        differences = np.concatenate(along)
        return float(differences.mean(dtype=np.float64)) if differences.size else 0.0


def plane(
    center: ArrayLike,
    directions: ArrayLike,
    radius: float = 1.0,
    grid: int = 20,
    *,
    origin: ArrayLike = 0.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The cells of a landscape: a grid of PBs around `center`.

    Args:
        center: (D,).
        directions: (2, D) orthonormal rows, the axes; (1, D) for a line.
        radius: half of the window along both axes.
        origin: (D,) where the axes' values are 0. With 0 and a unit vector e_k as direction they
            are values of mu_k; with a map's mean and components, coordinates of the map.

    Returns:
        PBs (grid, grid, D), row = second axis, and the values x (grid,), y (grid,) along the axes.
        For a line the PBs are (1, grid, D), and y is [0].
    """
    middle = np.asarray(center, dtype=np.float64)
    axes = np.atleast_2d(np.asarray(directions, dtype=np.float64))
    offsets = radius * np.linspace(-1.0, 1.0, grid)
    values = (middle - np.asarray(origin, dtype=np.float64)) @ axes.T
    pbs = middle + offsets[None, :, None] * axes[0]  # (1, grid, D)
    if len(axes) == 1:
        return pbs, values[0] + offsets, np.zeros(1)
    pbs = pbs + offsets[:, None, None] * axes[1]
    return pbs, values[0] + offsets, values[1] + offsets


def unit_directions(pb_dim: int, axes: tuple[int, ...]) -> NDArray[np.float64]:
    """(2, D) unit vectors of two components of a PB; (1, D) where D = 1.

    Raises:
        InputError: there are no two such components.
    """
    axes = axes[:pb_dim]
    if len(set(axes)) != min(2, pb_dim) or not all(0 <= axis < pb_dim for axis in axes):
        raise InputError(f"a landscape has two different axes from 0 to {pb_dim - 1}, got {axes}")
    return np.eye(pb_dim)[list(axes)]
