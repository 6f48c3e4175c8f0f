"""What moves in a robot description: a tree of frames, and the links that hang on them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .urdf_file import LARGEST

if TYPE_CHECKING:
    import yourdfpy

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
    joined: link name -> (3,) where the joints to other links are, in the frame that carries it.
    """

    frames: tuple[MovingFrame, ...]
    links: dict[str, tuple[int, NDArray[np.float64]]]
    joined: dict[str, list[NDArray[np.float64]]]

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
    def rest(self) -> Rotation:
        """(K,) at joint position 0"""
        return Rotation.from_matrix(self.origins[:, :3, :3])

    @cached_property
    def rest_wxyz(self) -> NDArray[np.float64]:
        """(K, 4) quaternions of `rest`"""
        return np.asarray(self.rest.as_quat(scalar_first=True))

    @cached_property
    def half_turn_wxyz(self) -> NDArray[np.float64]:
        """(K, 4) quaternions after half a turn, by pi, from `rest` about the axis"""
        turned = self.rest * Rotation.from_rotvec(np.pi * self.axes)
        return np.asarray(turned.as_quat(scalar_first=True))

    @cached_property
    def offset(self) -> NDArray[np.float64]:
        """(K, 3) position in the parent frame at joint position 0"""
        return np.ascontiguousarray(self.origins[:, :3, 3])

    @cached_property
    def rest_poses(self) -> NDArray[np.float64]:
        """(K, 4, 4) in the base's frame at joint position 0"""
        poses = self.origins.copy()
        for k, frame in enumerate(self.frames):  # parents come first
            if frame.parent >= 0:
                poses[k] = poses[frame.parent] @ poses[k]
        return poses

    @cached_property
    def slide(self) -> NDArray[np.float64]:
        """(K, 3) axis in the parent frame"""
        slide: NDArray[np.float64] = self.rest.apply(self.axes)
        return slide


def build_tree(urdf: yourdfpy.URDF, base_link: str) -> tuple[KinematicTree, list[str]]:
    """The moving frames of a URDF below its base link, and warnings in plain words."""
    children: dict[str, list[yourdfpy.Joint]] = {}
    for joint in urdf.robot.joints:
        children.setdefault(joint.parent, []).append(joint)
    drivers, warnings = _drivers(urdf.robot.joints)
    frames: list[MovingFrame] = []
    links: dict[str, tuple[int, NDArray[np.float64]]] = {base_link: (-1, np.eye(4))}
    joined: dict[str, list[NDArray[np.float64]]] = {}
    queue = [base_link]
    while queue:
        link = queue.pop(0)
        carrier, pose = links[link]
        joined[link] = []
        for joint in children.get(link, []):
            origin = pose if joint.origin is None else pose @ joint.origin
            joined[link].append(origin[:3, 3])
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
    return KinematicTree(tuple(frames), links, joined), warnings


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
            if (
                target is None
                or target.name in seen
                or target.type not in MOVING_TYPES
                or abs(multiplier) > LARGEST
            ):
                warnings.append(
                    f"joint {name} mimics {joint.mimic.joint}, which does not move; it stays still"
                )
                break
            joint = target
            seen.add(joint.name)
        drivers[name] = (None if joint.mimic is not None else joint.name, multiplier, offset)
    return drivers, warnings
