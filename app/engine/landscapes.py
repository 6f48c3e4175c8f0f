"""Correlation landscapes: coarse as soon as can be, complete when the hand rests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.correlation import LandscapeCells
from ...core.model import RNNPB
from ..state.results import LandscapeResult
from ..state.work import LandscapeWork
from .generation import Generation, batch_size, frames_at_once
from .job import Priority, Round, Stage, Steps, Task
from .sources import Sources

WORTHWHILE = 8  # motions; fewer for each worker would take longer in all without being sooner there


def landscape(work: LandscapeWork, sources: Sources, wanted_at: float) -> Steps:
    """As `core.correlation.landscape_stages`, whose values these are, all workers at once."""
    model = sources.models[work.model]
    target = _known_target(work, sources)
    if target is None:
        length = model.length(work.motion)
        own = Generation(model, tuple(model.mu[work.motion].tolist()), length)
        yield Round(Priority.COARSE, [own], finish=True)
        target = sources.reconstructions[work.model, work.motion] = own.positions
    cells = LandscapeCells(
        model,
        target,
        work.center,
        directions=work.directions,
        radius=work.radius,
        origin=work.zero,
    )
    tasks = _tasks(model, cells, cells.coarse, sources.workers)
    yield Round(Priority.COARSE, tasks, finish=True)
    if cells.rest.size:
        yield Stage(LandscapeResult(cells.landscape(complete=False)), done=False)
        tasks = _tasks(model, cells, cells.rest, sources.workers)
        yield Round(Priority.COMPLETE, tasks, not_before=wanted_at + sources.rest_seconds)
    yield Stage(LandscapeResult(cells.landscape(complete=True)), done=True)


def _known_target(work: LandscapeWork, sources: Sources) -> NDArray[np.float32] | None:
    """(T, J) what motions are compared with; None: an own reconstruction that nobody has made."""
    if work.target is not None:
        return work.target.array
    recorded = sources.data[work.model][work.motion]
    if recorded is not None:
        return recorded.positions
    return sources.reconstructions.get((work.model, work.motion))


def _tasks(
    model: RNNPB, cells: LandscapeCells, which: NDArray[np.intp], workers: int
) -> list[Task]:
    """The cells in batches of about the same size, as many for one worker as for another."""
    count = -(-len(which) // batch_size(model, cells.frames))
    even = -(-count // workers) * workers
    if len(which) >= even * WORTHWHILE:
        count = even
    return [
        Task(cells.compute(batch, frames_at_once(model, len(batch), cells.frames)))
        for batch in np.array_split(which, count)
    ]
