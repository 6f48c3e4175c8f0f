"""`rnnpb convert`: what was understood is said, and what is written is one of our own files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rnnpb_explorer.robot.pepper import PEPPER_JOINTS
from rnnpb_explorer.robot.reading import read_motion

from .cli_harness import Rnnpb

FIELD = Path(__file__).parents[1] / "field" / "motions"


@pytest.mark.parametrize("out", ["M.csv", "M.json", "M.py"])
def test_it_says_what_it_understood_and_writes_the_motion(rnnpb: Rnnpb, out: str) -> None:
    done = rnnpb("convert", str(FIELD / "rate-100hz-with-time.csv"), "--out", out)
    assert (done.code, done.err.count("\n")) == (0, 1)
    assert "CSV, 1 motion, 100 Hz (" in done.err
    assert "resampled to 25 Hz" in done.err
    assert done.out.startswith("rate-100hz-with-time: 75 frames of 17 joints at 25 Hz, M")
    expected = read_motion(FIELD / "rate-100hz-with-time.csv", PEPPER_JOINTS)
    written = read_motion(Path(out), PEPPER_JOINTS)
    np.testing.assert_allclose(written.positions, expected.positions, atol=1e-6)


def test_what_a_file_leaves_open_is_said_by_flags(rnnpb: Rnnpb, tmp_path: Path) -> None:
    two = str(FIELD / "two-motions-id-column.csv")
    refused = rnnpb("convert", two, "--out", "M.csv")
    assert refused.code == 2
    assert "the file has 2 motions: A, B; choose one with --motion" in refused.err
    assert rnnpb("convert", two, "--motion", "B", "--out", "M.csv").code == 0
    hands = tmp_path / "hands.csv"
    rows = "".join(",".join(["0.1"] * 16 + [str(20 + i)]) + "\n" for i in range(3))
    joints = [*(j for j in PEPPER_JOINTS if j != "RHand"), "RHand"]
    hands.write_text(",".join(joints) + "\n" + rows)
    assert "Say --hands percent or degrees" in rnnpb.refuses(
        "convert", str(hands), "--out", "H.csv"
    )
    assert rnnpb("convert", str(hands), "--hands", "percent", "--out", "H.csv").code == 0
    assert read_motion(Path("H.csv"), PEPPER_JOINTS).positions[0, 13] == pytest.approx(0.2)
    slow = rnnpb("convert", str(FIELD / "00-control.csv"), "--fps", "12.5", "--out", "S.csv")
    assert "12.5 Hz (said), resampled to 25 Hz" in slow.err
    assert len(read_motion(Path("S.csv"), PEPPER_JOINTS)) == 59


def test_a_models_joints_and_rate(rnnpb: Rnnpb, tmp_path: Path) -> None:
    path = tmp_path / "five.csv"
    path.write_text("e,d,c,b,a\n" + "0.1,0.2,0.3,0.4,0.5\n" * 4)
    done = rnnpb("convert", str(path), "--ckpt", "tiny.pt", "--out", "M.csv")
    assert done.code == 0, done
    assert "4 frames of 5 joints" in done.out


@pytest.mark.parametrize(
    ("flags", "line"),
    [
        (("none.csv", "--out", "M.csv"), "cannot read none.csv"),
        ((str(FIELD / "poppy-move.json"), "--out", "M.csv"), "Poppy robot"),
        ((str(FIELD / "00-control.csv"), "--out", "M.bvh"), "a motion is written as .csv"),
        ((str(FIELD / "00-control.csv"), "--fps", "0", "--out", "M.csv"), "must be at least 0.5"),
    ],
)
def test_it_refuses_in_one_line(rnnpb: Rnnpb, flags: tuple[str, ...], line: str) -> None:
    assert line in rnnpb.refuses("convert", *flags)
    assert not list(Path().glob("M.*"))
