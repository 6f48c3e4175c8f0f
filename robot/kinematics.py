"""Forward kinematics of a whole motion at once, for any URDF.

yourdfpy moves one shared scene a frame at a time; a viewer that plays a motion needs the local
rotation of every moving joint in every frame, once, as arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .description import Robot


@dataclass(frozen=True)
class JointPoses:
    """The pose of every moving frame in its parent frame, through a motion.

    names: (K,) joint names, each after its parent's.
    wxyz: (T, K, 4) unit quaternions. position: (T, K, 3) metres.
    """

    names: tuple[str, ...]
    wxyz: NDArray[np.float32]
    position: NDArray[np.float32]

    @property
    def frames(self) -> int:
        return len(self.wxyz)

    def __len__(self) -> int:
        return len(self.wxyz)


def joint_poses(
    robot: Robot, joints: tuple[str, ...], positions: NDArray[np.floating]
) -> JointPoses:
    """The local pose of every moving frame of the robot in every frame of a motion.

    Args:
        joints: (J,) the names of the motion's columns; those that the robot lacks are left out.
        positions: (T, J) radians (metres for a prismatic joint), as they are: not clamped. Pepper's
            LHand and RHand are openings from 0 to 1, which its fingers mimic. A joint of the robot
            that is no column stays at 0, or at the nearest value that its limits allow.
    """
    wxyz, position = _local_poses(robot, joints, positions)
    names = tuple(frame.joint for frame in robot.tree.frames)
    return JointPoses(names, wxyz.astype(np.float32), position.astype(np.float32))


def link_poses(
    robot: Robot,
    joints: tuple[str, ...],
    positions: NDArray[np.floating],
    links: tuple[str, ...],
) -> NDArray[np.float64]:
    """(T, L, 4, 4): where the links are in the robot's base frame; arguments as `joint_poses`."""
    wxyz, position = _local_poses(robot, joints, positions)
    pose = np.zeros((*wxyz.shape[:2], 4, 4))
    turned = Rotation.from_quat(wxyz.reshape(-1, 4), scalar_first=True)
    pose[..., :3, :3] = turned.as_matrix().reshape(*wxyz.shape[:2], 3, 3)
    pose[..., :3, 3] = position
    pose[..., 3, 3] = 1.0
    for k, frame in enumerate(robot.tree.frames):  # parents come first
        if frame.parent >= 0:
            pose[:, k] = pose[:, frame.parent] @ pose[:, k]
    out = np.empty((len(pose), len(links), 4, 4))
    for i, link in enumerate(links):
        carrier, offset = robot.tree.links[link]
        out[:, i] = offset if carrier < 0 else pose[:, carrier] @ offset
    return out


@lru_cache(maxsize=16)
def extent(robot: Robot) -> NDArray[np.float64]:
    """(2, 3): the lowest and highest x, y and z of the robot at rest, in its base frame, metres."""
    carriers = tuple(frame.link for frame in robot.tree.frames)
    poses = link_poses(robot, (), np.zeros((1, 0)), carriers)[0]  # (K, 4, 4)
    bounds = []
    for shape in robot.shapes:
        points = shape.mesh.vertices
        if shape.frame >= 0:
            points = points @ poses[shape.frame, :3, :3].T + poses[shape.frame, :3, 3]
        bounds += [points.min(axis=0), points.max(axis=0)]
    return np.stack([np.min(bounds, axis=0), np.max(bounds, axis=0)])


def _local_poses(
    robot: Robot, joints: tuple[str, ...], positions: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(T, K, 4) quaternions and (T, K, 3) positions in the parent frames."""
    tree = robot.tree
    values = _driven(robot, joints, np.asarray(positions, dtype=np.float64))  # (T, K)
    half = np.where(tree.sliding, 0.0, values)[..., None] / 2
    # A turn by q is (cos q/2, sin q/2 axis): linear in cos and sin, ten times as fast as one
    # Rotation a frame and joint.
    wxyz = np.cos(half) * tree.rest_wxyz + np.sin(half) * tree.half_turn_wxyz
    position = tree.offset + np.where(tree.sliding, values, 0.0)[..., None] * tree.slide
    return wxyz, position


def _driven(
    robot: Robot, joints: tuple[str, ...], positions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(T, K) position of every moving frame's joint, mimics resolved."""
    if positions.ndim != 2 or positions.shape[1] != len(joints):
        raise ValueError(f"positions {positions.shape} do not fit {len(joints)} joints")
    column = {joint: i for i, joint in enumerate(joints)}
    values = np.empty((len(positions), len(robot.tree.frames)))
    for k, frame in enumerate(robot.tree.frames):
        driver = frame.driver
        if driver is None:
            values[:, k] = frame.offset
        elif driver in column:
            values[:, k] = frame.multiplier * positions[:, column[driver]] + frame.offset
        else:
            values[:, k] = frame.multiplier * robot.neutral(driver) + frame.offset
    return values
