"""Training data: REBL-Pepper's file, folders of motions, labels, and what fits a model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rnnpb_explorer.core import RNNPB, Dataset, InputError, Motion
from rnnpb_explorer.core.data import behavior_class
from rnnpb_explorer.core.motion import MotionLabel
from rnnpb_explorer.robot import load_dataset
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS, mirror

ARMS = ("ElbowRoll", "ElbowYaw", "ShoulderRoll", "WristYaw")
ROW = ",".join("0.5" for _ in PEPPER_JOINTS)
HEADER = ",id," + ",".join(PEPPER_JOINTS) + ",R0R"


def write(path: Path, lines: list[str]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")
    return path


def rebl(path: Path, *names: str) -> Path:
    """A file like data_raw.csv with one frame for each of the names."""
    rows = [f"{i},{name},{ROW},1.0" for i, name in enumerate(names)]
    return write(path, [HEADER, *rows])


def motion_file(path: Path, header: str = "a,b", frames: int = 2) -> Path:
    cells = ",".join("0.25" for _ in header.split(","))
    return write(path, [header, *[cells] * frames])


def test_the_published_data(dataset: Dataset, shared_dir: Path) -> None:
    names = [motion.name for motion in dataset.motions]
    assert len(names) == 72
    assert names == sorted(names)
    assert sum(map(len, dataset.motions)) == 10_148
    assert (min(map(len, dataset.motions)), max(map(len, dataset.motions))) == (67, 307)
    assert (dataset.joints, dataset.fps) == (PEPPER_JOINTS, 25.0)
    label = dataset.labels["Happy_4_tr"]
    assert (label.behavior_class, label.valence, label.arousal) == ("Happy", 0.728, 0.6905)
    assert all(label.valence is not None for label in dataset.labels.values())
    folder = shared_dir / "data" / "rebl-pepper"
    assert load_dataset(folder).sha256 == dataset.sha256


def test_mirror() -> None:
    values = np.arange(2 * 17, dtype=np.float32).reshape(2, 17) + 1
    motion = Motion("Happy_4", PEPPER_JOINTS, values)
    other = mirror(motion)
    before = dict(zip(PEPPER_JOINTS, motion.positions.T, strict=True))
    after = dict(zip(PEPPER_JOINTS, other.positions.T, strict=True))
    assert other.name == "Happy_4_tr"
    for joint in ("HeadPitch", "HipPitch", "KneePitch"):
        np.testing.assert_array_equal(after[joint], before[joint])
    for joint in ("HeadYaw", "HipRoll"):
        np.testing.assert_array_equal(after[joint], -before[joint])
    for joint in ("Hand", "ShoulderPitch"):
        np.testing.assert_array_equal(after["L" + joint], before["R" + joint])
        np.testing.assert_array_equal(after["R" + joint], before["L" + joint])
    for joint in ARMS:
        np.testing.assert_array_equal(after["L" + joint], -before["R" + joint])
        np.testing.assert_array_equal(after["R" + joint], -before["L" + joint])
    np.testing.assert_array_equal(mirror(other).positions, motion.positions)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Happy_4_tr", "Happy"),
        ("Happy_4", "Happy"),
        ("AskForAttention_3_tr", "AskForAttention"),
        ("Fear_tr", "Fear"),
        ("walk", "walk"),
        ("Sad_reaction_01", "Sad_reaction"),
    ],
)
def test_behavior_class(name: str, expected: str) -> None:
    assert behavior_class(name) == expected


def test_rebl_pepper_file(tmp_path: Path) -> None:
    path = rebl(tmp_path / "mine.csv", "Sad_1", "Fear_2", "Sad_1", "Fear_2")
    write(tmp_path / "labels_raw.csv", [",id,valence,arousal", "0,Sad_1,0.25,0.5"])
    dataset = load_dataset(path)
    assert [m.name for m in dataset.motions] == ["Fear_2", "Fear_2_tr", "Sad_1", "Sad_1_tr"]
    assert dataset.labels["Sad_1_tr"].valence == 0.25  # a mirrored motion has its original's
    assert dataset.labels["Fear_2"].valence is None


def test_data_that_are_mirrored_already_stay_as_they_are(tmp_path: Path) -> None:
    path = rebl(tmp_path / "data_augmented.csv", *["Sad_1", "Sad_1_tr"] * 2)
    assert [m.name for m in load_dataset(path).motions] == ["Sad_1", "Sad_1_tr"]


def test_the_published_repository(tmp_path: Path) -> None:
    rebl(tmp_path / "original_animations" / "data_raw.csv", "Sad_1", "Sad_1")
    assert len(load_dataset(tmp_path).motions) == 2


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "data_raw.csv is empty"),
        ([HEADER], "a header and no frames"),
        ([HEADER, f"0,Sad_1,{ROW},1"], "motion Sad_1 has 1 frame;"),
        ([HEADER, f"0,Sad_1,{ROW},1", f"0,,{ROW},1"], "row 3, column id: no name"),
        ([HEADER, f"0,Sad_1,{ROW},1", f"0,Sad_1,{ROW}"], "row 3: 19 columns, expected 20"),
        ([HEADER, f"0,Sad_1,{ROW.replace('0.5', 'x', 1)},1"], "row 2, column HeadPitch: 'x'"),
        ([HEADER, f"0,Sad_1,{ROW.replace('0.5', 'nan', 1)},1"], "nan is not finite"),
        ([HEADER, f"0,Sad_1,{ROW.replace('0.5', '90', 1)},1"], "90 is no plausible angle"),
        ([HEADER.replace("LHand,", "")], "no column for LHand"),
        (
            ["a,b", "1,2", "1,2"],
            "it has no column id; motions of one CSV file each go into a folder",
        ),
    ],
)
def test_refuses_a_bad_data_file(tmp_path: Path, lines: list[str], words: str) -> None:
    path = tmp_path / "data_raw.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError) as caught:
        load_dataset(path)
    assert words in str(caught.value)


def test_folder_of_motions(tmp_path: Path) -> None:
    motion_file(tmp_path / "b.csv", ",id,b,a,frame")  # another order, an index, a name
    motion_file(tmp_path / "a_1.csv", "a,b", frames=3)
    motion_file(tmp_path / "C.CSV", "a,b,extra")
    motion_file(tmp_path / ".hidden.csv", "q")
    write(tmp_path / "labels.csv", ["id,valence,arousal", "a_1,60,0.2", "b,,-4e1"])
    (tmp_path / "notes.txt").write_text("not a motion")
    dataset = load_dataset(tmp_path, ("a", "b"))
    assert [motion.name for motion in dataset.motions] == ["C", "a_1", "b"]
    assert [len(motion) for motion in dataset.motions] == [2, 3, 2]
    assert dataset.labels["a_1"] == MotionLabel("a", 60.0, 0.2)  # no angle
    assert dataset.labels["b"] == MotionLabel("b", None, -40.0)
    assert dataset.labels["C"] == MotionLabel("C", None, None)


@pytest.mark.parametrize(
    ("header", "joints"),
    [
        (",a,b", ("a", "b")),
        ("R0R,a,L7B,b", ("a", "b")),  # LEDs are no joints
        ("id,a,Time,b,Unnamed: 0", ("a", "b")),
        ("R0R," + ",".join(reversed(PEPPER_JOINTS)), PEPPER_JOINTS),
    ],
)
def test_a_folders_joints_stand_in_its_headers(
    tmp_path: Path, header: str, joints: tuple[str, ...]
) -> None:
    motion_file(tmp_path / "a.csv", header)
    assert load_dataset(tmp_path).joints == joints


def test_refuses_bad_folders(tmp_path: Path) -> None:
    def message() -> str:
        with pytest.raises(InputError) as caught:
            load_dataset(tmp_path)
        return str(caught.value)

    assert "no CSV file in" in message()
    motion_file(tmp_path / "b.csv", frames=1)
    assert "b.csv has 1 frame" in message()
    motion_file(tmp_path / "b.csv", "b")
    motion_file(tmp_path / "a.csv", "a,b")
    assert message() == "b.csv has no column for a"
    motion_file(tmp_path / "a.csv", "1,2")
    assert message() == "a.csv has no header; expected the names of the joints"
    motion_file(tmp_path / "a.csv", "id,frame")
    assert message() == "a.csv names no joints in its header"
    motion_file(tmp_path / "a.csv", "b")
    write(tmp_path / "labels.csv", ["id,valence,arousal", "a,high,0.2"])
    assert message() == "labels.csv, row 2, column valence: 'high' is no number"


def test_nothing_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no data at .*none; give REBL-Pepper's data_raw.csv or"):
        load_dataset(tmp_path / "none")


def data_for(model: RNNPB, joints: tuple[str, ...], names: tuple[str, ...]) -> Dataset:
    motions = tuple(
        Motion(
            name, joints, np.full((4, len(joints)), i, dtype=np.float32) + np.arange(len(joints))
        )
        for i, name in enumerate(names)
    )
    return Dataset(motions, dict.fromkeys(names, model.info.labels["bow"]))


def test_data_in_the_order_of_a_model(tiny_model: RNNPB) -> None:
    joints = ("e", "spare", *"abcd")
    dataset = data_for(tiny_model, joints, ("bow", "jump", "rest", "wave")).for_model(tiny_model)
    assert [motion.name for motion in dataset.motions] == ["wave", "bow", "rest"]
    assert dataset.joints == tiny_model.info.joints
    np.testing.assert_array_equal(dataset.motions[1].positions[0], [2, 3, 4, 5, 0])

    tiny_model.info = replace(tiny_model.info, motions=(), lengths=())  # as a published one
    published = data_for(tiny_model, joints, ("x", "y", "z")).for_model(tiny_model)
    assert [motion.name for motion in published.motions] == ["x", "y", "z"]


def test_data_that_do_not_fit_a_model(tiny_model: RNNPB) -> None:
    joints = tiny_model.info.joints
    with pytest.raises(InputError, match="no joint e, which"):
        data_for(tiny_model, joints[:4], ("bow", "rest", "wave")).for_model(tiny_model)
    with pytest.raises(InputError, match="lack motions the model has learned: rest"):
        data_for(tiny_model, joints, ("bow", "wave")).for_model(tiny_model)
    tiny_model.info = replace(tiny_model.info, motions=())
    with pytest.raises(InputError, match="have 2 motions, the model has learned 3"):
        data_for(tiny_model, joints, ("bow", "wave")).for_model(tiny_model)


def test_the_fingerprint_follows_names_and_values(tiny_model: RNNPB) -> None:
    joints = tiny_model.info.joints
    dataset = data_for(tiny_model, joints, ("bow", "wave"))
    assert dataset.sha256 == data_for(tiny_model, joints, ("bow", "wave")).sha256
    assert dataset.sha256 != data_for(tiny_model, joints, ("bow", "rest")).sha256
    dataset.motions[1].positions[3, 4] += 1e-4
    assert dataset.sha256 != data_for(tiny_model, joints, ("bow", "wave")).sha256
