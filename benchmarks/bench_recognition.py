"""Ten recognition trials in one batch against one after the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from timing import Table, best_of

from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.recognition import RecognitionConfig, RecognitionResult, recognize


def run(model: RNNPB) -> Table:
    target = model.generate(model.mu[:1], 140)[0].numpy()
    target = target + 0.1 * np.sin(0.06 * np.arange(140))[:, None]
    config = RecognitionConfig(trials=10, iterations=10)

    def batched() -> None:
        RecognitionResult.from_steps(recognize(model, target, config))

    def one_by_one() -> None:
        for trial in range(config.trials):
            alone = replace(config, trials=1, first_trial=trial)
            RecognitionResult.from_steps(recognize(model, target, alone))

    table = Table("Recognition, 10 trials x 10 iterations, 140 frames", "one by one", "batched")
    table.row("published procedure", best_of(one_by_one, at_least=1), best_of(batched))
    return table
