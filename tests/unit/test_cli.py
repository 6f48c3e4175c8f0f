"""`rnnpb`: how it answers, whatever it is asked; and the quick commands info and generate."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.app.commands.answer import answer, make_app
from rnnpb_explorer.app.commands.main import COMMANDS
from rnnpb_explorer.core import InputError, save_checkpoint
from rnnpb_explorer.robot.reading import read_motion

from .cli_harness import Rnnpb

RNNPB_COMMAND = (sys.executable, "-m", "rnnpb_explorer.app.commands.main")


# How it answers


def test_help_lists_every_command(rnnpb: Rnnpb) -> None:
    outcome = rnnpb("--help")
    assert outcome.code == 0
    for name in COMMANDS:
        assert f"    {name}" in outcome.out
        assert rnnpb(name, "--help").code == 0
    assert rnnpb("--version").out.startswith("rnnpb ")


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ([], "rnnpb: the following arguments are required: COMMAND"),
        (["fly"], "invalid choice: 'fly'"),
        (["info"], "the following arguments are required: --ckpt"),
        (["generate", "--mu", "0"], "the following arguments are required: --ckpt, --out"),
        (["recognize", "--out", "R.npz"], "the following arguments are required: PATH, --ckpt"),
        (["recognize", "x.csv"], "the following arguments are required: --ckpt, --out"),
        (["info", "--ckpt"], "argument --ckpt: expected one argument"),
        (["info", "--ckpt", "tiny.pt", "--jso"], "unrecognized arguments: --jso"),
        (["info", "--ckpt", "tiny.pt", "--no-json"], "unrecognized arguments: --no-json"),
        (["info", "--ckpt", "tiny.pt", "wave"], "unrecognized arguments: wave"),
        (["info", "--ckpt", "stronk"], "no checkpoint 'stronk'; shipped with the package: "),
        (["info", "--ckpt", "data/wave.csv"], "is no checkpoint"),
        (["info", "--ckpt", "tiny.pt", "--data", "none"], "no data at none"),
        (["screenshot", "--size", "9x9", "--out", "p.png"], "must be from 320x240"),
        (["screenshot", "--size", "big", "--out", "p.png"], "must be WIDTHxHEIGHT"),
        (["screenshot", "--out", "p.jpg"], "the name of a picture ends in .png"),
        (["screenshot", "--out", "none/p.png"], "there is no folder"),
    ],
)
def test_bad_calls_end_in_one_line(rnnpb: Rnnpb, flags: list[str], words: str) -> None:
    assert words in rnnpb.refuses(*flags)


def test_the_help_of_a_command(rnnpb: Rnnpb) -> None:
    """What each flag takes and where it stands without, in plain lines."""
    out = " ".join(rnnpb("landscape", "--help").out.split())
    for words in (
        "Usage: rnnpb landscape --ckpt STR --motion STR --out PATH [OPTIONS]",
        "--axes 1,2|pca two components of the PB counted from 1",
        "[default: 1,2]",
        "--grid INT points a side [default: 20]",
        "[choices: auto, cpu, cuda] [default: auto]",
        "own reconstruction of NAME",  # the end of two lines in the source
    ):
        assert words in out
    assert not {"╭", "│"} & set(out)


def test_the_last_of_a_repeated_flag_counts(rnnpb: Rnnpb) -> None:
    flags = ("--ckpt", "none.pt", "--ckpt", "tiny.pt", "--motion", "rest", "--motion", "bow")
    outcome = rnnpb("generate", *flags, "--steps", 3, "--steps=4", "--out", "x.csv")
    assert (outcome.code, outcome.out) == (0, "1 x 4 frames at 20 Hz: x.csv\n")


def test_bad_flags_are_found_before_torch_is_imported() -> None:
    code = (
        "import sys; from rnnpb_explorer.app.commands.main import main;"
        "codes = [main(['--help']), main(['train', '--data', 'd', '--epochs', '0'])];"
        "sys.exit(codes != [0, 2] or 'torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done
    assert done.stderr.count("\n") == 1


def test_from_a_shell(rnnpb: Rnnpb) -> None:
    """As a process of its own: exit codes, both streams, no bar where no terminal is."""
    done = subprocess.run(
        [*RNNPB_COMMAND, "generate", "--ckpt", "tiny.pt", "--motion", "bow", "--out", "x.csv"],
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "x.csv" in done.stdout
    done = subprocess.run([*RNNPB_COMMAND, "info"], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)


@pytest.mark.parametrize("flags", [("info", "--ckpt", "tiny.pt"), ("--help",)])
def test_a_closed_pipe_is_no_fault(rnnpb: Rnnpb, flags: tuple[str, ...]) -> None:
    with subprocess.Popen(
        [*RNNPB_COMMAND, *flags],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 141


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (InputError("two\nlines\x1b[31m"), 2, "rnnpb test: two lines [31m\n"),
        (KeyboardInterrupt(), 130, "rnnpb test: interrupted\n"),
        (PermissionError(13, "Permission denied", "x"), 2, "[Errno 13] Permission denied: 'x'\n"),
        (MemoryError("too much"), 2, "rnnpb test: MemoryError: too much\n"),
        (IndexError("oops"), 1, "rnnpb test: fault in the program, IndexError: oops"),
    ],
)
def test_whatever_a_command_raises(
    error: BaseException,
    code: int,
    line: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    app = make_app("rnnpb", "Fails.")

    @app.command(name="test")
    def run() -> None:
        raise error

    assert answer(app, ["test"]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert line in captured.err
    assert captured.err.count("\n") == 1
    if code == 1:
        monkeypatch.setenv("RNNPB_TRACEBACK", "1")
        with pytest.raises(IndexError):
            answer(app, ["test"])


# info


def test_info_json(rnnpb: Rnnpb) -> None:
    rnnpb.model.info.metrics = {"reconstruction_mean": 0.25}
    save_checkpoint(rnnpb.model, "tiny.pt")
    assert json.loads(rnnpb("info", "--ckpt", "tiny.pt", "--json").out) == {
        "pb_dim": 3,
        "hidden_size": 16,
        "behavior": "stochastic",
        "beta": 1e-3,
        "joints": ["a", "b", "c", "d", "e"],
        "fps": 20.0,
        "motions": ["wave", "bow", "rest"],
        "lengths": [12, 9, 15],
        "metrics": {"reconstruction_mean": 0.25},
    }


def test_info_for_people(rnnpb: Rnnpb) -> None:
    out = rnnpb("info", "--ckpt", "tiny.pt").out
    for words in ("stochastic", "a, b, c, d, e", "bow", "9 frames", "0.001"):
        assert words in out


def test_data_lend_names_and_lengths_to_a_published_checkpoint(rnnpb: Rnnpb) -> None:
    rnnpb.model.info = replace(rnnpb.model.info, motions=(), lengths=())
    save_checkpoint(rnnpb.model, "published.pt")
    bare = json.loads(rnnpb("info", "--ckpt", "published.pt", "--json").out)
    assert (bare["motions"], bare["lengths"]) == ([], [])
    flags = ("--ckpt", "published.pt", "--data", "data")
    full = json.loads(rnnpb("info", *flags, "--json").out)
    assert full["motions"] == ["bow", "rest", "wave"]  # sorted by name
    assert full["lengths"] == [9, 15, 12]

    assert rnnpb("generate", *flags, "--motion", "rest", "--out", "x.csv").code == 0
    assert len(read_motion("x.csv", rnnpb.model.info.joints)) == 15
    assert rnnpb("generate", *flags[:2], "--motion", "2", "--out", "x.csv").code == 0
    assert len(read_motion("x.csv", rnnpb.model.info.joints)) == 150
    assert "there are: indices 0 to 2" in rnnpb.refuses(
        "generate", *flags[:2], "--motion", "rest", "--out", "x.csv"
    )


# generate


def generated(rnnpb: Rnnpb, *flags: object, out: str = "x.csv") -> np.ndarray:
    outcome = rnnpb("generate", "--ckpt", "tiny.pt", *flags, "--out", out)
    assert (outcome.code, outcome.err) == (0, "")
    return read_motion(out, rnnpb.model.info.joints).positions


def test_generate_from_a_learned_motion(rnnpb: Rnnpb) -> None:
    expected = rnnpb.model.reconstruct(1).numpy()
    for name in ("bow", "1"):
        np.testing.assert_allclose(generated(rnnpb, "--motion", name), expected, atol=1e-6)
    lines = Path("x.csv").read_text().splitlines()
    assert lines[0] == "a,b,c,d,e"
    assert len(lines) == 1 + 9
    assert len(generated(rnnpb, "--motion", "bow", "--steps", 40)) == 40


def test_generate_from_a_pb(rnnpb: Rnnpb) -> None:
    positions = generated(rnnpb, "--mu", "-0.5,1e-1,-2", "--steps", 7)
    expected = rnnpb.model.generate(torch.tensor([[-0.5, 0.1, -2.0]]), 7)[0]
    np.testing.assert_allclose(positions, expected.numpy(), atol=1e-6)
    assert len(generated(rnnpb, "--mu=0,0,0")) == 150


def test_generate_samples(rnnpb: Rnnpb) -> None:
    def samples(*flags: object) -> list[np.ndarray]:
        outcome = rnnpb(
            *("generate", "--ckpt", "tiny.pt", "--motion", "rest", "--samples", 3),
            *("--out", "y.csv", *flags),
        )
        assert outcome.code == 0, outcome
        joints = rnnpb.model.info.joints
        return [read_motion(f"y-{i}.csv", joints).positions for i in range(3)]

    at_mean = rnnpb.model.reconstruct(2).numpy()
    for sample in samples():
        np.testing.assert_allclose(sample, at_mean, atol=1e-6)
    first = samples("--sigma", "0.5", "--seed", 4)
    assert np.abs(first[0] - first[1]).max() > 1e-3
    np.testing.assert_array_equal(first, samples("--sigma", "0.5,0.5,0.5", "--seed", 4))
    assert np.abs(first[0] - samples("--sigma", "0.5", "--seed", 5)[0]).max() > 1e-3
    learned = ",".join(f"{value:.9g}" for value in rnnpb.model.sigma[2].tolist())
    np.testing.assert_allclose(samples("--sigma", "learned"), samples("--sigma", learned))
    assert not Path("y.csv").exists()


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--motion jump", "no motion 'jump' in this model; there are: wave, bow, rest"),
        ("--motion 3", "no motion '3' in this model"),
        ("--motion bow --mu 1,2,3", "not allowed with argument"),
        ("", "one of the arguments --motion --mu is required"),
        ("--mu 1,2", "--mu has 2 numbers, this model's PB has 3"),
        ("--mu 1,x,2", "argument --mu: 'x' is no number"),
        ("--mu nan,1,2", "argument --mu: must be finite, got nan"),
        ("--mu 1e9,1,2", "argument --mu: must be at least -1e+06 and at most 1e+06"),
        ("--motion bow --sigma 1,2", "--sigma has 2 numbers; give one, or 3"),
        ("--motion bow --sigma -1", "argument --sigma: must be at least 0"),
        ("--mu 1,2,3 --sigma learned", "--sigma learned needs --motion"),
        ("--motion bow --samples 0", "argument --samples: must be from 1 to 10000, got 0"),
        ("--motion bow --samples 1.5", "argument --samples: '1.5' is no whole number"),
        ("--motion bow --steps 999999", "argument --steps: must be from 1 to 5000"),
        ("--motion bow --seed -1", "argument --seed: must be from 0"),
        ("--motion bow --device tpu", "argument --device: invalid choice: 'tpu'"),
        ("--motion bow --out x.txt", "the name of a CSV file ends in .csv"),
        ("--motion bow --out none/x.csv", "there is no folder"),
        ("--motion bow --samples 2 --out none/x.csv", "there is no folder"),
    ],
)
def test_generate_refuses(rnnpb: Rnnpb, flags: str, words: str) -> None:
    said = rnnpb.refuses("generate", "--ckpt", "tiny.pt", "--out", "x.csv", *flags.split())
    assert words in said
    assert not list(Path().glob("x*"))


@pytest.mark.skipif(torch.cuda.is_available(), reason="here is a GPU")
def test_no_gpu(rnnpb: Rnnpb) -> None:
    flags = ("--ckpt", "tiny.pt", "--motion", "bow", "--out", "x.csv", "--device", "cuda")
    assert "torch finds no GPU" in rnnpb.refuses("generate", *flags)
