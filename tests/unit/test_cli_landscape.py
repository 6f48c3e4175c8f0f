"""`rnnpb landscape` and `rnnpb recognize`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rnnpb_explorer.core import (
    RNNPB,
    Landscape,
    RecognitionConfig,
    RecognitionResult,
    landscape,
    recognize,
    save_checkpoint,
    write_motion,
)
from rnnpb_explorer.core.latent_map import LatentMap, spread
from rnnpb_explorer.core.model import ModelConfig, ModelInfo
from rnnpb_explorer.core.paper.figures.landscapes import draw_landscape

from .cli_harness import Rnnpb

BOW = ("landscape", "--ckpt", "tiny.pt", "--motion", "bow", "--grid", 4)


def npz(rnnpb: Rnnpb, *flags: object) -> dict[str, np.ndarray]:
    outcome = rnnpb(*flags)
    assert outcome.code == 0, outcome
    with np.load(flags[-1]) as file:  # type: ignore[call-overload]
        return dict(file)


def test_landscape_npz(rnnpb: Rnnpb) -> None:
    target = rnnpb.target(1)
    write_motion(target, "other-name.csv")
    result = npz(rnnpb, *BOW, "--target", "other-name.csv", "--axes", "3,1", "--out", "L.npz")
    expected = landscape(
        rnnpb.model, target.positions, rnnpb.model.mu[1].numpy(), axes=(2, 0), grid=4
    )
    np.testing.assert_allclose(result["correlation"], expected.correlation, atol=1e-5)
    mu = rnnpb.model.mu[1].tolist()
    np.testing.assert_allclose(result["x"], np.linspace(mu[2] - 1, mu[2] + 1, 4), atol=1e-6)
    np.testing.assert_allclose(result["y"], np.linspace(mu[0] - 1, mu[0] + 1, 4), atol=1e-6)
    for name in ("mean", "area", "roughness"):
        assert result[name] == pytest.approx(getattr(expected, name), abs=1e-5)
    out = rnnpb(*BOW, "--target", "other-name.csv", "--axes", "3,1", "--out", "L.npz").out
    assert f"mean {expected.mean:.4f}" in out


def test_the_name_of_a_landscape_may_be_written_large(rnnpb: Rnnpb) -> None:
    npz(rnnpb, *BOW, "--out", "L.NPZ")
    assert [path.name for path in Path().glob("*L*")] == ["L.NPZ"]


def test_landscape_on_principal_components(rnnpb: Rnnpb) -> None:
    result = npz(rnnpb, *BOW, "--axes", "pca", "--radius", "0.5sd", "--out", "L.npz")
    latent_map = LatentMap.fit(rnnpb.model.mu.numpy())
    middle, reach = latent_map.points[1], 0.5 * spread(rnnpb.model.mu.numpy())
    for k, axis in enumerate(("x", "y")):
        ends = [middle[k] - reach, middle[k] + reach]
        np.testing.assert_allclose(result[axis][[0, -1]], ends, atol=1e-5)


def test_what_the_landscape_compares_with(rnnpb: Rnnpb) -> None:
    """A file before the data, the data before the model's own reconstruction, and that is said."""
    own = rnnpb(*BOW, "--out", "L.npz")
    assert own.err == "no --target and no --data: the model's own reconstruction is the target\n"
    with_data = npz(rnnpb, *BOW, "--data", "data", "--out", "L.npz")["correlation"]
    write_motion(rnnpb.target(2), "rest.csv")
    with_both = npz(rnnpb, *BOW, "--data", "data", "--target", "rest.csv", "--out", "L.npz")[
        "correlation"
    ]
    model, mu = rnnpb.model, rnnpb.model.mu[1].numpy()
    for result, index in ((with_data, 1), (with_both, 2)):
        expected = landscape(model, rnnpb.target(index).positions, mu, grid=4).correlation
        np.testing.assert_allclose(result, expected, atol=1e-5)


