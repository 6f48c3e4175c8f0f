"""Joint rotations of whole motions against yourdfpy, and our Pepper against the published one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yourdfpy
from arm import write_arm
from numpy.typing import NDArray

from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.kinematics import extent, joint_poses, link_poses
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS, PEPPER_URDF

# Links of our Pepper and the published description's names for them.
COUNTERPARTS = {
    "torso": "torso",
    "head": "Head",
    "pelvis": "Hip",
    "l_hand": "l_wrist",
    "r_hand": "r_wrist",
    "l_forearm": "LForeArm",
    "r_forearm": "RForeArm",
}
FINGERS = [f"Finger{finger}{joint}" for finger in (1, 2, 3, 4) for joint in (1, 2, 3)]
ARM = """<robot name="arm">
  <link name="base"/><link name="plate"/><link name="slide"/><link name="fore"/><link name="tip"/>
  <link name="left"/><link name="right"/>
  <joint name="mount" type="fixed"><parent link="base"/><child link="plate"/>
    <origin xyz="0 0 0.5" rpy="0.1 0.2 0.3"/></joint>
  <joint name="lift" type="prismatic"><parent link="plate"/><child link="slide"/>
    <origin xyz="0.1 0 0" rpy="0 0.4 0"/><axis xyz="0 0 1"/>
    <limit lower="0.2" upper="0.8" velocity="0.5" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="slide"/><child link="fore"/>
    <origin xyz="0 0.2 0.1" rpy="1 0 2"/><axis xyz="0.6 0 0.8"/></joint>
  <joint name="wrist" type="fixed"><parent link="fore"/><child link="tip"/>
    <origin xyz="0.3 0 0"/></joint>
  <joint name="jaw" type="prismatic"><parent link="tip"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="0" effort="1"/></joint>
  <joint name="other_jaw" type="prismatic"><parent link="tip"/><child link="right"/>
    <axis xyz="0 1 0"/><limit lower="-0.04" upper="0.01" velocity="1" effort="1"/>
    <mimic joint="jaw" multiplier="-1" offset="0.01"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def pepper() -> Robot:
    return load_robot("pepper")


@pytest.fixture
def arm_path(tmp_path: Path) -> Path:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    return path


def _random(robot: Robot, joints: tuple[str, ...], count: int) -> NDArray[np.float64]:
    limits = np.clip([robot.limits[joint] for joint in joints], -3, 3)
    return np.random.default_rng(0).uniform(limits[:, 0], limits[:, 1], (count, len(joints)))


def _assert_as_yourdfpy(robot: Robot, path: Path, joints: tuple[str, ...]) -> None:
    reference = yourdfpy.URDF.load(str(path), load_meshes=False)
    positions = _random(robot, joints, 20)
    links = tuple(robot.tree.links)
    ours = link_poses(robot, joints, positions, links)
    for frame, values in enumerate(positions):
        reference.update_cfg(dict(zip(joints, values, strict=True)))
        theirs = np.stack([reference.get_transform(link) for link in links])
        np.testing.assert_allclose(ours[frame], theirs, atol=1e-9)


def test_pepper_moves_as_yourdfpy_says(pepper: Robot) -> None:
    _assert_as_yourdfpy(pepper, PEPPER_URDF, PEPPER_JOINTS)


def test_any_urdf_moves_as_yourdfpy_says(arm_path: Path) -> None:
    robot = load_robot(str(arm_path))
    assert robot.joints == ("lift", "turn", "jaw")
    _assert_as_yourdfpy(robot, arm_path, robot.joints)


def test_our_pepper_stands_and_reaches_as_the_published_one(
    pepper: Robot, published_pepper: Path
) -> None:
    published = load_robot(str(published_pepper))
    for joint in PEPPER_JOINTS:
        assert pepper.limits[joint] == pytest.approx(published.limits[joint], abs=1e-7)
    assert pepper.velocity_limits == pytest.approx(published.velocity_limits)
    positions = _random(pepper, PEPPER_JOINTS, 300)

    def apart(ours: tuple[str, ...], theirs: tuple[str, ...]) -> float:
        a = link_poses(pepper, PEPPER_JOINTS, positions, ours)
        b = link_poses(published, PEPPER_JOINTS, positions, theirs)
        return float(np.abs(a - b).max())

    assert apart(tuple(COUNTERPARTS), tuple(COUNTERPARTS.values())) < 1e-6
    phalanges = [side + name for side in "LR" for name in [*FINGERS, "Thumb1", "Thumb2"]]
    links = {frame.joint: frame.link for frame in pepper.tree.frames}
    ours = tuple(links[name] for name in phalanges)
    # six digits are published for the fingers' angles
    assert apart(ours, tuple(f"{name}_link" for name in phalanges)) < 1e-5


def test_columns_go_by_name_and_strangers_are_left_out(pepper: Robot) -> None:
    positions = _random(pepper, PEPPER_JOINTS, 4)
    poses = joint_poses(pepper, PEPPER_JOINTS, positions)
    joints = ("tail", *PEPPER_JOINTS[::-1])
    mixed = np.column_stack([np.ones(4), positions[:, ::-1]])
    np.testing.assert_array_equal(joint_poses(pepper, joints, mixed).wxyz, poses.wxyz)
    assert len(poses) == poses.frames == 4


def test_an_unmoved_joint_rests_within_its_limits(arm_path: Path) -> None:
    robot = load_robot(str(arm_path))
    slide = link_poses(robot, (), np.zeros((1, 0)), ("slide",))
    lifted = link_poses(robot, ("lift",), np.array([[0.2]]), ("slide",))
    np.testing.assert_allclose(slide, lifted)  # 0 is below the lower limit


def test_an_open_hand_reaches_farther_than_a_closed_one(pepper: Robot) -> None:
    tips = tuple(f"{side}_finger{n}_3" for side in "lr" for n in (1, 2, 3, 4))
    hand = link_poses(pepper, ("LHand", "RHand"), np.array([[0, 0], [1, 1]]), tips)
    wrist = link_poses(pepper, (), np.zeros((1, 0)), ("l_hand", "r_hand"))
    for i in range(len(tips)):
        reach = np.linalg.norm(hand[:, i, :3, 3] - wrist[0, i // 4, :3, 3], axis=-1)
        assert reach[1] > reach[0] + 0.01


def test_extent_at_rest(tmp_path: Path) -> None:
    low, high = extent(load_robot("pepper"))
    np.testing.assert_allclose(low[1:], [-0.25, 0], atol=0.02)
    np.testing.assert_allclose(high[1:], [0.25, 1.21], atol=0.02)
    low, high = extent(load_robot(str(write_arm(tmp_path))))
    np.testing.assert_allclose(low, [-0.15, -0.15, 0], atol=1e-6)  # its round foot
    np.testing.assert_allclose(high, [0.15, 0.15, 0.1 + 4 * 0.3 + 0.28], atol=1e-6)
