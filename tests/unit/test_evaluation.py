"""Reconstruction errors: the published figures, and the definition on a tiny model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.evaluation import reconstruction, reconstruction_at_mean
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion


@pytest.fixture
def motions(tiny_model: RNNPB) -> list[Motion]:
    info = tiny_model.info
    random = np.random.default_rng(0)
    return [
        Motion(name, info.joints, random.normal(0, 0.3, (frames, 5)).astype(np.float32))
        for name, frames in zip(info.motions, info.lengths, strict=True)
    ]


def test_published_strong_prior_at_sigma_0(published_strong: RNNPB, dataset: Dataset) -> None:
    errors = reconstruction_at_mean(published_strong, dataset.motions)
    assert f"{errors.mean():.6f} {errors.max():.6f}" == "0.000277 0.000797"


def test_published_zero_prior_at_sigma_0(published_zero: RNNPB, dataset: Dataset) -> None:
    errors = reconstruction_at_mean(published_zero, dataset.motions)
    assert f"{errors.mean():.6f} {errors.max():.6f}" == "0.000010 0.000025"


def test_published_zero_prior_sampled(published_zero: RNNPB, dataset: Dataset) -> None:
    mean, sd = reconstruction(published_zero, dataset.motions, samples=10)
    assert f"{mean:.6f} ({sd:.6f})" == "0.000010 (0.000004)"  # Table I, D_PB = 4


def test_is_the_mean_over_frames_and_joints(tiny_model: RNNPB, motions: list[Motion]) -> None:
    errors = reconstruction_at_mean(tiny_model, motions)
    for mu, motion, error in zip(tiny_model.mu, motions, errors, strict=True):
        difference = tiny_model.generate_stepwise(mu, len(motion)).numpy() - motion.positions
        assert error == pytest.approx(np.square(difference).mean(), rel=1e-5)


def test_samples_come_from_the_learned_gaussians(tiny_model: RNNPB, motions: list[Motion]) -> None:
    mean, sd = reconstruction(tiny_model, motions, samples=40, seed=5)
    random = np.random.default_rng(5)
    errors = []
    for mu, sigma, motion in zip(tiny_model.mu, tiny_model.sigma, motions, strict=True):
        for noise in random.standard_normal((40, 3)).astype(np.float32):
            generated = tiny_model.generate_stepwise(
                mu + sigma * torch.as_tensor(noise), len(motion)
            )
            errors.append(np.square(generated.numpy() - motion.positions).mean())
    assert mean == pytest.approx(np.mean(errors), rel=1e-5)
    assert sd == pytest.approx(np.std(errors), rel=1e-4)
    assert reconstruction(tiny_model, motions, samples=40, seed=5) == (mean, sd)
    assert reconstruction(tiny_model, motions, samples=40, seed=6) != (mean, sd)


def test_deterministic_model_has_one_sample(tiny_model: RNNPB, motions: list[Motion]) -> None:
    model = RNNPB(replace(tiny_model.config, behavior="deterministic", beta=None), tiny_model.info)
    model.load_state_dict(tiny_model.state_dict())
    errors = reconstruction_at_mean(model, motions)
    mean, sd = reconstruction(model, motions)
    assert mean == pytest.approx(errors.mean())
    assert sd == pytest.approx(errors.std())


def test_other_data_than_the_model_s(tiny_model: RNNPB, motions: list[Motion]) -> None:
    with pytest.raises(InputError, match="2 motions, the model 3"):
        reconstruction_at_mean(tiny_model, motions[:2])
    wide = Motion("wide", tuple("abcdef"), np.zeros((4, 6), dtype=np.float32))
    with pytest.raises(InputError, match="'wide' has 6 joints, the model 5"):
        reconstruction(tiny_model, [wide, *motions[1:]])
    with pytest.raises(InputError, match="samples must be at least 1"):
        reconstruction(tiny_model, motions, samples=0)