def test_landscape_picture(rnnpb: Rnnpb) -> None:
    assert rnnpb(*BOW, "--out", "L.png").code == 0
    with Image.open("L.png") as picture:
        picture.load()
        colors = picture.convert("RGB").getcolors(maxcolors=1 << 24)
    assert picture.format == "PNG"
    assert picture.size[0] > 600
    shown = {color for _, color in colors or ()}
    assert (5, 48, 97) in shown  # the dark blue of +1 at the end of the scale
    assert (103, 0, 31) in shown  # the dark red of -1


@pytest.mark.parametrize(
    ("value", "color"), [(-1.0, (103, 0, 31)), (0.0, (246, 247, 247)), (1.0, (5, 48, 97))]
)
def test_colors_mean_the_same_in_every_picture(
    tmp_path: Path, value: float, color: tuple[int, int, int]
) -> None:
    """Red is -1, white 0, blue 1, whatever the values of one landscape are."""
    correlation = np.full((3, 3), value, dtype=np.float32)
    axis = np.linspace(-1.0, 1.0, 3)
    draw_landscape(Landscape(correlation, axis, axis), tmp_path / "L.png", "x", ["a", "b"])
    with Image.open(tmp_path / "L.png") as picture:
        colors = picture.convert("RGB").getcolors(maxcolors=1 << 24) or []
    most = sorted(colors, reverse=True)[:2]  # the cells, and the white around them
    assert color in [shown for _, shown in most]


def test_one_dimension(rnnpb: Rnnpb) -> None:
    config = ModelConfig(num_joints=2, pb_dim=1, hidden_size=8, num_motions=2)
    save_checkpoint(RNNPB(config, ModelInfo(joints=("a", "b"))), "one.pt")
    flags = ("landscape", "--ckpt", "one.pt", "--motion", 0, "--radius", 2, "--grid", 5)
    for axes in (("--axes", "1"), (), ("--axes", "pca")):
        result = npz(rnnpb, *flags, *axes, "--out", "L.npz")
        assert result["correlation"].shape == (1, 5)
        assert result["y"].tolist() == [0.0]
    assert rnnpb(*flags, "--out", "L.png").code == 0


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--motion jump", "no motion 'jump'"),
        ("--axes 1,4", "--axes 1,4: this PB has 3 components"),
        ("--axes 2", "--axes needs two numbers, as in 1,2, got 2"),
        ("--axes 1,1", "argument --axes: must be two different numbers or pca, got 1,1"),
        ("--axes 1,2,3", "must be two different numbers"),
        ("--axes 0,1", "argument --axes: must be from 1 to 128, got 0"),
        ("--axes xy", "argument --axes: 'xy' is no whole number"),
        ("--radius 0", "argument --radius: must be above 0"),
        ("--radius -1", "argument --radius: must be above 0"),
        ("--radius infsd", "argument --radius: must be finite"),
        ("--grid 1", "argument --grid: must be from 2 to 200"),
        ("--target none.csv", "cannot read none.csv: No such file"),
        ("--target tiny.pt", "tiny.pt seems to be a model, not a motion"),
        ("--out L.jpg", "a landscape is written as .npz or .png"),
        ("--out data", "a landscape is written as"),
    ],
)
def test_landscape_refuses(rnnpb: Rnnpb, flags: str, words: str) -> None:
    assert words in rnnpb.refuses(*BOW, "--out", "L.npz", *flags.split())
    assert not list(Path().glob("L*"))


# recognize

RECOGNIZE = ("recognize", "--ckpt", "tiny.pt", "data/rest.csv")


