"""The correlation landscape (Fig. 4): how alike motions stay as the PB moves in a plane.

Each cell is one PB; its value is the correlation between the motion generated from it at sigma = 0
and a target: Pearson's over time for each joint, averaged over joints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from .batching import batch_size
from .errors import Cancelled, InputError
from .model import RNNPB
from .windows import Landscape, plane, unit_directions

COARSE_CELLS = 6  # cells along each axis of the first, coarse stage


def pearson(generated: Tensor, target: Tensor) -> Tensor:
    """Pearson's correlation over time of each joint, averaged over joints.

    A joint that is constant on either side has no correlation and is left out of the average. Where
    that leaves no joint the value is 0.

    Args:
        generated: (B, T, J).
        target: (T, J).

    Returns:
        (B,) float64.
    """
    # In float64 a constant joint has exactly no variance, and a nearly constant one its own.
    generated, target = generated.double(), target.double()
    a = generated - generated.mean(dim=1, keepdim=True)  # (B, T, J)
    b = target - target.mean(dim=0)  # (T, J)
    product = (a * b).sum(dim=1)  # (B, J)
    scale = (a.square().sum(dim=1) * b.square().sum(dim=0)).sqrt()
    moving = scale > 0
    correlation = torch.where(moving, product / scale, 0.0)
    return correlation.sum(dim=1) / moving.sum(dim=1).clamp(min=1)


def landscape(
    model: RNNPB,
    target: ArrayLike,
    center: ArrayLike,
    *,
    directions: ArrayLike | None = None,
    axes: tuple[int, ...] = (0, 1),
    radius: float = 1.0,
    grid: int = 20,
    origin: ArrayLike = 0.0,
    cancelled: Callable[[], bool] | None = None,
) -> Landscape:
    """The complete landscape around `center`; see `landscape_stages`."""
    cells = LandscapeCells(
        model,
        target,
        center,
        directions=directions,
        axes=axes,
        radius=radius,
        grid=grid,
        origin=origin,
    )
    _compute(cells, np.sort(np.concatenate([cells.coarse, cells.rest])), cancelled)
    return cells.landscape(complete=True)


def landscape_stages(
    model: RNNPB,
    target: ArrayLike,
    center: ArrayLike,
    *,
    directions: ArrayLike | None = None,
    axes: tuple[int, ...] = (0, 1),
    radius: float = 1.0,
    grid: int = 20,
    origin: ArrayLike = 0.0,
    cancelled: Callable[[], bool] | None = None,
) -> Iterator[Landscape]:
    """A coarse landscape at once, then the complete one, which reuses the cells of the first.

    Args:
        target: (T, J), what generated motions are compared with; it decides their length.
        center: (D,) the PB in the middle of the window.
        directions: (2, D) orthonormal rows; by default the unit vectors of `axes`.
        axes: the two components of the PB to vary, from 0; only the first where D = 1.
        radius, grid, origin: see `plane`.
        cancelled: asked between chunks of work.

    Raises:
        InputError: a target of another number of joints, no such axes, fewer than two cells.
        Cancelled: `cancelled` said so.
    """
    cells = LandscapeCells(
        model,
        target,
        center,
        directions=directions,
        axes=axes,
        radius=radius,
        grid=grid,
        origin=origin,
    )
    _compute(cells, cells.coarse, cancelled)
    if cells.rest.size:
        yield cells.landscape(complete=False)
        _compute(cells, cells.rest, cancelled)
    yield cells.landscape(complete=True)


def _compute(
    cells: LandscapeCells, which: NDArray[np.intp], cancelled: Callable[[], bool] | None
) -> None:
    """Compute cells in chunks as large as are quick; `cancelled` is asked before each."""
    size = batch_size(cells.frames)
    for chunk in np.split(which, range(size, len(which), size)):
        if cancelled is not None and cancelled():
            raise Cancelled
        for _ in cells.compute(chunk):
            pass


class LandscapeCells:
    """The cells of a landscape while they are computed: in any order, by any number of threads.

    Arguments and errors as those of `landscape_stages`.

    frames: T, the length of every motion.
    coarse, rest: the cells of the two stages, as indices of the flattened grid.
    """

    def __init__(
        self,
        model: RNNPB,
        target: ArrayLike,
        center: ArrayLike,
        *,
        directions: ArrayLike | None = None,
        axes: tuple[int, ...] = (0, 1),
        radius: float = 1.0,
        grid: int = 20,
        origin: ArrayLike = 0.0,
    ) -> None:
        self._model = model
        self._target = torch.as_tensor(np.array(target, dtype=np.float32)).to(model.mu.device)
        if self._target.ndim != 2 or self._target.shape[1] != model.config.num_joints:
            raise InputError(
                f"the target has shape {tuple(self._target.shape)}, "
                f"the model generates (frames, {model.config.num_joints})"
            )
        if grid < 2:
            raise InputError(f"a landscape has at least 2 cells along an axis, got {grid}")
        if directions is None:
            directions = unit_directions(model.config.pb_dim, axes)
        pbs, self._x, self._y = plane(center, directions, radius, grid, origin=origin)
        self._pbs = torch.as_tensor(pbs.reshape(-1, pbs.shape[-1])).to(model.mu)  # (cells, D)
        self._shape = pbs.shape[:2]
        self._correlation = np.zeros(self._shape, dtype=np.float32)
        self._rows, self._columns = (_coarse(size) for size in self._shape)
        cells = np.arange(len(self._pbs)).reshape(self._shape)
        self.frames = len(self._target)
        self.coarse = cells[np.ix_(self._rows, self._columns)].ravel()
        self.rest = np.setdiff1d(cells, self.coarse)

    @torch.inference_mode()
    def compute(self, cells: NDArray[np.intp], at_once: int | None = None) -> Iterator[None]:
        """Fill in some cells, all their motions in one batch.

        Yields after each part of at most `at_once` frames; does not where all is one part.
        """
        pbs = self._pbs[cells]
        if at_once is None or at_once >= self.frames:
            motions = self._model.generate(pbs, self.frames)
        else:
            parts: list[Tensor] = []
            for part in self._model.generate_in_parts(pbs, self.frames, at_once):
                parts.append(part)
                yield
            motions = torch.cat(parts, dim=1)
        correlation = pearson(motions, self._target)
        self._correlation.flat[cells] = correlation.cpu().numpy()

    def landscape(self, *, complete: bool) -> Landscape:
        """As it stands; unless complete, every cell shows the closest one of the coarse stage."""
        values = self._correlation.copy()
        if not complete:
            rows, columns = (
                computed[np.abs(np.arange(size)[:, None] - computed).argmin(axis=1)]
                for size, computed in zip(self._shape, (self._rows, self._columns), strict=True)
            )
            values = values[np.ix_(rows, columns)]
        return Landscape(values, self._x, self._y, complete=complete)


def _coarse(size: int) -> NDArray[np.intp]:
    """Indices of the cells along one axis that the coarse stage computes."""
    return np.unique(np.linspace(0, size - 1, min(size, COARSE_CELLS)).round().astype(np.intp))
