"""How many motions to generate at once: enough to fill the processor, not the memory."""

from __future__ import annotations

from torch import Tensor

CHUNK_FRAMES = 9_000  # 64 motions of 140 frames; more at once is no quicker, and stops later


def batch_size(frames: int) -> int:
    """How many motions of so many frames make one batch."""
    return max(1, CHUNK_FRAMES // frames)


def chunks(pbs: Tensor, frames: int) -> tuple[Tensor, ...]:
    """Split PBs (B, D) into chunks (b, D) to generate `frames` frames of each in one batch."""
    parts: tuple[Tensor, ...] = pbs.split(batch_size(frames))
    return parts
