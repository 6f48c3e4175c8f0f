"""`rnnpb export`: what is written can be read back, and limits hold unless one insists."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from rnnpb_explorer.app.commands.main import main
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.robot.description import load_robot
from rnnpb_explorer.robot.reading import read_motion, read_motions
from rnnpb_explorer.robot.safety import check_motion

FAR = ("--mu", "3,-3,3,3")  # where the strong model's motions break limits of the robot


def export(out: Path, *flags: str) -> int:
    return main(["export", "--ckpt", "strong", *flags, "--out", str(out)])


def test_limits_hold_unless_one_insists(strong: RNNPB, tmp_path: Path) -> None:
    robot, joints = load_robot("pepper"), strong.info.joints
    limited, raw = tmp_path / "limited.csv", tmp_path / "raw.csv"
    assert export(limited, *FAR) == 0
    assert export(raw, *FAR, "--beyond-limits") == 0
    assert check_motion(read_motion(raw, joints), robot).light != "green"
    assert check_motion(read_motion(limited, joints), robot).light == "green"


def test_what_breaks_limits_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert export(tmp_path / "x.csv", *FAR) == 0
    said = capsys.readouterr()
    assert re.search(r"^\w+: .* rad.*, frames? \d", said.err)
    assert "within the limits" in said.out


@pytest.mark.parametrize("file_format", ["json", "naoqi"])
def test_every_format_brings_the_motion_back(
    strong: RNNPB, tmp_path: Path, file_format: str
) -> None:
    out, plain = tmp_path / "motion.out", tmp_path / "motion.csv"
    assert export(out, "--motion", "Happy_4", "--format", file_format) == 0
    assert export(plain, "--motion", "Happy_4") == 0
    (back,) = read_motions(out.read_bytes(), out.name).motions
    columns = [back.joints.index(joint) for joint in strong.info.joints]
    expected = read_motion(plain, strong.info.joints).positions
    np.testing.assert_allclose(back.positions[:, columns], expected, atol=2e-6)


def test_it_starts_and_ends_in_a_safe_posture(strong: RNNPB, tmp_path: Path) -> None:
    out = tmp_path / "safe.csv"
    assert export(out, "--motion", "Happy_4", "--safe-posture") == 0
    positions = read_motion(out, strong.info.joints).positions
    np.testing.assert_allclose(positions[0], positions[-1], atol=1e-6)
    assert len(positions) > strong.length(strong.motion_index("Happy_4"))


@pytest.mark.parametrize(("file_format", "suffix"), [("json", ".json"), ("naoqi", ".py")])
def test_an_export_is_recognised(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], file_format: str, suffix: str
) -> None:
    """Generated between learned motions, exported, recognised: back at the same mu."""
    mu, out = (0.2, -0.1, 0.3, 0.1), tmp_path / f"motion{suffix}"
    flags = ("--mu", ",".join(map(str, mu)), "--steps", "40", "--safe-posture")
    assert export(out, *flags, "--format", file_format) == 0
    result = tmp_path / "path.npz"
    recognise = ["recognize", "--ckpt", "strong", str(out), "--method", "lm", "--trials", "1"]
    assert main([*recognise, "--out", str(result)]) == 0
    with np.load(result) as path:
        best = path["loss"][:, -1].argmin()
        np.testing.assert_allclose(path["mu"][best, -1], mu, atol=0.01)
    assert main([*recognise, "--unit", "degrees", "--out", str(result)]) == 2
    assert "is in radians, as" in capsys.readouterr().err


def test_what_is_no_export_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.json"
    path.write_text("{}")
    flags = ["--ckpt", "strong", str(path), "--out", str(tmp_path / "r.npz")]
    assert main(["recognize", *flags]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "x.json is no motion exported as JSON" in line


@pytest.mark.parametrize("flags", [("--motion", "Nope"), ("--motion", "0", "--robot", "nobody")])
def test_bad_input_writes_nothing(
    tmp_path: Path, flags: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "x.csv"
    assert export(out, *flags) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not out.exists()
