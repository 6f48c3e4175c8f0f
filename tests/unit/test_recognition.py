"""Recognition against a plain statement of the published procedure, and its promises."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path
from threading import Event

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.errors import Cancelled, InputError
from rnnpb_explorer.core.model import RNNPB, ModelConfig
from rnnpb_explorer.core.recognition import recognize
from rnnpb_explorer.core.recognition_run import (
    RecognitionConfig,
    RecognitionResult,
    RecognitionStep,
)

Array = NDArray[np.float32]


def plain_recognition(
    model: RNNPB, target: Array, config: RecognitionConfig
) -> list[tuple[float, bool, Tensor, Tensor]]:
    """(loss, early update, mu, sigma after it) of one trial: loops, torch's Adam, LSTMCell."""
    motion = torch.as_tensor(target).to(model.mu)
    observed = int(config.observed * len(motion))
    pb_dim = model.config.pb_dim
    stream = np.random.default_rng([config.seed, config.first_trial])

    def loss_of(output: Tensor) -> Tensor:
        return torch.nn.functional.mse_loss(output[:observed], motion[:observed])

    candidates = [torch.zeros_like(model.mu[0])]
    if config.init == "learned":
        candidates = list(model.mu)
    elif config.init == "random":
        draws = 3.0 * stream.standard_normal((config.candidates, pb_dim))
        candidates = [torch.as_tensor(draw) for draw in draws]
    mu = min(candidates, key=lambda mu: loss_of(model.generate_stepwise(mu, observed)).item())
    mu = mu.to(model.mu).clone().requires_grad_()
    log_var = torch.zeros_like(mu).requires_grad_()
    adam = torch.optim.Adam([mu, log_var], lr=config.learning_rate)

    steps = []
    lowest = config.threshold
    for noise in torch.as_tensor(stream.standard_normal((config.iterations, pb_dim))):
        pb = mu
        if model.stochastic:
            pb = mu + torch.exp(0.5 * log_var) * noise.to(mu)
        loss = loss_of(model.generate_stepwise(pb, len(motion)))
        early = loss.item() < lowest
        if early:
            lowest = loss.item()
            mu.data = pb.detach().clone()
        else:
            adam.zero_grad()
            loss.backward()
            adam.step()
        sigma = torch.exp(0.5 * log_var) if model.stochastic else torch.zeros_like(mu)
        steps.append((loss.item(), early, mu.detach().clone(), sigma.detach()))
    return steps


def a_motion(model: RNNPB, frames: int = 20, seed: int = 1) -> Array:
    """A motion that the model can nearly make, so that both kinds of update happen."""
    random = np.random.default_rng(seed)
    pb = torch.as_tensor(random.standard_normal((1, model.config.pb_dim))).to(model.mu)
    motion = model.generate(pb, frames)[0].numpy().astype(np.float32)
    noisy: Array = motion + random.normal(0, 0.02, motion.shape).astype(np.float32)
    return noisy


def deterministic(model: RNNPB) -> RNNPB:
    other = RNNPB(replace(model.config, behavior="deterministic", beta=None), model.info)
    other.load_state_dict(model.state_dict())
    return other.eval().requires_grad_(False)


@pytest.mark.parametrize("init", ["baseline", "learned", "random"])
@pytest.mark.parametrize("stochastic", [True, False])
def test_is_the_published_procedure(tiny_model: RNNPB, init: str, stochastic: bool) -> None:
    # In float64, where 40 iterations of both ways still agree in every decision.
    model = (tiny_model if stochastic else deterministic(tiny_model)).double()
    config = RecognitionConfig(
        init=init,  # type: ignore[arg-type]
        candidates=5,
        iterations=40,
        trials=2,
        threshold=0.02,
        seed=7,
    )
    target = a_motion(model)
    result = RecognitionResult.from_steps(recognize(model, target, config))
    for trial in range(config.trials):
        plain = plain_recognition(model, target, replace(config, first_trial=trial))
        losses, early, mu, sigma = zip(*plain, strict=True)
        np.testing.assert_allclose(result.loss[trial], losses, rtol=1e-9)
        assert result.early_update[trial].tolist() == list(early)
        np.testing.assert_allclose(result.mu[trial, 1:], torch.stack(mu).numpy(), rtol=1e-8)
        np.testing.assert_allclose(result.sigma[trial, 1:], torch.stack(sigma).numpy(), rtol=1e-8)
    assert result.early_update.any()
    assert not result.early_update.all()


