"""`rnnpb figures`: what the pictures show is what was computed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from matplotlib.collections import PathCollection, QuadMesh
from PIL import Image

from rnnpb_explorer.app.commands.figures import _load
from rnnpb_explorer.core import (
    RNNPB,
    RecognitionConfig,
    RecognitionResult,
    landscape,
    load_checkpoint,
    recognize,
    save_checkpoint,
)
from rnnpb_explorer.core.latent_map import LatentMap
from rnnpb_explorer.core.model import ModelConfig
from rnnpb_explorer.core.paper.figures.components import SAMPLES, components_figure
from rnnpb_explorer.core.paper.figures.densities import densities_figure
from rnnpb_explorer.core.paper.figures.landscapes import landscapes_figure
from rnnpb_explorer.core.paper.figures.recognition import iterations_figure, paths_figure
from rnnpb_explorer.core.paper.figures.style import write_figure

from .cli_harness import Rnnpb

NAMES = ["figure2", "figure3", "figure4_absolute", "figure4_sd", "figure5", "figure6"]


@pytest.fixture
def deterministic(tiny_model: RNNPB) -> RNNPB:
    config = ModelConfig(
        num_joints=tiny_model.config.num_joints,
        pb_dim=tiny_model.config.pb_dim,
        hidden_size=tiny_model.config.hidden_size,
        num_motions=tiny_model.config.num_motions,
        behavior="deterministic",
        beta=None,
    )
    model = RNNPB(config, tiny_model.info)
    with torch.no_grad():
        model.mu.copy_(tiny_model.mu)
    return model.requires_grad_(False)


def test_the_command_writes_every_figure_twice(rnnpb: Rnnpb) -> None:
    outcome = rnnpb(
        *("figures", "--ckpt", "tiny.pt", "--data", "data", "--iterations", 5, "--out", "pictures")
    )
    assert outcome.code == 0, outcome
    expected = [f"pictures/{name}.{suffix}" for name in NAMES for suffix in ("png", "svg")]
    assert outcome.out.split() == expected
    for path in map(Path, expected):
        if path.suffix == ".png":
            with Image.open(path) as picture:
                assert picture.width > 1400  # both columns of a page at 200 dots per inch
                assert len(picture.convert("RGB").resize((200, 200)).getcolors(40_000) or ()) > 20
        else:
            assert path.read_text().startswith("<?xml")
    assert sorted(path.name for path in Path("pictures").iterdir()) == sorted(
        Path(name).name for name in expected
    )


def test_the_same_figure_is_the_same_file(tiny_model: RNNPB, tmp_path: Path) -> None:
    for name in ("one", "two"):
        figure = densities_figure({"tiny": tiny_model}, tiny_model.info.motions[:1])
        write_figure(figure, tmp_path, name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


def test_refuses(rnnpb: Rnnpb) -> None:
    flags = ("figures", "--ckpt", "tiny.pt", "--data", "data")
    Path("a-file").write_text("")
    assert "a-file: it is no folder" in rnnpb.refuses(*flags, "--out", "a-file")
    assert "no motion 'jump'" in rnnpb.refuses(*flags, "--out", "x", "--motions", "bow,jump")
    assert "no motion 'jump'" in rnnpb.refuses(*flags, "--out", "x", "--pattern", "jump")
    assert "has the name 'tiny' already" in rnnpb.refuses(
        "figures", "--ckpt", "tiny.pt", "./tiny.pt", "--data", "data", "--out", "x"
    )
    assert not Path("x").exists()


def test_models_that_know_different_motions(rnnpb: Rnnpb) -> None:
    """A page compares what all of them know; of other joints there is nothing to compare."""
    Path("fewer").mkdir()
    for name in ("bow", "wave"):
        (Path("fewer") / f"{name}.csv").write_text((Path("data") / f"{name}.csv").read_text())
    train = ("train", "--hidden-size", 8, "--epochs", 2, "--data")
    assert rnnpb(*train, "fewer", "--out", "fewer.pt").code == 0
    flags = ("figures", "--data", "data", "--iterations", 3, "--out", "x", "--ckpt")
    for order, expected in (
        (("tiny.pt", "fewer.pt"), ["wave", "bow"]),  # in the order of the first
        (("fewer.pt", "tiny.pt"), ["bow", "wave"]),
    ):
        models, dataset = _load(order, "data", None)
        assert list(models) == [Path(name).stem for name in order]
        assert [motion.name for motion in dataset.motions] == expected
    assert rnnpb(*flags, "tiny.pt", "fewer.pt").code == 0
    said = rnnpb.refuses(*flags, "tiny.pt", "fewer.pt", "--motions", "rest")
    assert "--motions: no motion 'rest' in the data that all models know" in said

    swapped = load_checkpoint("fewer.pt")
    swapped.info.joints = tuple("edcba")
    save_checkpoint(swapped, "swapped.pt")
    said = rnnpb.refuses(*flags, "tiny.pt", "swapped.pt")
    assert "--ckpt swapped.pt: its joints, or their order, are not those of the first" in said


def test_densities(tiny_model: RNNPB, deterministic: RNNPB) -> None:
    motions = list(tiny_model.info.motions[:2])
    figure = densities_figure({"stochastic": tiny_model, "deterministic": deterministic}, motions)
    assert len(figure.axes) == 2  # one row: a deterministic model has no density
    for axes, name in zip(figure.axes, motions, strict=True):
        assert axes.get_title() == name
        index = tiny_model.motion_index(name)
        assert len(axes.lines) == tiny_model.config.pb_dim
        for line, mu, sigma in zip(
            axes.lines, tiny_model.mu[index], tiny_model.sigma[index], strict=True
        ):
            x, density = np.asarray(line.get_data())
            assert axes.get_ylim()[0] == 0.0
            assert axes.get_ylim()[1] > density.max()
            mean = np.trapezoid(x * density, x)
            assert np.trapezoid(density, x) == pytest.approx(1.0, abs=1e-3)
            assert mean == pytest.approx(mu.item(), abs=1e-3)
            deviation = np.sqrt(np.trapezoid((x - mean) ** 2 * density, x))
            assert deviation == pytest.approx(sigma.item(), rel=1e-2)


def scatters(axes: object) -> list[np.ndarray]:
    return [
        np.asarray(part.get_offsets())
        for part in axes.collections  # type: ignore[attr-defined]
        if isinstance(part, PathCollection)
    ]


def test_components(tiny_model: RNNPB, deterministic: RNNPB) -> None:
    figure = components_figure({"one": tiny_model, "two": deterministic})
    samples, learned = scatters(figure.axes[0])
    (only_learned,) = scatters(figure.axes[1])
    points = LatentMap.fit(tiny_model.mu.numpy()).points[:, :2]
    np.testing.assert_allclose(learned, points, atol=1e-6)
    np.testing.assert_allclose(only_learned, points, atol=1e-6)
    clouds = samples.reshape(len(points), SAMPLES, 2)
    reach = tiny_model.sigma.max().item()
    np.testing.assert_allclose(clouds.mean(axis=1), points, atol=5 * reach / np.sqrt(SAMPLES))
    assert {text.get_text() for text in figure.axes[0].texts} >= set(tiny_model.info.motions)


@pytest.mark.parametrize("window", ["absolute", "sd"])
def test_landscapes(rnnpb: Rnnpb, window: str) -> None:
    model, motions = rnnpb.model, [rnnpb.target(0), rnnpb.target(1)]
    figure = landscapes_figure({"tiny": model}, motions, window)  # type: ignore[arg-type]
    radius = 0.7 * float(model.mu.numpy().std(axis=0, ddof=1).mean()) if window == "sd" else 1.0
    for index, axes in enumerate(figure.axes[:2]):
        mesh = next(part for part in axes.collections if isinstance(part, QuadMesh))
        expected = landscape(
            model, motions[index].positions, model.mu[index].numpy(), radius=radius
        )
        drawn = np.asarray(mesh.get_array()).reshape(20, 20)
        np.testing.assert_allclose(drawn, expected.correlation, atol=1e-5)
        assert mesh.get_clim() == (-1.0, 1.0)
        # The colours of the paper: blue is alike, warm is opposite.
        alike, opposite = mesh.to_rgba([1.0, -1.0])
        assert alike[2] > alike[0]
        assert opposite[0] > opposite[2]
        x, y = (np.asarray(axes.lines[0].get_data())).ravel()
        assert (x, y) == pytest.approx(model.mu[index, :2].tolist(), abs=1e-6)
        assert motions[index].name in axes.get_title()


def test_iterations(rnnpb: Rnnpb) -> None:
    model, target = rnnpb.model, rnnpb.target(0)
    steps = list(recognize(model, target.positions, RecognitionConfig(iterations=6)))
    figure = iterations_figure("tiny", model, target, steps, shown=(0, 5))
    last = figure.axes[5:10]
    mu = np.stack([line.get_ydata() for line in last[1].lines], axis=1)
    sigma = np.stack([line.get_ydata() for line in last[2].lines], axis=1)
    np.testing.assert_allclose(mu, [step.mu[0] for step in steps])
    np.testing.assert_allclose(sigma, [step.sigma[0] for step in steps])
    loss, kl = (np.asarray(line.get_ydata()) for line in last[3].lines)
    np.testing.assert_allclose(loss, [step.loss[0] for step in steps])
    assert not kl.any()
    joints = len(target.joints)
    curves = [line for line in last[4].lines if len(line.get_xdata()) == len(target)]
    for joint in range(joints):
        generated, wanted = curves[2 * joint : 2 * joint + 2]
        np.testing.assert_allclose(generated.get_ydata(), steps[-1].output[0, :, joint])
        np.testing.assert_allclose(wanted.get_ydata(), target.positions[:, joint])
        assert (generated.get_linestyle(), wanted.get_linestyle()) == ("-", "--")


def test_paths(rnnpb: Rnnpb, deterministic: RNNPB) -> None:
    target = rnnpb.target(0).positions
    config = RecognitionConfig(init="baseline", iterations=6, trials=2)
    runs = {
        name: (model, RecognitionResult.from_steps(recognize(model, target, config)))
        for name, model in (("tiny", rnnpb.model), ("fixed", deterministic))
    }
    figure = paths_figure(runs)
    for row, (model, result) in enumerate(runs.values()):
        latent_map = LatentMap.fit(model.mu.numpy())
        for trial in range(2):
            axes = figure.axes[2 * row + trial]
            path = latent_map.project(result.mu[trial])[:, :2]
            np.testing.assert_allclose(np.transpose(axes.lines[0].get_data()), path, atol=1e-6)
            circles = next(
                part
                for part in axes.collections
                if isinstance(part, PathCollection) and len(part.get_sizes()) == len(path)
            )
            variance = np.square(result.sigma[trial]).mean(axis=1)
            areas = circles.get_sizes()
            np.testing.assert_allclose(areas, areas[0] * variance / max(variance[0], 1e-9))
            drawn = scatters(axes)
            samples = latent_map.project(result.pb[trial])[:, :2]
            crosses = any(np.array_equal(part, samples) for part in drawn)
            assert crosses == model.stochastic
            assert any(np.allclose(part, latent_map.points[:, :2]) for part in drawn)
