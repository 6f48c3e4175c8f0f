"""Motions as tasks: those of one model in one batch, long ones in parts; how large a piece is.

Measured on one thread for the shipped models (256 hidden units): B motions of 140 frames take
2.5 ms for B = 1, 8 ms for 8, 13 ms for 16 and 54 ms for 64 on a quiet core, up to twice that beside
others. So T frames of B motions take about as long as T (B + 4) frames do in a large batch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from ...core.model import RNNPB
from ...core.walk import morph
from ..state.work import Vector
from .job import Task

PIECE = 2_800  # T (B + 4) that take up to 25 ms: 16 motions of 140 frames
OVERHEAD = 4  # what a frame costs besides, in motions
HIDDEN = 256
FEWEST = 12  # motions of a batch; fewer at once would take much longer in all


def batch_size(model: RNNPB, frames: int) -> int:
    """How many motions of so many frames to generate at once, in pieces of `frames_at_once`."""
    return max(FEWEST, _piece(model) // frames - OVERHEAD)


def frames_at_once(model: RNNPB, motions: int, frames: int) -> int:
    """How many frames of so many motions make a piece; the parts are of about the same length."""
    parts = -(-frames * (motions + OVERHEAD) // _piece(model))
    return -(-frames // parts)


def _piece(model: RNNPB) -> int:
    """A frame of a wider network takes as much longer as its matrix is larger."""
    return int(PIECE * min(1.0, (HIDDEN / model.config.hidden_size) ** 2))


class Generation(Task):
    """The motion of one PB; its `positions` (T, J) are there when the round is over.

    Args:
        along: PBs that it goes along instead (core/walk.py).
    """

    def __init__(
        self, model: RNNPB, pb: Vector, steps: int, along: tuple[Vector, ...] = ()
    ) -> None:
        self._model, self._pb, self._steps, self._along = model, pb, steps, along
        self._at_once = frames_at_once(model, 1, steps)
        self.positions: NDArray[np.float32]
        super().__init__(self._in_parts())

    def joins(self, batch: Sequence[Task]) -> bool:
        """Those of the same model, as long as together they are one piece."""
        motions = [task for task in batch if isinstance(task, Generation)]
        if not motions or any(task._along for task in (self, *motions)):
            return False
        longest = max(self._steps, *(task._steps for task in motions))
        return all(task._model is self._model for task in motions) and longest <= frames_at_once(
            self._model, len(motions) + 1, longest
        )

    def step(self, riders: Sequence[Task] = ()) -> bool:
        batch = [self, *(task for task in riders if isinstance(task, Generation))]
        if self._along or self._at_once < self._steps:
            return super().step()
        with torch.inference_mode():
            motions = self._model.generate(
                _tensor(self._model, [one._pb for one in batch]), max(one._steps for one in batch)
            ).cpu()
        for one, motion in zip(batch, motions, strict=True):
            one.positions = motion[: one._steps].numpy().copy()
        return True

    @torch.inference_mode()
    def _in_parts(self) -> Iterator[None]:
        """A motion too long for one piece, or whose PB moves."""
        parts: list[torch.Tensor] = []
        if self._along:
            pb = _tensor(self._model, morph(np.array(self._along), self._steps)[:, None].tolist())
        else:
            pb = _tensor(self._model, [self._pb])
        for part in self._model.generate_in_parts(pb, self._steps, self._at_once):
            parts.append(part[0].cpu())
            yield
        self.positions = torch.cat(parts).numpy()


def _tensor(model: RNNPB, pbs: Sequence[object]) -> torch.Tensor:
    return torch.tensor(pbs, dtype=model.mu.dtype, device=model.mu.device)
