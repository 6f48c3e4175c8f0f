"""How well a model recognises novel motions (Table II).

The paper gives one number for a model and a warm start. Which of a run's iterations, and which of
ten trials, it is of makes a large difference (see `Measure`), so all three are measured.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..codebook import Codebook
from ..model import RNNPB
from ..motion import Motion
from ..recognition import recognize
from ..recognition_lm import LMConfig, recognize_lm
from ..recognition_run import Init, RecognitionConfig, RecognitionResult

WARM_STARTS: tuple[Init, ...] = ("baseline", "learned", "random")
# A warm start of the published one, or Levenberg-Marquardt: from the learned mu, from a codebook.
Procedure = Init | Literal["lm", "global"]
RANDOM_CANDIDATES = 10  # of the warm start `random` in the paper


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation."""

    mean: float
    sd: float

    @classmethod
    def of(cls, values: NDArray[np.floating[Any]]) -> Spread:
        return cls(float(values.mean(dtype=np.float64)), float(values.std(dtype=np.float64)))


@dataclass(frozen=True)
class Measure:
    """One quantity, read off in three ways.

    last_iterate: over all patterns and trials, what the last iteration sampled. The published code
        reports it.
    best_iterate: over all patterns and trials, the iteration with the lowest reconstruction loss.
    best_of_trials: over the patterns, the best iterate of the trial whose reconstruction loss is
        lowest. It is what the paper's Table II agrees with.
    """

    last_iterate: Spread
    best_iterate: Spread
    best_of_trials: Spread


@dataclass(frozen=True)
class RecognitionRow:
    """One warm start of one model.

    explained: share of the observed variance, by the best of the trials. seconds: a pattern takes,
    all trials together.
    """

    warm_start: Procedure
    reconstruction_loss: Measure
    prediction_error: Measure
    explained: Spread
    seconds: float


def recognition_row(
    model: RNNPB,
    warm_start: Procedure,
    patterns: Sequence[Motion],
    *,
    trials: int = 10,
    iterations: int = 100,
    seed: int = 0,
    codebook: Codebook | None = None,
    recognized: Callable[[], object] = lambda: None,
) -> RecognitionRow:
    """Recognise every pattern in ten trials and measure how well that went.

    Args:
        patterns: novel ones; of several draws, all of them.
        trials: of each pattern, all in one batch; each has random numbers of its own. A run of
            Levenberg-Marquardt has no random numbers, and counts as one trial with all its starts.
        codebook: for `global`.
        recognized: called after each pattern.
    """
    results = []
    started = time.perf_counter()
    for number, pattern in enumerate(patterns):
        if warm_start == "lm" or warm_start == "global":
            book = codebook if warm_start == "global" else None
            steps = recognize_lm(model, pattern.positions, LMConfig(), codebook=book)
            results.append(RecognitionResult.from_steps(steps).of_best_trial())
        else:
            config = RecognitionConfig(
                init=warm_start,
                candidates=RANDOM_CANDIDATES,
                iterations=iterations,
                trials=trials,
                seed=seed,
                first_trial=number * trials,
            )
            results.append(
                RecognitionResult.from_steps(recognize(model, pattern.positions, config))
            )
        recognized()
    shares = [result.explained[result.best_trial] for result in results]
    return RecognitionRow(
        warm_start,
        _measure(results, "reconstruction_loss"),
        _measure(results, "prediction_error"),
        Spread.of(np.array(shares)),
        (time.perf_counter() - started) / max(len(results), 1),
    )


def _measure(results: Sequence[RecognitionResult], name: str) -> Measure:
    last = np.stack([getattr(result, name) for result in results])  # (patterns, trials)
    best = np.stack([getattr(result, f"best_{name}") for result in results])
    losses = np.stack([result.best_reconstruction_loss for result in results])
    chosen = np.take_along_axis(best, losses.argmin(axis=1)[:, None], axis=1)
    return Measure(Spread.of(last), Spread.of(best), Spread.of(chosen))
