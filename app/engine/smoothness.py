"""How smooth a latent space is at the puck, and on the way to another motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import torch

from ...core.smoothness import Stretch, shortest_pieces, stretch_pieces
from ...core.walk import Walk
from ..state.results import StretchResult, WaysResult
from ..state.work import StretchWork, WaysWork
from .job import Last, Priority, Round, Stage, Steps, Task
from .sources import Sources


def stretch_here(work: StretchWork, sources: Sources) -> Steps:
    """At mu, in degrees."""
    model = sources.models[work.model]
    found = Last(stretch_pieces(model, torch.tensor(work.mu)))
    yield Round(Priority.SMOOTHNESS, [found])
    assert isinstance(found.result, Stretch)
    degrees = float(np.rad2deg(found.result.largest))
    yield Stage(StretchResult(degrees, found.result.condition), done=True)


def ways(work: WaysWork, sources: Sources) -> Steps:
    """The straight line at once, the shortest way as it is found."""
    model = sources.models[work.model]
    pieces = shortest_pieces(model, torch.tensor(work.start), torch.tensor(work.end))
    first = _Next(pieces)
    yield Round(Priority.SMOOTHNESS, [first])
    straight = best = first.result
    assert straight is not None
    assert best is not None
    yield Stage(WaysResult(straight, best, sought=False), done=False)
    while True:
        further = _Next(pieces)
        yield Round(Priority.SMOOTHNESS, [further])
        if further.result is None:
            break
        best = further.result
    yield Stage(WaysResult(straight, best, sought=True), done=True)


class _Next(Task):
    """Until the next way; None at the end."""

    def __init__(self, pieces: Iterator[Walk | None]) -> None:
        self.result: Walk | None = None
        super().__init__(self._until(pieces))

    def _until(self, pieces: Iterator[Walk | None]) -> Iterator[None]:
        for piece in pieces:
            if piece is not None:
                self.result = piece
                return
            yield