def test_published_model_in_float32(published_strong: RNNPB, dataset: Dataset) -> None:
    # Rounding grows along the way; within the first iterations it cannot hide a difference.
    target = dataset.motions[3].positions[:60] + np.float32(0.1)
    config = RecognitionConfig(init="baseline", iterations=12, seed=3)
    losses = [step.loss[0] for step in recognize(published_strong, target, config)]
    plain = [step[0] for step in plain_recognition(published_strong, target, config)]
    np.testing.assert_allclose(losses, plain, rtol=1e-3)


def test_a_trial_is_the_same_alone_and_in_any_batch(tiny_model: RNNPB) -> None:
    model = tiny_model.double()
    config = RecognitionConfig(init="random", candidates=4, iterations=30, trials=4, threshold=0.02)
    target = a_motion(model)
    batch = RecognitionResult.from_steps(recognize(model, target, config))
    alone = RecognitionResult.from_steps(
        recognize(model, target, replace(config, trials=1, first_trial=2))
    )
    np.testing.assert_allclose(batch.mu[2], alone.mu[0], rtol=1e-9)
    np.testing.assert_allclose(batch.sigma[2], alone.sigma[0], rtol=1e-9)
    assert not np.allclose(batch.mu[1], alone.mu[0])


def test_the_unobserved_part_has_no_influence(tiny_model: RNNPB) -> None:
    target = a_motion(tiny_model)
    changed = target.copy()
    changed[16:] += 1  # int(0.8 * 20) frames are observed
    config = RecognitionConfig(iterations=8, trials=2)
    first = RecognitionResult.from_steps(recognize(tiny_model, target, config))
    second = RecognitionResult.from_steps(recognize(tiny_model, changed, config))
    np.testing.assert_array_equal(first.mu, second.mu)
    assert (first.prediction_error != second.prediction_error).all()
    rest = np.square(first.output[:, 16:] - target[16:]).mean(axis=(1, 2))
    np.testing.assert_allclose(first.prediction_error, rest, rtol=1e-5)


def test_fully_observed_has_no_prediction_error(tiny_model: RNNPB) -> None:
    config = RecognitionConfig(observed=1.0, iterations=2)
    result = RecognitionResult.from_steps(recognize(tiny_model, a_motion(tiny_model), config))
    assert np.isnan(result.prediction_error).all()
    assert np.isfinite(result.reconstruction_loss).all()


def test_steps_say_what_happened(tiny_model: RNNPB) -> None:
    config = RecognitionConfig(iterations=30, trials=3, threshold=0.05)
    target = a_motion(tiny_model)
    steps = list(recognize(tiny_model, target, config))
    assert [step.iteration for step in steps] == list(range(30))
    for step, following in pairwise(steps):
        np.testing.assert_array_equal(step.mu_next, following.mu)
        np.testing.assert_array_equal(step.sigma_next, following.sigma)
        early = step.early_update
        np.testing.assert_array_equal(step.mu_next[early], step.pb[early])
        np.testing.assert_array_equal(step.sigma_next[early], step.sigma[early])
        assert (step.mu_next[~early] != step.mu[~early]).all()
        motion = tiny_model.generate(torch.as_tensor(step.pb), len(target)).numpy()
        np.testing.assert_allclose(step.output, motion, atol=1e-6)


def test_can_be_stopped_and_does_not_touch_the_model(tiny_model: RNNPB) -> None:
    before = {name: value.clone() for name, value in tiny_model.state_dict().items()}
    steps = recognize(tiny_model, a_motion(tiny_model), RecognitionConfig(iterations=1000))
    assert len(list(islice(steps, 3))) == 3
    assert torch.is_grad_enabled()
    for name, value in tiny_model.state_dict().items():
        assert torch.equal(value, before[name])


