"""Recognition: trials in one batch, Levenberg-Marquardt from a codebook, a frame at a time."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from timing import Table, best_of

from rnnpb_explorer.core.codebook import Codebook
from rnnpb_explorer.core.following import Follower
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.recognition import recognize
from rnnpb_explorer.core.recognition_lm import recognize_lm
from rnnpb_explorer.core.recognition_run import (
    RecognitionConfig,
    RecognitionResult,
    RecognitionStep,
)

FRAMES = 300  # of the motion that arrives


def run(model: RNNPB) -> Table:
    target = _target(model)
    config = RecognitionConfig(trials=10)  # 100 iterations each

    def published(config: RecognitionConfig) -> RecognitionResult:
        return RecognitionResult.from_steps(recognize(model, target, config))

    def levenberg_marquardt() -> RecognitionResult:
        return RecognitionResult.from_steps(recognize_lm(model, target))

    one_by_one = 100 * best_of(lambda: published(replace(config, trials=1, iterations=10)))
    batched = 10 * best_of(lambda: published(replace(config, iterations=10)))
    quick = best_of(levenberg_marquardt)
    table = Table(
        "Recognition, 10 trials x 100 iterations, 140 frames", "one by one", "another way"
    )
    table.row("one by one / one batch", one_by_one, batched, aim=15)
    table.row("one by one / Levenberg-Marquardt", one_by_one, quick)
    slow, fast = published(config), levenberg_marquardt()
    _global(table, model, target)
    table.note(
        f"lowest loss: of ten trials {slow.best_reconstruction_loss.min():.5f}, "
        f"Levenberg-Marquardt {fast.best_reconstruction_loss.min():.5f} "
        f"after {fast.loss.shape[1]} iterations"
    )
    return table


def _global(table: Table, model: RNNPB, target: NDArray[np.float32]) -> None:
    """A search from a codebook against one published trial; a frame of a motion that arrives."""
    started = time.perf_counter()
    book = Codebook(model)
    while not book.complete:
        for _ in book.grow():
            pass
    made = time.perf_counter() - started

    def search() -> list[RecognitionStep]:
        return list(recognize_lm(model, target, codebook=book))

    one = best_of(lambda: list(recognize(model, target, RecognitionConfig())))
    table.row("one published trial / global search", one, best_of(search))
    motion = np.concatenate([target, target, target])[:FRAMES]
    with Follower(model, codebook=book, horizon=FRAMES) as follower:
        updates, begun = [], time.perf_counter()
        for number, frame in enumerate(motion):
            while time.perf_counter() < begun + number / model.info.fps:
                time.sleep(0.001)
            updates.append(follower.update(frame).milliseconds)
    quiet = Follower(model, codebook=book, horizon=FRAMES, beside=False)
    for frame in motion:
        quiet.update(frame)
    started = time.perf_counter()
    while quiet.work():
        pass
    beside = time.perf_counter() - started
    table.row("search of all frames / one more frame", best_of(search), np.median(updates) / 1e3)
    table.note(
        f"codebook of {len(book)} motions: {made:.1f} s, {book.motions.nbytes / 1e6:.0f} MB; "
        f"{FRAMES} frames as they come: median {np.median(updates):.1f} ms, 95th percentile "
        f"{np.quantile(updates, 0.95):.1f} ms a frame; to linearise anew {1e3 * beside:.0f} ms"
    )


def _target(model: RNNPB) -> NDArray[np.float32]:
    """A motion that the model does not know: one of its own, slowed, scaled and shifted."""
    motion = model.generate(model.mu[:1], 112)[0].numpy()
    time = np.linspace(0, 111, 140)
    slowed = np.stack([np.interp(time, np.arange(112), joint) for joint in motion.T], axis=1)
    return (1.1 * slowed + 0.05).astype(np.float32)
