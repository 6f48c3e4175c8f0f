"""Reconstruction errors: the published figures, and the definition on a tiny model."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.core.codebook import complete_codebook
from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.evaluation import (
    hidden_joints,
    reconstruction,
    reconstruction_at_mean,
)
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion

from .cli_harness import Rnnpb


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


# --- hidden joints ---
def test_what_is_hidden_is_inferred_and_scored(tiny_model: RNNPB) -> None:
    """Of a model that knows these motions, each joint tells of the others."""
    motions = [
        Motion(name, tiny_model.info.joints, tiny_model.reconstruct(i, 30).numpy(), 20.0)
        for i, name in enumerate(("wave", "bow", "rest"))
    ]
    told: list[int] = []
    measured = hidden_joints(
        tiny_model, motions, [0, 1], complete_codebook(tiny_model), lambda: told.append(1)
    )
    assert len(told) == 3
    assert max(measured.seen) < 1e-4
    assert max(measured.hidden) < 1e-2
    assert max(measured.hidden_if_seen) <= max(measured.hidden) + 1e-6
    broken = [
        Motion(one.name, one.joints, one.positions + np.eye(5, dtype=np.float32)[4], 20.0)
        for one in motions
    ]
    far = hidden_joints(tiny_model, broken, [0, 1], complete_codebook(tiny_model))
    assert far.hidden[0] == pytest.approx(1 / 3, abs=0.05)  # one of three joints is off by 1
    np.testing.assert_allclose(far.seen, measured.seen, atol=1e-5)


def test_the_command_measures_hidden_joints(rnnpb: Rnnpb) -> None:
    flags = ("evaluate", "--ckpt", "tiny.pt", "--data", "data", "--task", "hidden")
    outcome = rnnpb(*flags, "--joints", "a,b", "--json", "h.json")
    assert outcome.code == 0, outcome
    (row,) = json.loads(Path("h.json").read_text())["hidden"]
    assert (row["joints"], row["motions"]) == (["a", "b"], 3)
    assert f"{row['hidden'][0]:.6f} / {row['hidden'][1]:.6f}" in outcome.out
    assert "needs --joints" in rnnpb.refuses(*flags)
    assert "none is hidden" in rnnpb.refuses(*flags, "--joints", "a,b,c,d,e")
    assert "no joint 'q'" in rnnpb.refuses(*flags, "--joints", "q")


def test_other_motions_than_novel_patterns_are_recognised(rnnpb: Rnnpb) -> None:
    flags = ("evaluate", "--ckpt", "tiny.pt", "--data", "data", "--task", "recognition")
    settings = ("--trials", 2, "--iterations", 2, "--json", "r.json")
    outcome = rnnpb(*flags, *settings, "--targets", "data")
    assert outcome.code == 0, outcome
    rows = json.loads(Path("r.json").read_text())["recognition"]
    assert [row["warm_start"] for row in rows] == ["baseline", "learned", "random", "global"]
    assert {(row["patterns"], len(row["draws"])) for row in rows} == {(3, 0)}
    assert all(row["seconds"] > 0 for row in rows)
    assert "3 given motions" in outcome.out
    Path("none").mkdir()
    assert "no file lies there" in rnnpb.refuses(*flags, "--targets", "none")
