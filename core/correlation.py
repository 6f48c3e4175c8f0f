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

from .batching import chunks
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
    cells = _Cells(model, target, center, directions, axes, radius, grid, origin)
    cells.compute(np.ones(cells.shape, dtype=bool), cancelled)
    return cells.landscape()


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
    cells = _Cells(model, target, center, directions, axes, radius, grid, origin)
    rows, columns = (_coarse(size) for size in cells.shape)
    coarse = np.zeros(cells.shape, dtype=bool)
    coarse[np.ix_(rows, columns)] = True
    cells.compute(coarse, cancelled)
    if not coarse.all():
        yield cells.landscape(nearest=(rows, columns))
        cells.compute(~coarse, cancelled)
    yield cells.landscape()


class _Cells:
    """The grid of a landscape while it is being computed."""

    def __init__(
        self,
        model: RNNPB,
        target: ArrayLike,
        center: ArrayLike,
        directions: ArrayLike | None,
        axes: tuple[int, ...],
        radius: float,
        grid: int,
        origin: ArrayLike,
    ) -> None:
        self._model = model
        self._target = torch.as_tensor(np.asarray(target, dtype=np.float32)).to(model.mu.device)
        if self._target.ndim != 2 or self._target.shape[1] != model.config.num_joints:
            raise InputError(
                f"the target has shape {tuple(self._target.shape)}, "
                f"the model generates (frames, {model.config.num_joints})"
            )
        if grid < 2:
            raise InputError(f"a landscape has at least 2 cells along an axis, got {grid}")
        if directions is None:
            directions = unit_directions(model.config.pb_dim, axes)
        self._pbs, self._x, self._y = plane(center, directions, radius, grid, origin=origin)
        self.shape = self._pbs.shape[:2]
        self._correlation = np.zeros(self.shape, dtype=np.float32)

    @torch.inference_mode()
    def compute(self, mask: NDArray[np.bool_], cancelled: Callable[[], bool] | None) -> None:
        """Fill in the cells of `mask`, all motions of a chunk in one batch."""
        frames, mu = len(self._target), self._model.mu
        pbs = torch.as_tensor(self._pbs[mask]).to(mu)  # (B, D)
        correlations = []
        for chunk in chunks(pbs, frames):
            if cancelled is not None and cancelled():
                raise Cancelled
            correlations.append(pearson(self._model.generate(chunk, frames), self._target))
        self._correlation[mask] = torch.cat(correlations).cpu().numpy()

    def landscape(
        self, nearest: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None
    ) -> Landscape:
        """As it stands; with `nearest` (rows, columns) every cell shows the closest of those."""
        values = self._correlation.copy()
        if nearest is not None:
            rows, columns = (
                computed[np.abs(np.arange(size)[:, None] - computed).argmin(axis=1)]
                for size, computed in zip(self.shape, nearest, strict=True)
            )
            values = values[np.ix_(rows, columns)]
        return Landscape(values, self._x, self._y, complete=nearest is None)


def _coarse(size: int) -> NDArray[np.intp]:
    """Indices of the cells along one axis that the coarse stage computes."""
    return np.unique(np.linspace(0, size - 1, min(size, COARSE_CELLS)).round().astype(np.intp))
