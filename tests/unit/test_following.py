"""Recognition frame by frame: Bayes' rule at a fixed linearisation, and what goes on beside it."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from rnnpb_explorer.core import RNNPB, InputError
from rnnpb_explorer.core.codebook import Codebook, complete_codebook
from rnnpb_explorer.core.following import Followed, Follower
from rnnpb_explorer.core.recognition_lm import pb_jacobian

Array = NDArray[np.float32]


@pytest.fixture(scope="module")
def book(strong: RNNPB) -> Codebook:
    return complete_codebook(strong, 512)


@pytest.fixture(scope="module")
def motion(strong: RNNPB) -> Array:
    """Between two learned motions, with a little noise."""
    pb = (strong.mu[3:4] + strong.mu[10:11]) / 2
    made = strong.generate(pb, 120)[0].numpy()
    noise = np.random.default_rng(0).normal(0, 0.01, made.shape)
    noisy: Array = (made + noise).astype(np.float32)
    return noisy


def followed(follower: Follower, motion: Array, *, work: bool = True) -> Iterator[Followed]:
    """Every frame, with all that is to be done beside in between."""
    for frame in motion:
        yield follower.update(frame)
        while work and follower.work():
            pass


def test_it_finds_a_motion_between_two_and_foretells_the_rest(
    strong: RNNPB, book: Codebook, motion: Array
) -> None:
    follower = Follower(strong, codebook=book, beside=False, horizon=120)
    *_, half = followed(follower, motion[:60])
    assert half.frame == 59
    assert half.foretold.shape == (120, 17)
    assert np.sqrt(np.square(half.foretold - motion).mean()) < 0.03
    assert half.explained is not None
    assert half.explained > 0.9
    *_, end = followed(follower, motion[60:])
    middle = ((strong.mu[3] + strong.mu[10]) / 2).numpy()
    np.testing.assert_allclose(end.mu, middle, atol=5 * end.sigma.max() + 0.02)
    assert (end.sigma < half.sigma).all()
    assert end.loss == pytest.approx(1e-4, rel=0.2)
    assert end.milliseconds > 0


def test_at_one_linearisation_it_is_the_gaussian_posterior(strong: RNNPB, book: Codebook) -> None:
    """Against the plain normal equations of all frames, with the prior's pull."""
    near = strong.mu[3:4] + 0.02  # a step that is short enough to be a good one
    motion = strong.generate(near, 40)[0].numpy()
    follower = Follower(strong, codebook=book, beside=False, horizon=40)
    *_, last = followed(follower, motion, work=False)  # nothing is linearised anew
    start = book.pbs[int(book.frame_errors(motion[:1]).argmin())]
    jacobian = pb_jacobian(strong, start[None], 40)[0].double().flatten(0, 1)
    output = strong.generate(start[None], 40)[0].double()
    residual = (output - torch.as_tensor(motion).double()).flatten()
    mu = strong.mu.double()
    hold = torch.linalg.inv(torch.cov(mu.T) * 1.5**2) * 0.1**2
    normal = jacobian.T @ jacobian + hold
    down = jacobian.T @ residual + hold @ (start.double() - mu.mean(dim=0))
    expected = start.double() - torch.linalg.solve(normal, down)
    assert last.loss < float(residual.square().mean())  # or it would stay where it began
    np.testing.assert_allclose(last.mu, expected, rtol=1e-4, atol=1e-5)
    spread = torch.linalg.inv(jacobian.T @ jacobian / last.loss + hold / 0.1**2)
    np.testing.assert_allclose(last.covariance, spread, rtol=1e-3, atol=1e-9)


def test_the_thread_beside_does_the_same(strong: RNNPB, book: Codebook, motion: Array) -> None:
    with Follower(strong, codebook=book, horizon=120) as follower:
        for frame in motion[:-1]:
            before = follower.update(frame)
        deadline = time.monotonic() + 20
        while follower._fresh is None:  # it linearises without being asked to
            assert time.monotonic() < deadline
            time.sleep(0.001)
        last = follower.update(motion[-1])
        assert last.loss < 1.1 * before.loss
        assert last.explained is not None
        assert last.explained > 0.9
    assert not follower._thread.is_alive()  # type: ignore[union-attr]


def test_joints_that_are_not_observed_may_hold_anything(
    strong: RNNPB, book: Codebook, motion: Array
) -> None:
    ends = []
    for broken in (motion, np.where(np.arange(17) < 8, motion, np.nan)):
        follower = Follower(strong, codebook=book, joints=range(8), beside=False, horizon=120)
        *_, end = followed(follower, broken.astype(np.float32)[:30])
        ends.append(end)
    np.testing.assert_array_equal(ends[0].mu, ends[1].mu)
    np.testing.assert_array_equal(ends[0].foretold, ends[1].foretold)


def test_a_motion_longer_than_the_horizon(strong: RNNPB, book: Codebook, motion: Array) -> None:
    follower = Follower(strong, codebook=book, beside=False, horizon=30)
    *_, end = followed(follower, motion)
    assert end.foretold.shape[0] >= 120
    assert end.loss < 2e-4


def test_belief_over_the_codebook(strong: RNNPB, book: Codebook) -> None:
    follower = Follower(strong, codebook=book, beside=False)
    list(followed(follower, strong.reconstruct(7, 60).numpy(), work=False))
    shares = follower.shares()
    assert shares.sum() == pytest.approx(1)
    assert int(shares.argmax()) == 7


@pytest.mark.parametrize(
    "frame", [np.zeros(4), np.zeros((1, 17)), np.full(17, np.nan), np.full(17, np.inf)]
)
def test_a_frame_that_is_none(strong: RNNPB, book: Codebook, frame: Array) -> None:
    follower = Follower(strong, codebook=book, beside=False)
    with pytest.raises(InputError):
        follower.update(frame)


def test_a_model_of_any_size(tiny_model: RNNPB) -> None:
    """Among its own motions, where no codebook is given; one and many dimensions."""
    target = tiny_model.reconstruct(1, 30).numpy()
    follower = Follower(tiny_model, beside=False, horizon=30)
    *_, end = followed(follower, target)
    np.testing.assert_allclose(end.mu, tiny_model.mu[1].numpy(), atol=0.05)
