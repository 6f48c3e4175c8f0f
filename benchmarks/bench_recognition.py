"""Recognition: ten trials in one batch against one after the other, and Levenberg-Marquardt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from timing import Table, best_of

from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.recognition import recognize
from rnnpb_explorer.core.recognition_lm import recognize_lm
from rnnpb_explorer.core.recognition_run import RecognitionConfig, RecognitionResult


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
    table.row("one by one / one batch", one_by_one, batched)
    table.row("one by one / Levenberg-Marquardt", one_by_one, quick)
    slow, fast = published(config), levenberg_marquardt()
    table.note(
        f"lowest loss: of ten trials {slow.best_reconstruction_loss.min():.5f}, "
        f"Levenberg-Marquardt {fast.best_reconstruction_loss.min():.5f} "
        f"after {fast.loss.shape[1]} iterations"
    )
    return table


def _target(model: RNNPB) -> NDArray[np.float32]:
    """A motion that the model does not know: one of its own, slowed, scaled and shifted."""
    motion = model.generate(model.mu[:1], 112)[0].numpy()
    time = np.linspace(0, 111, 140)
    slowed = np.stack([np.interp(time, np.arange(112), joint) for joint in motion.T], axis=1)
    return (1.1 * slowed + 0.05).astype(np.float32)
