"""The belief over a codebook: Bayes' rule, and what it is torn between."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from rnnpb_explorer.core import RNNPB
from rnnpb_explorer.core.belief import DIFFERENT, belief_cloud, posterior
from rnnpb_explorer.core.codebook import STRIDE, Codebook, complete_codebook


@pytest.fixture(scope="module")
def book(strong: RNNPB) -> Codebook:
    return complete_codebook(strong, 512)


def test_it_is_bayes_rule() -> None:
    sums = np.array([[0.02, 0.05], [0.0, 0.30], [0.08, 0.05]])
    scale = 0.2
    likelihood = np.exp(-sums / (2 * scale**2))
    np.testing.assert_allclose(posterior(sums, scale), likelihood / likelihood.sum(axis=0))
    np.testing.assert_allclose(posterior(1e6 * sums[:2], 0.01)[:, 0], [0.0, 1.0])


def test_it_sharpens_while_the_motion_comes_in(strong: RNNPB, book: Codebook) -> None:
    motion = strong.reconstruct(10, 100).numpy()
    cloud = belief_cloud(book, motion)
    assert cloud.frames.tolist() == list(range(0, 100, STRIDE))
    assert cloud.entropy[-1] + 3 < cloud.entropy[0] < 9.01  # of 512 entries
    np.testing.assert_allclose(cloud.modes[0].pb, strong.mu[10].numpy(), atol=1e-6)
    assert cloud.modes[0].mass > 0.9
    assert int(cloud.nearest.argmin()) == 10
    assert cloud.nearest[10] < 0.01
    assert (cloud.weights.sum(axis=1) > 0.99).all()
    assert cloud.weights.shape == (len(cloud.frames), len(cloud.pbs))


def test_a_larger_error_scale_is_less_sure(strong: RNNPB, book: Codebook) -> None:
    motion = strong.reconstruct(10, 60).numpy()
    sure, unsure = (belief_cloud(book, motion, scale=scale).entropy for scale in (0.05, 0.5))
    assert (sure < unsure).all()


def test_what_was_not_observed_says_nothing(strong: RNNPB, book: Codebook) -> None:
    motion = strong.reconstruct(10, 60).numpy()
    broken = motion.copy()
    broken[:, 5:] = 9.0
    joints = list(range(5))
    seen, of_broken = (belief_cloud(book, one, joints=joints) for one in (motion, broken))
    np.testing.assert_array_equal(seen.weights, of_broken.weights)
    assert belief_cloud(book, broken).modes[0].pb.tolist() != seen.modes[0].pb.tolist()


def test_it_is_torn_between_motions_that_begin_alike_and_end_differently(
    tiny_model: RNNPB,
) -> None:
    """Two entries of a hand-made codebook, equal up to the frame that was seen last."""
    book = Codebook(tiny_model, 64)
    for _ in book.grow():
        pass
    book.motions[:] = 3.0  # far from everything
    book.motions[:2] = 0.0
    book.motions[1, 4:] = 1.0
    observation = np.zeros((3 * STRIDE, 5), np.float32)
    cloud = belief_cloud(book, observation, steps=8 * STRIDE)
    assert [mode.mass for mode in cloud.modes] == pytest.approx([0.5, 0.5])
    assert {tuple(mode.pb.tolist()) for mode in cloud.modes} == {
        tuple(pb) for pb in book.pbs[:2].tolist()
    }
    assert len(belief_cloud(book, observation).modes) == 1  # of what was seen they are the same
    longer = np.zeros((6 * STRIDE, 5), np.float32)
    (mode,) = belief_cloud(book, longer, steps=8 * STRIDE).modes
    assert mode.pb.tolist() == book.pbs[0].tolist()
    assert DIFFERENT < 1.0


def test_one_explanation_at_least_whatever_comes(strong: RNNPB, book: Codebook) -> None:
    random = np.random.default_rng(0)
    cloud = belief_cloud(book, random.normal(0, 50, (200, 17)).astype(np.float32), scale=0.01)
    assert len(cloud.modes) == 1
    assert np.isfinite(cloud.weights).all()
    assert torch.isfinite(torch.as_tensor(cloud.modes[0].pb)).all()
