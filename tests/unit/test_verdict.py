"""How much a recognition explains, and what it is called."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rnnpb_explorer.core import RNNPB
from rnnpb_explorer.core.codebook import complete_codebook
from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.paper.novel_patterns import novel_patterns
from rnnpb_explorer.core.recognition_lm import recognize_lm
from rnnpb_explorer.core.recognition_run import RecognitionResult
from rnnpb_explorer.core.verdict import Explained, explained, explained_words

Array = NDArray[np.float64]


def waves(frames: int = 40) -> Array:
    time = np.arange(frames)[:, None]
    return np.sin(time / 5 + np.arange(3)[None])


def test_a_perfect_motion_explains_all_and_the_mean_posture_nothing() -> None:
    truth = waves()
    perfect = explained(truth, truth, 30)
    assert (perfect.observed, perfect.foretold, perfect.hidden) == (1.0, 1.0, None)
    assert (perfect.error, perfect.foretold_error) == (0.0, 0.0)
    still = np.broadcast_to(truth[:30].mean(axis=0), truth.shape)
    nothing = explained(still, truth, 30)
    assert nothing.observed == pytest.approx(0.0)
    assert nothing.foretold == pytest.approx(0.0)


def test_the_shares_are_of_the_observed_joints_and_frames() -> None:
    truth = waves()
    output = truth.copy()
    output[:, 2] += 1.0  # a joint that nobody observed
    output[30:, 0] += 0.5
    share = explained(output, truth, 30, [0, 1])
    assert share.observed == 1.0
    around = np.square(truth[30:, :2] - truth[:30, :2].mean(axis=0)).sum()
    assert share.foretold == pytest.approx(1 - 10 * 0.25 / around)
    spread = np.square(truth[:, 2] - truth[:, 2].mean()).sum()
    assert share.hidden == pytest.approx(1 - 40 / spread)
    assert share.foretold_error == pytest.approx(0.125)


def test_where_all_is_observed_nothing_is_foretold() -> None:
    share = explained(waves(), waves(), 40)
    assert (share.foretold, share.foretold_error) == (None, None)


@pytest.mark.parametrize(
    ("observed", "error", "verdict"),
    [
        (1.0, 0.0, "recognised"),
        (0.9, 0.1, "recognised"),
        (0.89, 0.1, "partly recognised"),
        (0.6, 0.1, "partly recognised"),
        (0.59, 0.1, "beyond this model"),
        (-3.0, 0.1, "beyond this model"),
        (None, 0.0, "recognised"),  # nothing moves, and that is met
        (None, 0.1, "beyond this model"),
    ],
)
def test_the_verdict_is_on_what_was_observed(
    observed: float | None, error: float, verdict: str
) -> None:
    assert Explained(observed, 0.0, None, error, None).verdict == verdict


def test_the_shares_in_words() -> None:
    assert explained_words(Explained(0.974, 0.5, -7.0, 0.1, 0.1)) == (
        "97% of the observed variance explained, 50% of the foretold, "
        "less than -100% of the joints that were not observed"
    )
    assert explained_words(Explained(0.5, None, None, 0.1, None)) == (
        "50% of the observed variance explained"
    )


def test_learned_novel_and_foreign_motions_get_the_verdicts_that_they_deserve(
    strong: RNNPB, dataset: Dataset
) -> None:
    book = complete_codebook(strong, 512)

    def verdict(motion: NDArray[np.float32]) -> str:
        result = RecognitionResult.from_steps(recognize_lm(strong, motion, codebook=book))
        output = result.best_output[result.best_trial]
        return explained(output, motion, int(0.8 * len(motion))).verdict

    learned = [verdict(motion.positions) for motion in dataset.motions[::12]]
    novel = [verdict(motion.positions) for motion in novel_patterns(dataset.motions)]
    noise = np.random.default_rng(0).normal(0, 0.5, (80, 17)).astype(np.float32)
    assert learned.count("recognised") >= 5
    assert novel.count("beyond this model") <= 2
    assert verdict(noise) == "beyond this model"
