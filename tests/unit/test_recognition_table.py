"""Table II: the three ways of reading off a number, against plain loops; the command on top."""

from __future__ import annotations

import json
import statistics
from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.core import (
    RNNPB,
    ModelConfig,
    ModelInfo,
    Motion,
    RecognitionConfig,
    recognize,
    save_checkpoint,
    write_motion,
)
from rnnpb_explorer.core.codebook import complete_codebook
from rnnpb_explorer.core.paper.novel_patterns import SOURCES, novel_patterns
from rnnpb_explorer.core.paper.recognition_table import Spread, recognition_row
from rnnpb_explorer.core.recognition_lm import recognize_lm

from .cli_harness import Rnnpb

JOINTS = tuple("abcde")


@pytest.fixture
def ten_motions() -> RNNPB:
    """A tiny model that has learned (at random) motions with the names of the ten sources."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(3)
        config = ModelConfig(num_joints=5, pb_dim=2, hidden_size=8, num_motions=10)
        info = ModelInfo(joints=JOINTS, motions=SOURCES, lengths=(12,) * 10)
        model = RNNPB(config, info)
        torch.nn.init.normal_(model.mu)
    return model.eval().requires_grad_(False)


def motions_of(model: RNNPB) -> list[Motion]:
    random = np.random.default_rng(0)
    return [
        Motion(
            name,
            JOINTS,
            model.reconstruct(i).numpy() + random.normal(0, 0.05, (12, 5)).astype(np.float32),
        )
        for i, name in enumerate(SOURCES)
    ]


def spread(values: list[float]) -> Spread:
    return Spread(
        pytest.approx(statistics.fmean(values), rel=1e-4),  # type: ignore[arg-type]
        pytest.approx(statistics.pstdev(values), rel=1e-3, abs=1e-6),  # type: ignore[arg-type]
    )


@pytest.mark.parametrize("warm_start", ["baseline", "learned", "random"])
def test_against_plain_loops(ten_motions: RNNPB, warm_start: str) -> None:
    patterns = novel_patterns(motions_of(ten_motions))[:3]
    counted: list[int] = []
    row = recognition_row(
        ten_motions,
        warm_start,  # type: ignore[arg-type]
        patterns,
        trials=4,
        iterations=6,
        seed=2,
        recognized=lambda: counted.append(1),
    )
    assert len(counted) == 3
    read: dict[str, list[float]] = {
        f"{way} {what}": [] for way in ("last", "best", "chosen") for what in ("loss", "error")
    }
    for number, pattern in enumerate(patterns):
        lowest, its_error = float("inf"), float("nan")
        for trial in range(4):  # one at a time, as the published code does
            config = RecognitionConfig(
                init=warm_start,  # type: ignore[arg-type]
                candidates=10,
                iterations=6,
                seed=2,
                first_trial=4 * number + trial,
            )
            steps = list(recognize(ten_motions, pattern.positions, config))
            losses = [float(step.loss[0]) for step in steps]
            errors = [float(step.prediction_error[0]) for step in steps]
            read["last loss"].append(losses[-1])
            read["last error"].append(errors[-1])
            best = losses.index(min(losses))
            read["best loss"].append(losses[best])
            read["best error"].append(errors[best])
            if losses[best] < lowest:
                lowest, its_error = losses[best], errors[best]
        read["chosen loss"].append(lowest)
        read["chosen error"].append(its_error)
    for measure, what in ((row.reconstruction_loss, "loss"), (row.prediction_error, "error")):
        assert measure.last_iterate == spread(read[f"last {what}"])
        assert measure.best_iterate == spread(read[f"best {what}"])
        assert measure.best_of_trials == spread(read[f"chosen {what}"])


def test_levenberg_marquardt(rnnpb: Rnnpb, ten_motions: RNNPB) -> None:
    patterns = novel_patterns(motions_of(ten_motions))[:2]
    codebook = complete_codebook(ten_motions, 100)
    for procedure, book in (("lm", None), ("global", codebook)):
        row = recognition_row(ten_motions, procedure, patterns, codebook=codebook)  # type: ignore[arg-type]
        runs = [
            list(recognize_lm(ten_motions, pattern.positions, codebook=book))
            for pattern in patterns
        ]
        best = [min(float(step.loss.min()) for step in steps) for steps in runs]
        measured = row.reconstruction_loss
        assert measured.last_iterate == measured.best_iterate == measured.best_of_trials
        assert measured.best_of_trials == spread(best)


def test_the_command(rnnpb: Rnnpb, ten_motions: RNNPB) -> None:
    save_checkpoint(ten_motions, "ten.pt")
    Path("sources").mkdir()
    motions = motions_of(ten_motions)
    for motion in motions:
        write_motion(motion, Path("sources") / f"{motion.name}.csv")
    flags = ("evaluate", "--ckpt", "ten.pt", "--data", "sources", "--json", "e.json")
    settings = ("--trials", 3, "--iterations", 4, "--draws", 2, "--seed", 7, "--samples", 2)
    outcome = rnnpb(*flags, *settings, "--task", "recognition,reconstruction", "--lm")
    assert outcome.code == 0, outcome
    tables = json.loads(Path("e.json").read_text())
    assert [row["samples"] for row in tables["reconstruction"]] == [2]
    rows = tables["recognition"]
    assert [row["warm_start"] for row in rows] == ["baseline", "learned", "random", "lm", "global"]
    patterns = [*novel_patterns(motions, 7), *novel_patterns(motions, 8)]
    for row in rows:
        facts = (row["trials"], row["iterations"], row["draws"], row["patterns"])
        assert facts == (3, 4, [7, 8], 20)
        expected = recognition_row(
            ten_motions,
            row["warm_start"],
            patterns,
            trials=3,
            iterations=4,
            seed=7,
            codebook=complete_codebook(ten_motions),
        )
        for name in ("reconstruction_loss", "prediction_error"):
            for way in ("last_iterate", "best_iterate", "best_of_trials"):
                measured = row[name][way]
                wanted = getattr(getattr(expected, name), way)
                assert measured["mean"] == pytest.approx(wanted.mean, rel=1e-3)
                assert measured["sd"] == pytest.approx(wanted.sd, rel=1e-3)
                assert f"{measured['mean']:.6f} ({measured['sd']:.6f})" in outcome.out
    for words in ("last iterate", "best iterate", "best of 3 trials", "20 novel patterns"):
        assert words in outcome.out


def test_data_without_the_sources(rnnpb: Rnnpb) -> None:
    flags = ("evaluate", "--ckpt", "tiny.pt", "--data", "data", "--task", "recognition")
    assert "made from REBL-Pepper's motions; the data lack Angry_3" in rnnpb.refuses(*flags)
