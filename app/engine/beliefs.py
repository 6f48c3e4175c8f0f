"""Codebooks, made where nothing else is to do, and the belief over them."""

from __future__ import annotations

import time

from ...core.belief import belief_cloud
from ...core.codebook import BATCH, FRAMES, Codebook
from ..state.results import BeliefResult, CodebookResult
from ..state.work import BeliefWork, CodebookWork
from .generation import Generation, frames_at_once
from .job import Call, Priority, Round, Stage, Steps, Task
from .sources import Sources

GROWS = 2  # times as large as the last one that was told of


def codebook(work: CodebookWork, sources: Sources) -> Steps:
    """From the user's cache, or made and kept there; told of while it grows."""
    book = sources.codebook(work.model)
    started = time.monotonic()
    if not book.entries:
        yield Round(Priority.COARSE, [Call(book.restore)])
    made = not book.complete
    told = 0
    while not book.complete:
        yield growth(book, sources, Priority.CODEBOOK)
        if book.entries >= max(GROWS * told, 1) and not book.complete:
            told = book.entries
            yield Stage(CodebookResult(told, len(book), 0.0), done=False)
    if made:
        yield Round(Priority.CODEBOOK, [Call(book.save)])
    seconds = time.monotonic() - started if made else 0.0
    yield Stage(CodebookResult(len(book), len(book), seconds), done=True)


def growth(book: Codebook, sources: Sources, priority: Priority) -> Round:
    """A batch of motions for every worker."""
    at_once = frames_at_once(book.model, BATCH, FRAMES)
    return Round(priority, [Task(book.grow(at_once)) for _ in range(sources.workers)])


def belief(work: BeliefWork, sources: Sources) -> Steps:
    """The cloud, and the motions of what it is torn between."""
    book = sources.codebook(work.model)
    seen = work.target.array[: max(1, int(work.observed * len(work.target)))]
    cloud = Call(
        lambda: belief_cloud(
            book,
            seen,
            scale=work.scale,
            joints=work.joints or None,
            steps=len(work.target),
        )
    )
    yield Round(Priority.RECOGNITION, [cloud])
    model, steps = sources.models[work.model], len(work.target)
    modes = [Generation(model, tuple(mode.pb.tolist()), steps) for mode in cloud.value.modes]
    yield Round(Priority.RECOGNITION, modes)
    yield Stage(BeliefResult(cloud.value, tuple(one.positions for one in modes)), done=True)
