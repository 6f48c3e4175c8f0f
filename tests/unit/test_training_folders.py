"""Folders of motions as people have them (tests/field/train)."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from rnnpb_explorer.core import InputError
from rnnpb_explorer.core.motion import Motion, write_motion
from rnnpb_explorer.robot import load_dataset
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS
from rnnpb_explorer.robot.reading import Said, Unclear

from .cli_harness import Rnnpb

TRAIN = Path(__file__).parents[1] / "field" / "train"
JOINTS = ("j1", "j2", "j3")
TIMED = sorted(folder.name for folder in TRAIN.glob("*column_*") if "text" not in folder.name)


@pytest.mark.parametrize("name", [*TIMED, "epoch-column___time"])
def test_a_column_of_time_is_no_joint_and_tells_the_rate(name: str, tmp_path: Path) -> None:
    dataset = load_dataset(TRAIN / name)
    assert dataset.joints == JOINTS
    assert dataset.fps == 25.0
    slower = tmp_path / "slower"
    shutil.copytree(TRAIN / name, slower)
    for file in slower.iterdir():
        header, *rows = file.read_text().splitlines()
        halved = rows[::2]  # every second frame: half of the rate
        file.write_text("\n".join([header, *halved]) + "\n")
    assert load_dataset(slower).fps == 12.5


@pytest.mark.parametrize(
    ("name", "joints", "remark"),
    [
        ("seq-column", JOINTS, "a.csv and 1 more: left out: seq"),
        ("text-column_emotion", JOINTS, "a.csv and 1 more: left out: emotion"),
        ("metadata.csv_beside", JOINTS, "metadata.csv: left out, "),
        ("velocities_beside_positions", JOINTS, "left out: j1_velocity, j1_effort"),
        ("one_has_one_joint_more", JOINTS, "b.csv: left out: j4"),
        ("tsv_files", JOINTS, ""),
        ("single_file", JOINTS, ""),
        ("static_motion", JOINTS, ""),
        ("subfolders", JOINTS, ""),
    ],
)
def test_what_is_learned_is_joints_and_what_is_not_is_said(
    name: str, joints: tuple[str, ...], remark: str
) -> None:
    dataset = load_dataset(TRAIN / name)
    assert dataset.joints == joints
    assert any(remark in one for one in dataset.remarks) if remark else dataset.remarks == ()


def test_positions_beside_velocities_are_the_positions() -> None:
    dataset = load_dataset(TRAIN / "velocities_beside_positions")
    rows = np.loadtxt(
        TRAIN / "velocities_beside_positions" / "a.csv", delimiter=",", skiprows=1, dtype=np.float32
    )
    np.testing.assert_array_equal(dataset.motions[0].positions, rows[:, ::3])


def test_a_subfolder_is_the_class_of_its_motions() -> None:
    dataset = load_dataset(TRAIN / "subfolders")
    classes = {name: label.behavior_class for name, label in dataset.labels.items()}
    assert classes == {"a": "happy", "b": "sad"}


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("duplicate_column", "a.csv has more than one column for q[0]"),
        ("one_lacks_a_joint", "b.csv has no column for j3"),
        ("headerless_G1_36", "a.csv has no header; expected the names of the joints (36 columns"),
        ("gripper-0-100", "column gripper: 100 is no plausible angle in radians, and the other"),
        ("encoder_wraps_(multi-turn_20_rad)", "does an encoder count several turns?"),
        ("degrees", "is the file in degrees"),
        ("degrees-small", "is the file in degrees"),
    ],
)
def test_what_cannot_be_learned_from_says_why(name: str, line: str) -> None:
    with pytest.raises(InputError) as refused:
        load_dataset(TRAIN / name)
    assert line in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_unit_that_is_asked_for_can_be_said(rnnpb: Rnnpb) -> None:
    with pytest.raises(Unclear):
        load_dataset(TRAIN / "degrees")
    said = load_dataset(TRAIN / "degrees", said=Said(unit="degrees"))
    assert np.abs(said.motions[0].positions).max() < 1
    wraps = load_dataset(TRAIN / "encoder_wraps_(multi-turn_20_rad)", said=Said(unit="radians"))
    assert wraps.joints == JOINTS
    flags = ("train", "--data", str(TRAIN / "degrees"), "--epochs", "1", "--out", "M.pt")
    assert "Say --unit radians or degrees" in rnnpb.refuses(*flags)
    done = rnnpb(*flags, "--unit", "degrees", "--hidden-size", "4")
    assert done.code == 0
    assert "3 joints: j1, j2, j3" in done.err  # before it starts
    assert "2 motions of 40 to 40 frames at 25 Hz: a, b" in done.err
    measured = ("evaluate", "--ckpt", "M.pt", "--data", str(TRAIN / "degrees"), "--samples", "2")
    assert "Say --unit radians or degrees" in rnnpb.refuses(*measured)
    assert rnnpb(*measured, "--unit", "degrees").code == 0


def test_mixed_rates_become_one_and_that_is_said(tmp_path: Path) -> None:
    for name, step in (("a", 0.02), ("b", 0.02), ("c", 0.04)):
        times = np.arange(20) * step
        rows = "".join(f"{t:g},{np.sin(t):.6f}\n" for t in times)
        (tmp_path / f"{name}.csv").write_text(f"time,joint\n{rows}")
    dataset = load_dataset(tmp_path)
    assert dataset.fps == 50.0
    assert [len(motion) for motion in dataset.motions] == [20, 20, 39]
    assert any("c.csv: 25 Hz" in one and "to 50 Hz" in one for one in dataset.remarks)
    times = np.arange(39) * 0.02
    np.testing.assert_allclose(dataset.motions[2].positions[:, 0], np.sin(times), atol=1e-3)


def test_data_come_at_the_rate_that_a_model_has() -> None:
    dataset = load_dataset(TRAIN / "time-column_time", fps=50.0)
    assert dataset.fps == 50.0
    assert [len(motion) for motion in dataset.motions] == [79, 79]


def test_files_of_other_kinds_lie_beside_motions(tmp_path: Path) -> None:
    motion = Motion("x", PEPPER_JOINTS, np.full((5, 17), 0.3, np.float32))
    write_motion(motion, tmp_path / "wave.csv")
    (tmp_path / "notes.txt").write_text("what I did")
    (tmp_path / "config.json").write_text('{"fps": 25}')
    dataset = load_dataset(tmp_path)
    assert [one.name for one in dataset.motions] == ["wave"]
    assert dataset.joints == PEPPER_JOINTS
    assert [one.partition(":")[0] for one in dataset.remarks] == ["config.json", "notes.txt"]


def test_several_motions_in_a_file_are_learned_as_such(tmp_path: Path) -> None:
    rows = "".join(f"{name},0.{i}\n" for name in ("walk", "run") for i in range(4))
    (tmp_path / "all.csv").write_text(f"episode,joint\n{rows}")
    dataset = load_dataset(tmp_path)
    assert [one.name for one in dataset.motions] == ["run", "walk"]
    assert dataset.joints == ("joint",)


def test_the_published_folders_as_they_are(shared_dir: Path) -> None:
    dataset = load_dataset(shared_dir / "data" / "rebl-pepper" / "generated")
    assert len(dataset.motions) == 4
    assert dataset.joints == PEPPER_JOINTS
    assert dataset.remarks == ()
