"""Forward kinematics of a whole motion at once, for any URDF.

yourdfpy moves one shared scene a frame at a time; a viewer that plays a motion needs the local
rotation of every moving joint in every frame, once, as arrays.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import yourdfpy

    from .description import Robot

MOVING_TYPES = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class MovingFrame:
    """One joint that moves, mimics included; the fixed joints above it are folded into `origin`.

    parent: index of the moving frame that carries this one, -1 for the robot's base.
    origin: (4, 4) pose in the parent frame at joint position 0, metres.
    axis: (3,) unit vector in this frame.
    driver: actuated joint that sets the position, `multiplier * q + offset`; None: always offset.
    """

    joint: str
    link: str
    parent: int
    origin: NDArray[np.float64]
    axis: NDArray[np.float64]
    prismatic: bool
    driver: str | None
    multiplier: float
    offset: float


@dataclass(frozen=True)
class KinematicTree:
    """Moving frames, each after its parent, and where every link hangs.

    links: link name -> (index of the moving frame that carries it or -1, (4, 4) pose therein).
    """

    frames: tuple[MovingFrame, ...]
    links: dict[str, tuple[int, NDArray[np.float64]]]

    @cached_property
    def origins(self) -> NDArray[np.float64]:
        """(K, 4, 4)"""
        return np.array([frame.origin for frame in self.frames]).reshape(-1, 4, 4)

    @cached_property
    def axes(self) -> NDArray[np.float64]:
        """(K, 3)"""
        return np.array([frame.axis for frame in self.frames]).reshape(-1, 3)

    @cached_property
    def sliding(self) -> NDArray[np.bool_]:
        """(K,) prismatic or not"""
        return np.array([frame.prismatic for frame in self.frames], dtype=np.bool_)

    @cached_property
    def rest(self) -> NDArray[np.float64]:
        """(K, 4) quaternions at joint position 0"""
        return quaternions(self.origins[:, :3, :3])

    @cached_property
    def spin(self) -> NDArray[np.float64]:
        """(K, 4) rest times the pure quaternion of the axis"""
        w, v = self.rest[:, :1], self.rest[:, 1:]
        scalar = -np.sum(v * self.axes, axis=-1, keepdims=True)
        return np.concatenate([scalar, w * self.axes + np.cross(v, self.axes)], axis=-1)

    @cached_property
    def offset(self) -> NDArray[np.float64]:
        """(K, 3) position in the parent frame at joint position 0"""
        return np.ascontiguousarray(self.origins[:, :3, 3])

    @cached_property
    def slide(self) -> NDArray[np.float64]:
        """(K, 3) axis in the parent frame"""
        slide: NDArray[np.float64] = np.einsum("kij,kj->ki", self.origins[:, :3, :3], self.axes)
        return slide


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


def build_tree(urdf: yourdfpy.URDF, base_link: str) -> tuple[KinematicTree, list[str]]:
    """The moving frames of a URDF below its base link, and warnings in plain words."""
    children: dict[str, list[yourdfpy.Joint]] = {}
    for joint in urdf.robot.joints:
        children.setdefault(joint.parent, []).append(joint)
    drivers, warnings = _drivers(urdf.robot.joints)
    frames: list[MovingFrame] = []
    links: dict[str, tuple[int, NDArray[np.float64]]] = {base_link: (-1, np.eye(4))}
    queue = [base_link]
    while queue:
        link = queue.pop(0)
        carrier, pose = links[link]
        for joint in children.get(link, []):
            origin = pose if joint.origin is None else pose @ joint.origin
            if joint.type in MOVING_TYPES:
                driver, multiplier, offset = drivers[joint.name]
                axis = np.asarray(joint.axis, dtype=np.float64)
                axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
                links[joint.child] = (len(frames), np.eye(4))
                prismatic = joint.type == "prismatic"
                frames.append(
                    MovingFrame(
                        joint.name, joint.child, carrier, origin, axis, prismatic,
                        driver, multiplier, offset,
                    )
                )  # fmt: skip
            else:
                links[joint.child] = (carrier, origin)
            queue.append(joint.child)
    return KinematicTree(tuple(frames), links), warnings


def _drivers(
    joints: Iterable[yourdfpy.Joint],
) -> tuple[dict[str, tuple[str | None, float, float]], list[str]]:
    """For each joint the actuated joint that it follows at last; a mimic may follow a mimic."""
    by_name = {joint.name: joint for joint in joints}
    drivers: dict[str, tuple[str | None, float, float]] = {}
    warnings: list[str] = []
    for name, joint in by_name.items():
        multiplier, offset, seen = 1.0, 0.0, {name}
        while joint.mimic is not None:
            offset += multiplier * joint.mimic.offset
            multiplier *= joint.mimic.multiplier
            target = by_name.get(joint.mimic.joint)
            if target is None or target.name in seen or target.type not in MOVING_TYPES:
                warnings.append(
                    f"joint {name} mimics {joint.mimic.joint}, which does not move; it stays still"
                )
                break
            joint = target
            seen.add(joint.name)
        drivers[name] = (None if joint.mimic is not None else joint.name, multiplier, offset)
    return drivers, warnings


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
    pose[..., :3, :3] = rotation_matrices(wxyz)
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


def size(robot: Robot) -> tuple[float, float]:
    """Half width (to both sides of the base, along y) and height of the robot at rest, metres."""
    carriers = tuple(frame.link for frame in robot.tree.frames)
    poses = link_poses(robot, (), np.zeros((1, 0)), carriers)[0]  # (K, 4, 4)
    half_width = height = 0.0
    for shape in robot.shapes:
        corners = np.array(list(product(*shape.mesh.bounds.T)))  # (8, 3)
        if shape.frame >= 0:
            corners = corners @ poses[shape.frame, :3, :3].T + poses[shape.frame, :3, 3]
        half_width = max(half_width, float(np.abs(corners[:, 1]).max()))
        height = max(height, float(corners[:, 2].max()))
    return half_width, height


def _local_poses(
    robot: Robot, joints: tuple[str, ...], positions: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(T, K, 4) quaternions and (T, K, 3) positions in the parent frames."""
    tree = robot.tree
    values = _driven(robot, joints, np.asarray(positions, dtype=np.float64))  # (T, K)
    half = np.where(tree.sliding, 0.0, values)[..., None] / 2
    # rest * (cos, sin axis) is linear in cos and sin, so a whole motion is two products
    wxyz = np.cos(half) * tree.rest + np.sin(half) * tree.spin
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


def quaternions(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K, 3, 3) rotation matrices as (K, 4) unit quaternions, w first and not negative."""
    m = matrices
    diagonal = np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]], axis=-1)
    trace = diagonal.sum(axis=-1)
    squares = np.concatenate([1 + trace[:, None], 1 + 2 * diagonal - trace[:, None]], axis=-1)
    rows = np.empty((len(m), 4, 4))  # each row is the quaternion times 4 of its own component
    rows[:, 0, 0] = squares[:, 0]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        rows[:, 0, i + 1] = rows[:, i + 1, 0] = m[:, k, j] - m[:, j, k]
        rows[:, i + 1, i + 1] = squares[:, i + 1]
        rows[:, i + 1, j + 1] = rows[:, j + 1, i + 1] = m[:, i, j] + m[:, j, i]
    best = rows[np.arange(len(m)), squares.argmax(axis=-1)]  # the largest component divides safely
    best /= np.linalg.norm(best, axis=-1, keepdims=True)
    signed: NDArray[np.float64] = np.where(best[:, :1] < 0, -best, best)
    return signed


def rotation_matrices(wxyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 4) unit quaternions as (..., 3, 3) matrices."""
    w, x, y, z = np.moveaxis(wxyz, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
