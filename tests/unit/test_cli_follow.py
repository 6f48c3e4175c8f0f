"""`rnnpb follow`: frames in, lines of JSON out, each before the next frame comes."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rnnpb_explorer.core.motion import format_motion

from .cli_harness import Rnnpb

FOLLOW = ("follow", "--ckpt", "tiny.pt")


def lines(rnnpb: Rnnpb, *flags: object) -> list[dict[str, Any]]:
    outcome = rnnpb(*FOLLOW, *flags)
    assert outcome.code == 0, outcome
    return [json.loads(line) for line in outcome.out.splitlines()]


def test_a_line_a_frame(rnnpb: Rnnpb) -> None:
    told = lines(rnnpb, "data/rest.csv")
    assert [line["frame"] for line in told] == list(range(15))
    names = {"frame", "mu", "sigma", "loss", "explained", "milliseconds"}
    assert all(set(line) == names for line in told)
    assert len(told[0]["mu"]) == len(told[0]["sigma"]) == 3
    assert told[-1]["explained"] > told[3]["explained"] - 1
    assert told[-1]["loss"] < 0.1


def test_from_standard_input(rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch) -> None:
    text = Path("data/rest.csv").read_text()
    monkeypatch.setattr(sys, "stdin", io.StringIO(text))
    from_stdin = lines(rnnpb)
    from_file = lines(rnnpb, "data/rest.csv")
    for one, other in zip(from_stdin, from_file, strict=True):
        assert one["frame"] == other["frame"]


def test_an_answer_comes_before_the_next_frame(rnnpb: Rnnpb) -> None:
    header, *rows = format_motion(rnnpb.target(2)).splitlines()
    command = [sys.executable, "-m", "rnnpb_explorer.app.commands.main", *FOLLOW, "-"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=os.environ
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(f"{header}\n")
        for number, row in enumerate(rows[:3]):
            process.stdin.write(f"{row}\n")
            process.stdin.flush()
            assert json.loads(process.stdout.readline())["frame"] == number
        process.stdin.close()
        assert process.stdout.read() == ""
    assert process.returncode == 0


def test_columns_by_name_and_only_those_that_are_seen(rnnpb: Rnnpb) -> None:
    positions = rnnpb.target(2).positions
    rows = [f"{row[3]:.9g},x,{row[0]:.9g}" for row in positions]
    Path("some.csv").write_text("\n".join(["d,note,a", *rows]))
    some = lines(rnnpb, "some.csv", "--joints", "a,d")
    whole = lines(rnnpb, "data/rest.csv", "--joints", "a,d")
    np.testing.assert_allclose(some[0]["mu"], whole[0]["mu"], atol=1e-6)


@pytest.mark.parametrize(("fps", "frames"), [(40, 8), (10, 29), (20, 15)])
def test_another_rate_is_brought_to_the_models(rnnpb: Rnnpb, fps: int, frames: int) -> None:
    assert rnnpb.model.info.fps == 20
    assert len(lines(rnnpb, "data/rest.csv", "--fps", fps)) == frames


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1 names the joints; missing: a, b, c, d, e"),
        ("a,b,c,d\n", "missing: e"),
        ("a,b,c,d,e\n1,2,3,4\n", "line 2 has 4 values, line 1 5 names"),
        ("a,b,c,d,e\n1,2,x,4,5\n", "line 2, c: 'x' is no number"),
        ("a,b,c,d,e\n1,2,nan,4,5\n", "frame 0 holds NaN or infinity"),
        ("a" * 200_000, "a line of more than"),
    ],
)
def test_bad_input(rnnpb: Rnnpb, text: str, words: str) -> None:
    lines(rnnpb, "data/rest.csv")  # the codebook lies in the cache then
    Path("bad.csv").write_text(text)
    assert words in rnnpb.refuses(*FOLLOW, "bad.csv")


def test_a_file_that_is_none(rnnpb: Rnnpb) -> None:
    assert "cannot read none.csv" in rnnpb.refuses(*FOLLOW, "none.csv")
    Path("bytes.csv").write_bytes(b"a,b\xff\xfe\n")
    assert "no text" in rnnpb.refuses(*FOLLOW, "bytes.csv")
    assert "no joint 'z'" in rnnpb.refuses(*FOLLOW, "data/rest.csv", "--joints", "z")