@pytest.mark.parametrize("init", ["baseline", "learned", "random"])
def test_recognize_npz(rnnpb: Rnnpb, init: str) -> None:
    flags = (*RECOGNIZE, "--init", init, "--trials", 2, "--iterations", 5, "--candidates", 7)
    result = npz(rnnpb, *flags, "--observed", 0.5, "--seed", 3, "--out", "R.npz")
    config = RecognitionConfig(
        init=init,  # type: ignore[arg-type]
        candidates=7,
        observed=0.5,
        iterations=5,
        trials=2,
        seed=3,
    )
    expected = RecognitionResult.from_steps(
        recognize(rnnpb.model, rnnpb.target(2).positions, config)
    )
    assert result["mu"].shape == result["sigma"].shape == (2, 6, 3)
    assert result["pb"].shape == (2, 5, 3)
    assert result["loss"].shape == result["early_update"].shape == (2, 5)
    assert result["early_update"].dtype == bool
    assert result["output"].shape == (2, 15, 5)
    for name in ("reconstruction_loss", "prediction_error"):
        for prefix in ("", "best_"):
            assert result[prefix + name].shape == (2,)
    for name, values in result.items():
        np.testing.assert_allclose(values, getattr(expected, name), atol=1e-5, err_msg=name)


def test_recognize_says_what_came_out(rnnpb: Rnnpb) -> None:
    flags = (*RECOGNIZE, "--method", "paper", "--trials", 3, "--iterations", 4)
    result = npz(rnnpb, *flags, "--out", "R.npz")
    outcome = rnnpb(*flags, "--out", "R.npz")
    assert outcome.err == ""
    last = result["reconstruction_loss"].mean()
    best = result["best_reconstruction_loss"]
    for words in (f"last iterate {last:.6f}", f"best iterate {best.mean():.6f}"):
        assert words in outcome.out
    assert f"best trial {best.min():.6f}" in outcome.out


def test_the_best_trial_is_chosen_by_what_was_observed(rnnpb: Rnnpb) -> None:
    """Which trial foretells best shows only in frames that were not observed."""
    flags = (*RECOGNIZE, "--trials", 6, "--iterations", 4, "--observed", 0.4, "--init", "random")
    result = npz(rnnpb, *flags, "--out", "R.npz")
    chosen = result["best_reconstruction_loss"].argmin()
    foretold = result["best_prediction_error"]
    assert foretold[chosen] > foretold.min()  # or this would show nothing
    said = rnnpb(*flags, "--out", "R.npz").out.splitlines()
    assert said[-2].startswith("prediction error: ")
    assert said[-2].endswith(f"best trial {foretold[chosen]:.6f}")


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--init warm", "argument --init: invalid choice: 'warm'"),
        ("--observed 0", "argument --observed: must be above 0 and at most 1"),
        ("--observed 1.5", "argument --observed: must be above 0 and at most 1"),
        ("--observed 0.01", "0.01 of 15 frames leaves none to observe"),
        ("--iterations 0", "argument --iterations: must be from 1"),
        ("--trials 0", "argument --trials: must be from 1"),
        ("--candidates 0", "argument --candidates: must be from 1"),
        ("--method magic", "argument --method: invalid choice: 'magic'"),
        ("--method lm --init learned", "--init is a matter of --method paper, not of lm"),
        ("--joints a,shoulder", "--joints: no joint 'shoulder'; there are: a, b, c, d, e"),
        ("--beta -1", "argument --beta: must be at least 0"),
        ("--out R.csv", "the name of a result ends in .npz"),
    ],
)
def test_recognize_refuses(rnnpb: Rnnpb, flags: str, words: str) -> None:
    assert words in rnnpb.refuses(*RECOGNIZE, "--out", "R.npz", *flags.split())
    assert not list(Path().glob("R*"))


def test_recognize_refuses_a_bad_motion(rnnpb: Rnnpb) -> None:
    Path("bad.csv").write_text("a,b,c,d\n1,2,3,4\n1,2,3,4\n")
    said = rnnpb.refuses("recognize", "--ckpt", "tiny.pt", "bad.csv", "--out", "R.npz")
    assert said == "rnnpb recognize: bad.csv has no column for e"
