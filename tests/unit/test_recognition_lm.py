"""Recognition by Levenberg-Marquardt: its Jacobian, its minimum, its posterior."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from rnnpb_explorer.core import recognition_lm
from rnnpb_explorer.core.errors import Cancelled, InputError
from rnnpb_explorer.core.model import RNNPB, Behavior, ModelConfig, ModelInfo
from rnnpb_explorer.core.recognition import recognize
from rnnpb_explorer.core.recognition_lm import LMConfig, pb_jacobian, recognize_lm
from rnnpb_explorer.core.recognition_run import RecognitionConfig, RecognitionResult
from rnnpb_explorer.robot.reading import read_motion

from .cli_harness import Rnnpb

Array = NDArray[np.float32]


def a_motion(model: RNNPB, pb: list[float], noise: float = 0.0) -> Array:
    motion = model.generate(torch.tensor([pb]).to(model.mu), 30)[0].numpy()
    random = np.random.default_rng(0)
    noisy: Array = (motion + random.normal(0, noise, motion.shape)).astype(np.float32)
    return noisy


def a_model(pb_dim: int, hidden_size: int = 32, beta: float | None = 1e-3) -> RNNPB:
    """Random weights and PBs: 3 motions of 5 joints; without beta a deterministic one."""
    behavior: Behavior = "deterministic" if beta is None else "stochastic"
    config = ModelConfig(5, pb_dim, hidden_size, 3, behavior, beta)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        model = RNNPB(config, ModelInfo(joints=tuple("abcde")))
        torch.nn.init.normal_(model.mu)
    return model.eval().requires_grad_(False)


@pytest.mark.parametrize("steps", [1, 2, 12])
def test_jacobian_is_that_of_the_plain_loop(tiny_model: RNNPB, steps: int) -> None:
    model = tiny_model.double()
    jacobians = pb_jacobian(model, model.mu, steps)
    for pb, jacobian in zip(model.mu, jacobians, strict=True):
        plain = torch.autograd.functional.jacobian(
            lambda pb: model.generate_stepwise(pb, steps), pb
        )
        torch.testing.assert_close(jacobian, plain, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("pb_dim", [1, 4, 16])
def test_jacobian_in_float32_is_that_of_autograd_in_float64(pb_dim: int) -> None:
    model = a_model(pb_dim)
    jacobian = pb_jacobian(model, model.mu, 20)
    exact = model.double()
    expected = torch.autograd.functional.jacobian(
        lambda pb: exact.generate_stepwise(pb, 20), exact.mu[0]
    )
    error = torch.linalg.vector_norm(jacobian[0] - expected)
    assert error < 1e-4 * torch.linalg.vector_norm(expected)


def test_jacobian_of_a_trained_model(published_strong: RNNPB) -> None:
    pb, bump = published_strong.mu[:2], torch.tensor([0.0, 1e-2, 0.0, 0.0])
    jacobian = pb_jacobian(published_strong, pb, 120)
    ahead, behind = (published_strong.generate(pb + side, 120) for side in (bump, -bump))
    slope = (ahead - behind) / 2e-2
    assert (jacobian[..., 1] - slope).abs().max() < 0.02 * slope.abs().max()


def test_finds_the_pb_that_made_a_motion(tiny_model: RNNPB) -> None:
    pb = [0.4, -0.8, 0.9]
    target = a_motion(tiny_model, pb)
    result = RecognitionResult.from_steps(recognize_lm(tiny_model, target, LMConfig(tolerance=0)))
    assert result.best_reconstruction_loss.min() < 1e-9
    np.testing.assert_allclose(result.mu[result.best_trial, -1], pb, atol=2e-3)


def test_mu_follows_what_lowered_the_loss(tiny_model: RNNPB) -> None:
    target = a_motion(tiny_model, [1.5, 0.3, -1.2], noise=0.05)
    steps = list(recognize_lm(tiny_model, target, LMConfig(starts=2, iterations=15)))
    lowest = np.full(2, np.inf)
    for step in steps:
        output = tiny_model.generate(torch.as_tensor(step.pb), 30).numpy()
        np.testing.assert_allclose(step.output, output, atol=1e-6)
        loss = np.square(step.output[:, :24] - target[:24]).mean(axis=(1, 2))
        np.testing.assert_allclose(step.loss, loss, rtol=1e-4)
        np.testing.assert_array_equal(step.early_update, step.loss < lowest)
        lowest = np.minimum(lowest, step.loss)
        moved = step.early_update[:, None]
        np.testing.assert_array_equal(step.mu_next, np.where(moved, step.pb, step.mu))
    assert lowest.min() < 0.5 * steps[0].loss.min()


def test_a_step_that_fails_is_tried_shorter(published_zero: RNNPB) -> None:
    target = published_zero.generate(torch.tensor([[3.0, -2.0, 1.0, 2.0]]), 40)[0].numpy()
    shorter = []
    for step, following in pairwise(recognize_lm(published_zero, target)):
        if step.iteration > 0:
            lengths = [np.linalg.norm(s.pb - s.mu, axis=1) for s in (step, following)]
            failed = ~step.early_update & (lengths[1] > 1e-4)  # not at its end
            shorter += list(lengths[1][failed] < lengths[0][failed])
    assert len(shorter) > 3
    assert all(shorter)


def test_damping() -> None:
    """With one dimension a step is -J r / (J J (1 + damping)), which gives the damping away."""
    model = a_model(1)
    model.weight_hidden *= 6  # far from linear: some steps fail
    target = a_motion(model, [-2.0], noise=0.3)
    dampings, expected, damping = [], [], 0.1
    for step, following in pairwise(recognize_lm(model, target, LMConfig(3, 1.0, 6, tolerance=0))):
        if step.iteration > 0:
            damping = damping * np.where(step.early_update, 0.2, 5.0)
        mu = torch.as_tensor(step.mu_next)
        jacobian = pb_jacobian(model, mu, 30).double().flatten(1).numpy()
        residual = (model.generate(mu, 30).numpy() - target).reshape(3, -1)
        gauss_newton = -(jacobian * residual).sum(axis=1) / np.square(jacobian).sum(axis=1)
        taken = (following.pb - following.mu)[:, 0]
        longer = abs(taken) > 1e-3  # shorter ones are rounded too coarsely to tell
        dampings += list((gauss_newton / taken - 1)[longer])
        expected += list(np.broadcast_to(damping, 3)[longer])
    np.testing.assert_allclose(dampings, expected, rtol=0.05, atol=2e-3)
    rounded = {round(value, 3) for value in expected}
    assert {0.1, 0.02, 0.5} <= rounded  # the first, after a step that helped, and one that did not


def test_starts_from_the_closest_learned_mu(tiny_model: RNNPB) -> None:
    target = a_motion(tiny_model, tiny_model.mu[2].tolist(), noise=0.01)
    first = next(recognize_lm(tiny_model, target, LMConfig(starts=2)))
    assert first.mu.shape == (2, 3)
    np.testing.assert_array_equal(first.mu[0], tiny_model.mu[2].numpy())
    assert first.loss[0] < first.loss[1]
    many = next(recognize_lm(tiny_model, target, LMConfig(starts=99)))
    assert many.mu.shape == (3, 3)


def test_sigma_is_that_of_the_linear_gaussian_posterior(tiny_model: RNNPB) -> None:
    target = a_motion(tiny_model, [0.4, -0.8, 0.9], noise=0.05)
    steps = list(recognize_lm(tiny_model, target))
    np.testing.assert_array_equal(steps[0].sigma, np.ones((3, 3)))  # before: the prior's
    result = RecognitionResult.from_steps(iter(steps))
    best = result.best_trial
    mu = torch.as_tensor(result.mu[best, -1:]).double()
    jacobian = pb_jacobian(tiny_model.double(), mu, 24)[0].flatten(0, 1).numpy()
    precision = jacobian.T @ jacobian / result.best_reconstruction_loss[best] + np.eye(3)
    expected = np.sqrt(np.diag(np.linalg.inv(precision)))
    np.testing.assert_allclose(result.sigma[best, -1], expected, rtol=1e-3)
    assert (expected < 0.9).all()


@pytest.mark.parametrize("beta", [0.0, None], ids=["zero", "deterministic"])
def test_no_prior_where_the_model_was_trained_without(beta: float | None) -> None:
    model = a_model(3, beta=beta)
    target = a_motion(model, [0.4, -0.8, 0.9], noise=0.05)
    steps = list(recognize_lm(model, target))
    assert np.isposinf(steps[0].sigma).all()  # before: nothing is known
    result = RecognitionResult.from_steps(iter(steps))
    best = result.best_trial
    mu = torch.as_tensor(result.mu[best, -1:]).double()
    jacobian = pb_jacobian(model.double(), mu, 24)[0].flatten(0, 1).numpy()
    precision = jacobian.T @ jacobian / result.best_reconstruction_loss[best]
    expected = np.sqrt(np.diag(np.linalg.inv(precision)))
    np.testing.assert_allclose(result.sigma[best, -1], expected, rtol=1e-3)


@pytest.mark.parametrize("beta", [1e-3, 0.0])
def test_a_component_without_influence_stays_open(beta: float) -> None:
    model = a_model(3, beta=beta)
    model.weight_pb[:, 1] = 0
    target = a_motion(model, [0.4, -0.8, 0.9], noise=0.05)
    *_, last = recognize_lm(model, target)
    np.testing.assert_allclose(last.sigma_next[:, 1], 1.0 if beta else np.inf, rtol=1e-6)
    assert np.isfinite(last.sigma_next[:, [0, 2]]).all()


def test_cancelled_between_parts(tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recognition_lm, "PART_BYTES", 1)  # a frame a part
    target = a_motion(tiny_model, [0.4, -0.8, 0.9], noise=0.05)
    asked = 0

    def cancelled() -> bool:
        nonlocal asked
        asked += 1
        return asked == 12

    steps = recognize_lm(tiny_model, target, cancelled=cancelled)
    with pytest.raises(Cancelled):
        next(steps)  # within the first iteration: its Jacobian has 24 frames
    assert asked == 12
    asked = -10_000
    assert len(list(recognize_lm(tiny_model, target, cancelled=cancelled))) > 2


def test_cancelled_before_the_next_iteration(tiny_model: RNNPB) -> None:
    stop = False
    target = a_motion(tiny_model, [0.4, -0.8, 0.9], noise=0.05)
    steps = recognize_lm(tiny_model, target, cancelled=lambda: stop)
    next(steps)
    stop = True
    with pytest.raises(Cancelled):
        next(steps)


def test_parts_sum_to_the_whole(tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch) -> None:
    target = a_motion(tiny_model, [0.4, -0.8, 0.9], noise=0.05)
    config = LMConfig(iterations=3, tolerance=0)
    whole = list(recognize_lm(tiny_model, target, config))
    monkeypatch.setattr(recognition_lm, "PART_BYTES", 3000)  # of 9,216
    monkeypatch.setattr(recognition_lm, "ROW_BYTES", 1)  # a trial at a time
    for one, other in zip(whole, recognize_lm(tiny_model, target, config), strict=True):
        np.testing.assert_allclose(one.mu_next, other.mu_next, atol=1e-5)
        np.testing.assert_allclose(one.sigma_next, other.sigma_next, rtol=1e-4)


MEMORY = """
import resource, sys
import numpy as np, torch
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.recognition_lm import LMConfig, recognize_lm
torch.manual_seed(0)
model = RNNPB(ModelConfig(pb_dim=128), ModelInfo(joints=tuple("abcdefghijklmnopq")))
target = np.zeros((int(sys.argv[1]), 17))
list(recognize_lm(model, target[:9], LMConfig(iterations=1)))
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
list(recognize_lm(model, target, LMConfig(starts=3, iterations=1)))
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)
"""


def test_memory_is_bounded() -> None:
    """D_PB = 128, 600 frames: the hidden tangents of three trials alone are 190 MB, twice."""
    outcome = subprocess.run(
        [sys.executable, "-c", MEMORY, "600"], stdout=subprocess.PIPE, text=True, check=True
    )
    assert int(outcome.stdout) < 150


def test_as_good_as_ten_published_trials(published_zero: RNNPB, shared_dir: Path) -> None:
    """On a motion that another model generated: novel in truth."""
    folder = shared_dir / "data" / "rebl-pepper" / "generated"
    path = folder / "positive_low_LD2_128.csv"
    target = read_motion(path, published_zero.info.joints).positions[:60]
    published = recognize(published_zero, target, RecognitionConfig(trials=10, iterations=50))
    ten = RecognitionResult.from_steps(published).best_reconstruction_loss
    one = RecognitionResult.from_steps(recognize_lm(published_zero, target))
    assert one.loss.shape[1] <= 20
    assert one.best_reconstruction_loss.min() < 1.05 * ten.min()


def test_stops_where_nothing_is_gained(tiny_model: RNNPB) -> None:
    target = a_motion(tiny_model, [0.4, -0.8, 0.9], noise=0.05)
    steps = list(recognize_lm(tiny_model, target, LMConfig(iterations=500)))
    assert len(steps) < 50


@pytest.mark.parametrize("pb_dim", [1, 128])
def test_any_pb_dimension(tiny_model: RNNPB, pb_dim: int) -> None:
    config = ModelConfig(num_joints=5, pb_dim=pb_dim, hidden_size=8, num_motions=3)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        model = RNNPB(config, tiny_model.info)  # its learned mu are all 0
    target = a_motion(tiny_model, [0.4, -0.8, 0.9])
    steps = list(recognize_lm(model, target, LMConfig(iterations=5)))
    assert steps[-1].mu_next.shape == (3, pb_dim)
    assert all(np.isfinite(step.sigma_next).all() for step in steps)
    assert min(step.loss.min() for step in steps) < steps[0].loss.min()


def test_bad_input_is_refused_before_the_first_step(tiny_model: RNNPB) -> None:
    with pytest.raises(InputError, match=r"shape \(10, 4\)"):
        recognize_lm(tiny_model, np.zeros((10, 4)))
    with pytest.raises(InputError, match="starts must be at least 1"):
        LMConfig(starts=0)
    with pytest.raises(InputError, match="observed must be a share"):
        LMConfig(observed=0)


def test_as_a_command(rnnpb: Rnnpb) -> None:
    flags = ("--method", "lm", "--trials", "2", "--iterations", "9", "--out", "R.npz")
    outcome = rnnpb("recognize", "--ckpt", "tiny.pt", "data/rest.csv", *flags)
    assert outcome.code == 0, outcome.err
    target = rnnpb.target(2).positions
    steps = recognize_lm(rnnpb.model, target, LMConfig(starts=2, iterations=9))
    with np.load("R.npz") as saved:
        expected = RecognitionResult.from_steps(steps)
        np.testing.assert_allclose(saved["mu"], expected.mu, atol=1e-4)
        assert saved["best_reconstruction_loss"].min() < saved["loss"][:, 0].min()