@pytest.mark.parametrize(("init", "chunks"), [("random", 3), ("learned", 1)])
def test_the_warm_start_can_be_stopped_after_each_chunk(
    tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch, init: str, chunks: int
) -> None:
    """With many candidates and a long motion it takes longer than all iterations."""
    target, generate = a_motion(tiny_model), tiny_model.generate
    generated: list[int] = []

    def counted(pb: Tensor, steps: int) -> Tensor:
        generated.append(len(pb))
        return generate(pb, steps)

    monkeypatch.setattr(tiny_model, "generate", counted)
    config = RecognitionConfig(init=init, candidates=1500)  # type: ignore[arg-type]
    for most in range(chunks):
        generated.clear()
        steps = recognize(
            tiny_model, target, config, cancelled=lambda most=most: len(generated) == most
        )
        with pytest.raises(Cancelled):
            next(steps)
        assert len(generated) == most


def test_iterations_stop_when_they_are_cancelled(tiny_model: RNNPB) -> None:
    stopped = Event()
    steps = recognize(tiny_model, a_motion(tiny_model), cancelled=stopped.is_set)
    assert len(list(islice(steps, 3))) == 3
    stopped.set()
    with pytest.raises(Cancelled):
        next(steps)


def test_runs_where_gradients_are_off(tiny_model: RNNPB) -> None:
    target, config = a_motion(tiny_model), RecognitionConfig(iterations=3)
    expected = [step.loss for step in recognize(tiny_model, target, config)]
    with torch.inference_mode():
        losses = [step.loss for step in recognize(tiny_model, target, config)]
    np.testing.assert_array_equal(losses, expected)


def test_result_keeps_last_and_best(tiny_model: RNNPB, tmp_path: Path) -> None:
    config = RecognitionConfig(iterations=25, trials=3, init="baseline")
    steps = list(recognize(tiny_model, a_motion(tiny_model), config))
    result = RecognitionResult.from_steps(iter(steps))
    result.save(tmp_path / "result")
    with np.load(tmp_path / "result") as saved:
        assert saved["mu"].shape == saved["sigma"].shape == (3, 26, 3)
        assert saved["pb"].shape == (3, 25, 3)
        assert saved["early_update"].dtype == bool
        assert saved["output"].shape == (3, 20, 5)
        np.testing.assert_array_equal(saved["reconstruction_loss"], steps[-1].loss)
        np.testing.assert_array_equal(saved["best_reconstruction_loss"], saved["loss"].min(axis=1))
        for trial, best in enumerate(saved["loss"].argmin(axis=1)):
            assert saved["best_iteration"][trial] == best
            assert saved["best_prediction_error"][trial] == steps[best].prediction_error[trial]
            np.testing.assert_array_equal(saved["best_output"][trial], steps[best].output[trial])
    assert (result.best_iteration < 24).any()  # or last and best were the same thing


def test_no_step_has_no_result() -> None:
    with pytest.raises(ValueError, match="at least one step"):
        RecognitionResult.from_steps([])


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"init": "lucky"}, "init must be one of learned, baseline, random"),
        ({"iterations": 0}, "iterations must be at least 1"),
        ({"trials": 0}, "trials must be at least 1"),
        ({"seed": -1}, "seed must be at least 0"),
        ({"observed": 1.2}, "observed must be a share"),
        ({"observed": float("nan")}, "observed must be a share"),
        ({"learning_rate": 0.0}, "learning_rate must be above 0"),
    ],
)
def test_bad_settings(setting: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        RecognitionConfig(**setting)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("target", "message"),
    [
        (np.zeros((10, 4)), r"shape \(10, 4\).*\(frames, 5\)"),
        (np.zeros(5), r"shape \(5,\)"),
        (np.zeros((1, 5)), "none to observe"),
        (np.full((10, 5), np.nan), "NaN"),
    ],
)
def test_bad_targets_are_refused_before_the_first_step(
    tiny_model: RNNPB, target: Array, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        recognize(tiny_model, target)


@pytest.mark.parametrize("pb_dim", [1, 128])
def test_any_pb_dimension(tiny_model: RNNPB, pb_dim: int) -> None:
    config = ModelConfig(num_joints=5, pb_dim=pb_dim, hidden_size=8, num_motions=3)
    model = RNNPB(config, tiny_model.info)
    steps: list[RecognitionStep] = list(
        recognize(model, a_motion(tiny_model), RecognitionConfig(iterations=2, trials=2))
    )
    assert steps[-1].mu_next.shape == (2, pb_dim)
