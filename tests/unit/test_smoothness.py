"""Smoothness on hand-made networks whose answers are known, and the published figures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.core import InputError, save_checkpoint
from rnnpb_explorer.core.comparison import Values, shared_pairs, smoothness
from rnnpb_explorer.core.latent_map import spread
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.recognition_lm import pb_jacobian
from rnnpb_explorer.core.smoothness import (
    jerk,
    shortest,
    shortest_pieces,
    straight,
    stretch,
    walk,
)

from .cli_harness import Rnnpb

SMALL = 1e-3  # inputs of tanh so small that it is linear
FRAMES = 12


def decoder(joints: int, pb_dim: int, hidden: int, behavior: str = "stochastic") -> RNNPB:
    """A network of zeros: its gates stand half open, its cells forget half of what they hold."""
    beta = None if behavior == "deterministic" else 1e-3
    config = ModelConfig(joints, pb_dim, hidden, 2, behavior, beta)  # type: ignore[arg-type]
    info = ModelInfo(tuple("abcdefgh"[:joints]), motions=("one", "two"), lengths=(20, 20))
    model = RNNPB(config, info).eval().requires_grad_(False)
    for parameter in model.parameters():
        parameter.zero_()
    return model


def linear(matrix: torch.Tensor) -> RNNPB:
    """A decoder whose joints are `matrix` (J, D) times the PB, times what the cells hold."""
    joints, pb_dim = matrix.shape
    model = decoder(joints, pb_dim, hidden=pb_dim)
    model.weight_pb[2 * pb_dim : 3 * pb_dim] = SMALL * torch.eye(pb_dim)  # gate g alone
    model.weight_out[:] = matrix / SMALL
    return model


MATRIX = torch.tensor([[3.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
HELD = 0.5 * (1 - 0.5 ** np.arange(1, FRAMES + 1))  # h_t of a cell whose input is 1: o = 1/2


def test_of_a_linear_decoder_the_stretch_is_its_largest_singular_value() -> None:
    singular = torch.linalg.svdvals(MATRIX.double()).numpy()
    scale = np.sqrt(np.square(HELD).mean() / 3)  # root mean square over frames and joints
    for pb in (torch.zeros(2), torch.tensor([0.5, -1.0])):
        found = stretch(linear(MATRIX), pb, FRAMES)
        assert found.largest == pytest.approx(singular[0] * scale, rel=1e-3)
        assert found.condition == pytest.approx(singular[0] / singular[1], rel=1e-3)


def test_of_a_linear_decoder_wander_cliff_and_detour_are_1() -> None:
    model, start, end = linear(MATRIX), torch.tensor([-1.0, 0.3]), torch.tensor([1.0, 0.5])
    way = walk(model, straight(start, end), FRAMES)
    assert len(way.steps) == 40
    assert way.wander == pytest.approx(1, abs=1e-3)
    assert way.cliff == pytest.approx(1, abs=1e-3)
    best = shortest(model, start, end, FRAMES)
    assert way.length / best.length == pytest.approx(1, abs=1e-3)
    change = (MATRIX @ (end - start)).numpy()
    expected = np.sqrt(np.square(change).mean() * np.square(HELD).mean())
    assert way.distance == pytest.approx(expected, rel=1e-3)


HEIGHT, STEEP, GAP, SLOPE = 2.0, 6.0, 0.5, 5.0


def wall() -> RNNPB:
    """Joints a and b are x and y; c rises where x is near 0, and less so for y above GAP."""
    model = decoder(3, 2, hidden=4)
    i, g = slice(0, 4), slice(8, 12)
    model.weight_pb[g] = torch.tensor([[SMALL, 0.0], [0.0, SMALL], [STEEP, 0.0], [STEEP, 0.0]])
    model.bias[g] = torch.tensor([0.0, 0.0, 1.5, -1.5])
    model.weight_pb[i] = torch.tensor([[0.0, 0.0], [0.0, 0.0], [0.0, -SLOPE], [0.0, -SLOPE]])
    model.bias[i] = torch.tensor([0.0, 0.0, SLOPE * GAP, SLOPE * GAP])
    model.weight_out[:] = torch.tensor(
        [[1 / SMALL, 0.0, 0.0, 0.0], [0.0, 1 / SMALL, 0.0, 0.0], [0.0, 0.0, HEIGHT, -HEIGHT]]
    )
    return model


def test_a_detour_round_a_wall() -> None:
    model, start, end = wall(), torch.tensor([-1.0, 0.0]), torch.tensor([1.0, 0.0])
    over = walk(model, straight(start, end, 200), FRAMES)
    *walks, best = (w for w in shortest_pieces(model, start, end, FRAMES) if w is not None)
    lengths = [one.length for one in (*walks, best)]
    assert lengths == sorted(lengths, reverse=True)
    # Of all ways of two straight legs, one up to the wall's end and one back, the shortest.
    legs = []
    for y in np.linspace(0, 2, 41):
        middle = torch.tensor([0.0, float(y)])
        way = torch.cat([straight(start, middle, 50)[:-1], straight(middle, end, 50)])
        legs.append(walk(model, way, FRAMES).length)
    assert min(legs) < 0.75 * over.length
    assert best.length < 1.02 * min(legs)
    unit = np.sqrt(np.square(HELD).mean() / 3)
    assert best.length > 2.0 * unit  # nothing is shorter than the plane of a and b
    assert best.pbs[:, 1].max() > GAP
    np.testing.assert_allclose(best.pbs[[0, -1]], [[-1, 0], [1, 0]], atol=1e-6)
    assert over.cliff > 2
    assert 50 < over.steepest < 150


def test_a_way_between_two_equal_motions_has_no_share() -> None:
    way = walk(linear(MATRIX), straight(torch.ones(2), torch.ones(2)), FRAMES)
    assert np.isnan(way.wander)
    assert np.isnan(way.cliff)


def test_stretch_is_of_the_jacobian(tiny_model: RNNPB) -> None:
    jacobian = pb_jacobian(tiny_model, tiny_model.mu[:1], 150)[0].double().flatten(0, 1)
    largest = torch.linalg.svdvals(jacobian)[0] / np.sqrt(150 * 5)
    found = stretch(tiny_model, tiny_model.mu[0], 150)
    assert found.largest == pytest.approx(float(largest), rel=1e-4)


def test_jerk_is_small_where_a_motion_is_smooth() -> None:
    time = np.linspace(0, 1, 100)[:, None]
    smooth = np.sin(np.pi * time) * np.ones((1, 3))
    rough = smooth + 0.01 * np.random.default_rng(0).standard_normal(smooth.shape)
    assert jerk(smooth) < jerk(rough) - 2
    assert jerk(5 * smooth) == pytest.approx(jerk(smooth))
    assert np.isnan(jerk(np.zeros((50, 3))))


def test_values_leave_out_what_is_no_number() -> None:
    values = Values.of([1.0, float("nan"), 3.0])
    assert (values.mean, values.sd, values.median) == (2.0, 1.0, 2.0)
    assert np.isnan(Values.of([float("nan")]).mean)


# --- of real models ---
def test_the_published_measures_of_the_strong_prior(published_strong: RNNPB) -> None:
    """MODEL.md: wander 2.22, stretch 1.6 at the learned mu, 13.0 half-way, over 24 pairs."""
    pairs = [("0", "40"), ("13", "65")]
    measured = smoothness(published_strong, pairs)
    assert measured.mu_sd == pytest.approx(1.24, abs=0.01)
    assert 1.3 < measured.wander.median < 3.5
    assert measured.stretch.median < 0.5 * measured.stretch_between.median
    assert measured.detour.median >= 1
    scale = spread(published_strong.mu)
    assert measured.stretch_per_sd.mean == pytest.approx(scale * measured.stretch.mean)


# --- pairs and the command ---
def test_pairs_that_all_models_know(tiny_model: RNNPB) -> None:
    other = decoder(5, 2, 4)
    other.info.joints = tiny_model.info.joints
    other.info.motions = ("bow", "wave")
    assert shared_pairs([tiny_model, other], "bow") == [("bow", "wave")]
    assert shared_pairs([tiny_model], "bow", "rest") == [("bow", "rest")]
    many = shared_pairs([tiny_model], count=9)
    assert len(many) == 9
    assert many == shared_pairs([tiny_model], count=9)
    assert all(first != second for first, second in many)
    with pytest.raises(InputError, match="no motion 'rest'"):
        shared_pairs([tiny_model, other], "bow", "rest")
    other.info.joints = tuple("vwxyz")
    with pytest.raises(InputError, match="other joints"):
        shared_pairs([tiny_model, other])


def test_the_command(rnnpb: Rnnpb) -> None:
    save_checkpoint(rnnpb.model, "other.pt")
    flags = ("compare", "--ckpt", "tiny.pt", "other.pt", "--motion", "bow", "--to", "rest")
    outcome = rnnpb(*flags, "--json", "c.json")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    told = json.loads(Path("c.json").read_text())
    assert told["pairs"] == [["bow", "rest"]]
    one, other = told["models"]
    assert one["checkpoint"] == "tiny.pt"
    assert {key: one[key] for key in one if key != "checkpoint"} == {
        key: other[key] for key in other if key != "checkpoint"
    }
    model = rnnpb.model
    way = walk(model, straight(model.mu[1], model.mu[2]))
    assert one["wander"]["mean"] == pytest.approx(way.wander, rel=1e-4)
    assert f"{way.wander:.3g}" in outcome.out
    for words in ("landscape ±1: roughness", "stretch half-way, ° a sd", "detour", "cliff"):
        assert words in outcome.out


def test_several_pairs(rnnpb: Rnnpb) -> None:
    outcome = rnnpb("compare", "--ckpt", "tiny.pt", "--pairs", 3, "--json", "c.json")
    assert outcome.code == 0, outcome
    assert len(json.loads(Path("c.json").read_text())["pairs"]) == 3
    assert "3 pairs of motions: median (mean, sd)" in outcome.out


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--motion nod", "no motion 'nod'"),
        ("--to bow", "--to needs --motion"),
        ("--pairs 0", "argument --pairs: must be from 1"),
        ("--ckpt none.pt", "none.pt"),
    ],
)
def test_bad_input(rnnpb: Rnnpb, flags: str, words: str) -> None:
    assert words in rnnpb.refuses("compare", "--ckpt", "tiny.pt", *flags.split())
