"""A part of the body, and the KL term: in both procedures."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from rnnpb_explorer.core import InputError, RecognitionConfig, recognize
from rnnpb_explorer.core.codebook import complete_codebook
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo, gaussian_kl, kl_divergence
from rnnpb_explorer.core.observation import Observation
from rnnpb_explorer.core.recognition_lm import (
    LMConfig,
    pb_jacobian,
    posterior_pieces,
    recognize_lm,
    starts_for,
)
from rnnpb_explorer.core.recognition_run import Posterior, RecognitionResult, RecognitionStep

JOINTS = (0, 2, 3)


def target_of(model: RNNPB, noise: float = 0.05) -> NDArray[np.float32]:
    motion = model.reconstruct(1, 30).numpy()
    random = np.random.default_rng(0)
    made: NDArray[np.float32] = (motion + random.normal(0, noise, motion.shape)).astype(np.float32)
    return made


def steps_of(
    model: RNNPB, target: NDArray[np.float32], how: str, **options: object
) -> list[RecognitionStep]:
    if how == "paper":
        config = RecognitionConfig(iterations=15, trials=2, **options)  # type: ignore[arg-type]
        return list(recognize(model, target, config))
    return list(recognize_lm(model, target, LMConfig(**options)))  # type: ignore[arg-type]


@pytest.mark.parametrize("how", ["paper", "lm"])
def test_joints_that_are_not_observed_do_not_matter(tiny_model: RNNPB, how: str) -> None:
    target = target_of(tiny_model)
    other = target.copy()
    other[:, [1, 4]] = 7.0
    one, same = (steps_of(tiny_model, each, how, joints=JOINTS) for each in (target, other))
    np.testing.assert_array_equal(one[-1].mu, same[-1].mu)
    np.testing.assert_array_equal(one[-1].prediction_error, same[-1].prediction_error)
    seen = np.square(one[3].output - target)[:, :24, JOINTS].mean(axis=(1, 2))
    np.testing.assert_allclose(one[3].loss, seen, rtol=1e-5)
    whole = steps_of(tiny_model, target, how)
    assert not np.array_equal(whole[-1].mu, one[-1].mu)


@pytest.mark.parametrize("how", ["paper", "lm"])
def test_the_kl_term_pulls_towards_the_prior(tiny_model: RNNPB, how: str) -> None:
    target = target_of(tiny_model)
    free, held = (steps_of(tiny_model, target, how, beta=beta)[-1] for beta in (0.0, 10.0))
    assert np.linalg.norm(held.mu_next, axis=1).max() < np.linalg.norm(free.mu_next, axis=1).min()


def test_with_it_the_published_procedure_descends_its_gradient(tiny_model: RNNPB) -> None:
    """The first step that is no early update is Adam's: 0.1 against the gradient's sign."""
    model, target, beta = tiny_model, target_of(tiny_model, 1.0), 2.0
    config = RecognitionConfig(init="baseline", iterations=1, beta=beta, threshold=1e-9)
    (step,) = recognize(model, target, config)
    noise = np.random.default_rng([0, 0]).standard_normal((1, 3))[0]
    mu = torch.zeros(3, dtype=torch.float64, requires_grad=True)
    log_var = torch.zeros(3, dtype=torch.float64, requires_grad=True)
    double = model.double()
    pb = mu + (log_var / 2).exp() * torch.as_tensor(noise)
    output = double.generate(pb[None], 30)[0, :24]
    error = (output - torch.as_tensor(target[:24]).double()).square().sum(dim=1).mean()
    ((error + beta * kl_divergence(mu, log_var)) / 5).backward()
    assert mu.grad is not None
    assert log_var.grad is not None
    np.testing.assert_allclose(step.mu_next[0], -0.1 * mu.grad.sign(), atol=1e-4)
    expected = (-0.1 * log_var.grad.sign() / 2).exp()
    np.testing.assert_allclose(step.sigma_next[0], expected, atol=1e-4)


def test_with_it_levenberg_marquardt_ends_at_the_minimum_of_both(tiny_model: RNNPB) -> None:
    model, target, beta = tiny_model, target_of(tiny_model), 0.5
    config = LMConfig(starts=1, iterations=60, tolerance=1e-9, beta=beta)
    *_, end = recognize_lm(model, target, config)
    mu = torch.tensor(end.mu_next[0], requires_grad=True)
    output = model.generate(mu[None], 30)[0, :24]
    error = (output - torch.as_tensor(target[:24])).square().mean()
    (error + beta / 5 * mu.square().sum() / 2).backward()
    assert mu.grad is not None
    assert mu.grad.abs().max() < 1e-3


@pytest.mark.parametrize("how", ["paper", "lm"])
def test_without_sigma_there_is_no_kl_term(how: str) -> None:
    config = ModelConfig(5, 3, 16, 2, "deterministic", None)
    model = RNNPB(config, ModelInfo(joints=tuple("abcde"))).eval().requires_grad_(False)
    with pytest.raises(InputError, match="no KL term"):
        steps_of(model, np.zeros((20, 5), np.float32), how, beta=1e-3)


def test_kl_of_a_gaussian_is_that_of_the_loss() -> None:
    mu, sigma = torch.randn(4, 3), torch.rand(4, 3) + 0.1
    whole = kl_divergence(mu, 2 * sigma.log())
    torch.testing.assert_close(gaussian_kl(mu, sigma).sum(), whole)


@pytest.mark.parametrize("joints", [(5,), (-1,), (0, 99)])
def test_a_joint_that_is_not_there(tiny_model: RNNPB, joints: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="the model has the joints 0 to 4"):
        Observation.of(tiny_model, np.zeros((20, 5)), joints=joints)


# --- the posterior ---
def posterior(model: RNNPB, pb: torch.Tensor, seen: Observation) -> Posterior:
    *_, belief = posterior_pieces(model, pb, seen)
    assert isinstance(belief, Posterior)
    return belief


def test_the_posterior_is_that_of_the_linear_model(tiny_model: RNNPB) -> None:
    target = target_of(tiny_model)
    seen = Observation.of(tiny_model, target, 0.8, JOINTS)
    belief = posterior(tiny_model, tiny_model.mu[1], seen)
    jacobian = pb_jacobian(tiny_model, tiny_model.mu[1:2], 30)[0].double()
    flat = jacobian[:24, list(JOINTS)].flatten(0, 1)
    loss = float(seen.losses_of(tiny_model, tiny_model.mu[1:2]))
    expected = torch.linalg.inv(flat.T @ flat / loss + torch.eye(3))
    np.testing.assert_allclose(belief.covariance, expected, rtol=1e-4)
    np.testing.assert_allclose(belief.sigma, expected.diagonal().sqrt(), rtol=1e-4)
    spread = torch.einsum("tjd,de,tje->tj", jacobian, expected, jacobian).sqrt()
    np.testing.assert_allclose(belief.deviation, spread, rtol=1e-3, atol=1e-7)


def test_what_nothing_determines_stays_wide_and_finite() -> None:
    config = ModelConfig(5, 3, 16, 2, "deterministic", None)
    model = RNNPB(config, ModelInfo(joints=tuple("abcde"))).eval().requires_grad_(False)
    model.weight_pb[:, 2] = 0.0  # this component moves nothing
    seen = Observation.of(model, np.zeros((20, 5)))
    belief = posterior(model, model.mu[0], seen)
    assert belief.sigma[2] > 100 * belief.sigma[:2].max()
    assert np.isfinite(belief.covariance).all()
    assert np.isfinite(belief.deviation).all()


# --- the global search ---
def test_the_codebook_finds_what_the_learned_mu_miss(strong: RNNPB) -> None:
    """A motion from a PB far from all learned ones."""
    pb = strong.mu.mean(dim=0) + 2.2 * strong.mu.std(dim=0) * torch.tensor([1.0, -1.0, 1.0, 1.0])
    target = strong.generate(pb[None], 100)[0].numpy()
    book = complete_codebook(strong, 4096)
    local = RecognitionResult.from_steps(recognize_lm(strong, target, LMConfig(starts=1)))
    steps = recognize_lm(strong, target, LMConfig(starts=4), codebook=book)
    found = RecognitionResult.from_steps(steps)
    assert found.best_reconstruction_loss.min() < 0.5 * local.best_reconstruction_loss.min()
    assert found.explained.max() > 0.95


@pytest.mark.parametrize(("pb_dim", "starts"), [(1, 8), (4, 8), (8, 8), (16, 4), (64, 1), (128, 1)])
def test_more_dimensions_have_fewer_starts(pb_dim: int, starts: int) -> None:
    config = ModelConfig(num_joints=1, pb_dim=pb_dim, hidden_size=4, num_motions=1)
    assert starts_for(RNNPB(config, ModelInfo(joints=("a",))), 8) == starts


def test_iterations_used_and_explained(tiny_model: RNNPB) -> None:
    target = target_of(tiny_model)
    steps = list(recognize_lm(tiny_model, target, LMConfig(starts=3, iterations=40)))
    result = RecognitionResult.from_steps(steps)
    for trial, used in enumerate(result.iterations_used):
        pb = result.pb[trial]
        assert (pb[used - 1 :] == pb[used - 1]).all()
        assert used == 1 or (pb[used - 2] != pb[used - 1]).any()
    variance = np.square(target[:24] - target[:24].mean(axis=0)).mean()
    expected = 1 - result.best_reconstruction_loss / variance
    np.testing.assert_allclose(result.explained, expected, rtol=1e-4)
    best = result.of_best_trial()
    assert best.loss.shape == (1, len(steps))
    assert best.reconstruction_loss == best.best_reconstruction_loss == result.loss.min()
