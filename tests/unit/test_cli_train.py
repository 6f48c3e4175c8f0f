"""`rnnpb train` and `rnnpb evaluate --task reconstruction`."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

import pytest
import torch

from rnnpb_explorer.core import RNNPB, landscape, load_checkpoint
from rnnpb_explorer.core.checkpoint import read_plain
from rnnpb_explorer.core.evaluation import reconstruction, reconstruction_at_mean
from rnnpb_explorer.core.recipes import RECIPES
from rnnpb_explorer.core.training import Trainer, TrainingConfig, TrainingProgress
from rnnpb_explorer.robot import load_dataset

from .cli_harness import Outcome, Rnnpb

RECIPE = ("--pb-dim", 2, "--hidden-size", 8, "--epochs", 6, "--seed", 5)


# What is said before training starts.
LISTED = "3 motions of 9 to 15 frames at 25 Hz: bow, rest, wave\n5 joints: a, b, c, d, e\n"


def train(rnnpb: Rnnpb, *flags: object) -> Outcome:
    return rnnpb("train", "--data", "data", *flags)


def trained(rnnpb: Rnnpb, *flags: object, out: str = "C.pt") -> RNNPB:
    outcome = train(rnnpb, *flags, "--out", out)
    assert (outcome.code, outcome.err) == (0, LISTED), outcome
    return load_checkpoint(out)


def weights(model: RNNPB) -> dict[str, bytes]:
    return {name: value.numpy().tobytes() for name, value in model.state_dict().items()}


def test_the_checkpoint_and_its_record(rnnpb: Rnnpb) -> None:
    model = trained(rnnpb, *RECIPE, "--beta", "1e-4")
    config, info = model.config, model.info
    assert (config.pb_dim, config.hidden_size, config.beta) == (2, 8, 1e-4)
    assert (config.num_joints, config.num_motions, config.behavior) == (5, 3, "stochastic")
    assert info.motions == ("bow", "rest", "wave")
    assert info.lengths == (9, 15, 12)
    assert info.joints == tuple("abcde")
    dataset = load_dataset("data")
    recipe = asdict(TrainingConfig(epochs=6, seed=5))
    assert info.training.items() >= recipe.items()
    assert info.training["data_sha256"] == dataset.sha256
    assert 0 < float(info.training["seconds"]) < 600
    assert float(info.training["final_error"]) > 0
    mean, sd = reconstruction(model, dataset.motions, 100, seed=0)
    assert info.metrics["reconstruction_mean"] == pytest.approx(mean, rel=1e-4)
    assert info.metrics["reconstruction_sd"] == pytest.approx(sd, rel=1e-4)
    at_mean = reconstruction_at_mean(model, dataset.motions)
    assert info.metrics["reconstruction_at_mean"] == pytest.approx(at_mean.mean(), rel=1e-4)
    assert info.metrics["reconstruction_at_mean_worst"] == pytest.approx(at_mean.max(), rel=1e-4)
    assert sorted(path.name for path in Path().iterdir()) == ["C.pt", "data", "tiny.pt"]


def test_training_is_what_the_trainer_does(rnnpb: Rnnpb) -> None:
    model = trained(rnnpb, *RECIPE)
    trainer = Trainer(load_dataset("data"), model.config, TrainingConfig(epochs=6, seed=5))
    errors = [progress.error for progress in trainer.run()]
    assert weights(trainer.model) == weights(model)
    assert model.info.training["final_error"] == errors[-1]
    assert weights(trained(rnnpb, *RECIPE, "--seed", 6)) != weights(model)


def test_deterministic(rnnpb: Rnnpb) -> None:
    model = trained(rnnpb, *RECIPE, "--behavior", "deterministic")
    assert (model.config.behavior, model.config.beta) == ("deterministic", None)
    assert not model.sigma.any()


@pytest.mark.parametrize("name", sorted(RECIPES))
def test_a_shipped_checkpoints_recipe(rnnpb: Rnnpb, name: str) -> None:
    """The flag trains as the checkpoint of that name was; the checkpoint says so itself."""
    small = ("--pb-dim", 2, "--hidden-size", 8, "--epochs", 2)
    recipe = RECIPES[name]
    model = trained(rnnpb, "--recipe", name, *small)
    assert (model.config.behavior, model.config.beta) == (recipe.model.behavior, recipe.model.beta)
    assert model.info.training.items() >= asdict(replace(recipe.training, epochs=2)).items()
    shipped = load_checkpoint(name)
    assert shipped.info.training.items() >= asdict(recipe.training).items()
    sizes = {"num_joints": 17, "num_motions": 72}
    assert shipped.config == replace(recipe.model, **sizes)


def test_a_recipe_decides_what_is_trained(rnnpb: Rnnpb) -> None:
    flags = ("train", "--data", "data", "--recipe", "weak", "--out", "B.pt")
    assert "--beta: --recipe weak decides that" in rnnpb.refuses(*flags, "--beta", "1e-3")
    assert "--behavior: --recipe weak" in rnnpb.refuses(*flags, "--behavior", "deterministic")
    assert "--recipe: the run in --resume has its own" in rnnpb.refuses(*flags, "--resume", "x.pt")


@pytest.fixture
def ctrl_c_in_epoch_3(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Trainer.run

    def interrupted(self: Trainer) -> Iterator[TrainingProgress]:
        for progress in run(self):
            if progress.epoch == 3:
                os.kill(os.getpid(), signal.SIGINT)
            yield progress

    monkeypatch.setattr(Trainer, "run", interrupted)


def interrupt(rnnpb: Rnnpb, *flags: object) -> None:
    before = signal.getsignal(signal.SIGINT)
    outcome = train(rnnpb, *RECIPE, *flags, "--out", "B.pt")
    assert outcome.code == 130
    assert outcome.err.removeprefix(LISTED).count("\n") == 1
    assert "stopped after epoch 3 of 6; to go on: rnnpb train --data data --resume" in outcome.err
    assert "B.resume.pt --out B.pt" in outcome.err
    assert sorted(Path().glob("*B*")) == [Path("B.resume.pt")]
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_and_resume_bit_for_bit(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch, ctrl_c_in_epoch_3: None
) -> None:
    interrupt(rnnpb)
    seconds = read_plain(Path("B.resume.pt"))["resume"]["seconds"]
    monkeypatch.undo()
    monkeypatch.chdir(rnnpb.folder)
    resumed = trained(rnnpb, "--resume", "B.resume.pt", out="B.pt")
    at_once = trained(rnnpb, *RECIPE)
    assert weights(resumed) == weights(at_once)
    assert float(resumed.info.training.pop("seconds")) >= round(seconds, 1)
    at_once.info.training.pop("seconds")
    assert resumed.info == at_once.info
    assert not Path("B.resume.pt").exists()


def test_a_run_that_does_not_fit_resume(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch, ctrl_c_in_epoch_3: None
) -> None:
    interrupt(rnnpb)
    flags = ("train", "--data", "data", "--resume", "B.resume.pt", "--out", "B.pt")
    for flag, value in (("epochs", 7), ("seed", 1), ("beta", 0.5), ("pb-dim", 3)):
        said = rnnpb.refuses(*flags, f"--{flag}", value)
        assert f"--{flag} {value}: the run in B.resume.pt was started with" in said
    assert "--behavior deterministic: the run" in rnnpb.refuses(
        *flags, "--behavior", "deterministic"
    )
    bow = Path("data/bow.csv").read_text()
    Path("data/bow.csv").write_text(bow + "0,0,0,0,0\n")
    assert "B.resume.pt was started with other data" in rnnpb.refuses(*flags)
    said = rnnpb.refuses(*flags, "--resume", "tiny.pt")
    assert "tiny.pt is a finished model, not an interrupted run" in said
    assert "no checkpoint 'none.pt'" in rnnpb.refuses(*flags, "--resume", "none.pt")

    Path("data/bow.csv").write_text(bow)
    whole = read_plain(Path("B.resume.pt"))
    for spoil in ({"random": None}, {"optimizers": [1]}, {"schedules": {"adam": 1, "muon": 1}}):
        torch.save(whole | {"resume": whole["resume"] | spoil}, "B.resume.pt")
        assert "B.resume.pt is damaged and cannot be resumed" in rnnpb.refuses(*flags)


def test_an_interrupted_run_is_not_lost_to_another(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch, ctrl_c_in_epoch_3: None
) -> None:
    interrupt(rnnpb)
    before = Path("B.resume.pt").read_bytes()
    monkeypatch.undo()
    monkeypatch.chdir(rnnpb.folder)
    said = rnnpb.refuses("train", *RECIPE, "--data", "data", "--out", "B.pt")
    again = "rnnpb train --data data --resume B.resume.pt --out B.pt"
    assert f"B.resume.pt holds an interrupted run; to go on with it: {again}; to begin" in said
    Path("B.resume.pt").rename("C.resume.pt")
    trained(rnnpb, "--resume", "C.resume.pt", out="B.pt")
    assert Path("C.resume.pt").read_bytes() == before
    assert not Path("B.resume.pt").exists()


def test_a_model_that_could_not_be_read_again_is_not_trained(rnnpb: Rnnpb) -> None:
    said = rnnpb.refuses("train", "--data", "data", "--hidden-size", 2200, "--out", "B.pt")
    assert "files of more than 200 MB are not read; fewer hidden units will do" in said
    Path("data/bow.csv").rename("data/b\u00a0w.csv")
    said = rnnpb.refuses("train", "--data", "data", "--out", "B.pt")
    assert "the names of its motions hold characters that cannot be shown" in said
    assert not list(Path().glob("B*"))


def test_a_run_that_diverges_writes_nothing(rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch) -> None:
    run = Trainer.run

    def diverging(self: Trainer) -> Iterator[TrainingProgress]:
        for progress in run(self):
            lost = progress.epoch == 3
            yield replace(progress, loss=float("nan")) if lost else progress

    monkeypatch.setattr(Trainer, "run", diverging)
    outcome = train(rnnpb, *RECIPE, "--out", "B.pt")
    said = outcome.err.removeprefix(LISTED)
    assert (outcome.code, outcome.out, said.count("\n")) == (2, "", 1)
    assert "training diverged in epoch 3: the loss is nan" in said
    assert not list(Path().glob("*B*"))


def test_an_existing_file_survives_an_interruption(rnnpb: Rnnpb, ctrl_c_in_epoch_3: None) -> None:
    Path("B.pt").write_text("precious")
    assert train(rnnpb, *RECIPE, "--out", "B.pt").code == 130
    assert Path("B.pt").read_text() == "precious"


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--beta -1", "argument --beta: must be at least 0"),
        ("--beta nan", "argument --beta: must be finite"),
        ("--behavior deterministic --beta 0.1", "a deterministic model has no KL term"),
        ("--behavior wild", "argument --behavior: invalid choice: 'wild'"),
        ("--pb-dim 0", "argument --pb-dim: must be from 1 to 128"),
        ("--pb-dim 129", "argument --pb-dim: must be from 1 to 128"),
        ("--epochs 0", "argument --epochs: must be from 1"),
        ("--data none", "no data at none; give REBL-Pepper's data_raw.csv or a folder"),
        ("--data empty", "no CSV file in empty; expected one a motion"),
        ("--data short", "one.csv has 1 frame; a motion has from 2"),
        ("--data uneven", "b.csv has no column for y"),
        ("--out C.csv", "the name of a checkpoint ends in .pt"),
        ("--out none/C.pt", "there is no folder"),
    ],
)
def test_train_refuses(rnnpb: Rnnpb, flags: str, words: str) -> None:
    for folder in ("empty", "short", "uneven"):
        Path(folder).mkdir()
    Path("short/one.csv").write_text("x,y\n1,2\n")
    Path("uneven/a.csv").write_text("x,y\n1,2\n1,2\n")
    Path("uneven/b.csv").write_text("x,z\n1,2\n1,2\n")
    said = rnnpb.refuses("train", "--data", "data", "--out", "C.pt", *flags.split())
    assert words in said
    assert not list(Path().glob("C*"))


def test_a_bar_on_a_terminal(rnnpb: Rnnpb) -> None:
    """With loss, KL, epochs a second and time left; stdout stays clean."""
    terminal, other_end = pty.openpty()
    flags = [str(flag) for flag in ("--data", "data", *RECIPE, "--epochs", 40, "--out", "C.pt")]
    with subprocess.Popen(
        [sys.executable, "-m", "rnnpb_explorer.app.commands.main", "train", *flags],
        stdout=subprocess.PIPE,
        stderr=other_end,
        env=os.environ | {"COLUMNS": "140", "TERM": "xterm"},
    ) as process:
        os.close(other_end)
        shown = b""
        try:
            while part := os.read(terminal, 4096):
                shown += part
        except OSError:  # the end of a terminal
            pass
        finally:
            os.close(terminal)
        out = process.stdout.read() if process.stdout else b""
    assert process.returncode == 0
    for words in (b"training", b"/40", b"loss", b"error", b"KL", b"ep/s"):
        assert words in shown
    assert out.startswith(b"40 epochs in")


# evaluate

EVALUATE = ("evaluate", "--ckpt", "tiny.pt", "--data", "data")


def test_evaluate_reconstruction(rnnpb: Rnnpb) -> None:
    other = trained(rnnpb, *RECIPE, "--behavior", "deterministic")
    flags = (*EVALUATE, "C.pt", "--samples", 7, "--seed", 2)
    outcome = rnnpb(*flags[:3], "C.pt", *flags[3:5], *flags[6:], "--json", "e.json")
    assert (outcome.code, outcome.err) == (0, "")
    rows = json.loads(Path("e.json").read_text())["reconstruction"]
    dataset = load_dataset("data")
    assert [row["checkpoint"] for row in rows] == ["tiny.pt", "C.pt"]
    for row, model in zip(rows, (rnnpb.model, other), strict=True):
        motions = dataset.for_model(model).motions
        mean, sd = reconstruction(model, motions, 7, seed=2)
        assert (row["mean"], row["sd"]) == pytest.approx((mean, sd), rel=1e-4)
        at_mean = reconstruction_at_mean(model, motions).mean()
        assert row["at_sigma_0"] == pytest.approx(at_mean, rel=1e-4)
        assert (row["behavior"], row["beta"]) == (model.config.behavior, model.config.beta)
        assert (row["motions"], row["samples"], row["seed"]) == (3, 7, 2)
        for words in (f"{mean:.6f} ({sd:.6f})", row["checkpoint"], row["behavior"]):
            assert words in outcome.out


def test_evaluate_structure(rnnpb: Rnnpb) -> None:
    outcome = rnnpb(*EVALUATE, "--task", "structure", "--json", "e.json")
    assert (outcome.code, outcome.err) == (0, "")
    written = json.loads(Path("e.json").read_text())
    assert list(written) == ["structure"]
    (row,) = written["structure"]
    mu = rnnpb.model.mu.numpy()
    spread = mu.std(axis=0, ddof=1).mean()
    assert row["mu_sd"] == pytest.approx(spread, rel=1e-5)
    assert row["sigma"] == pytest.approx(rnnpb.model.sigma.mean().item(), rel=1e-5)
    # Of three motions every third is the first.
    target = load_dataset("data").for_model(rnnpb.model).motions[0].positions
    for window, radius in (("absolute", 1.0), ("sd", 0.7 * float(spread))):
        expected = landscape(rnnpb.model, target, mu[0], radius=radius)
        for name, value in row["landscapes"][window].items():
            assert value == pytest.approx(getattr(expected, name), abs=1e-5)
        shown = (expected.mean, expected.area, expected.roughness)
        assert "{:.3f} / {:.3f} / {:.4f}".format(*shown) in outcome.out


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--task dreams", "no task 'dreams'; there are: reconstruction"),
        ("--samples 0", "argument --samples: must be from 1"),
        ("--ckpt none.pt", "no checkpoint 'none.pt'"),
        ("--json none/e.json", "there is no folder"),
        ("--data empty", "no CSV file in empty"),
        ("--data fewer", "the data lack motions the model has learned: wave, rest"),
    ],
)
def test_evaluate_refuses(rnnpb: Rnnpb, flags: str, words: str) -> None:
    Path("empty").mkdir()
    Path("fewer").mkdir()
    Path("fewer/bow.csv").write_text(Path("data/bow.csv").read_text())
    assert words in rnnpb.refuses(*EVALUATE, *flags.split())
