"""A robot's nodes in a viser scene, made once; the page poses them (`static/web/robots.js`)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import viser

from ...robot.description import Robot
from ...robot.meshes import Shape, to_glb
from ...robot.pepper import EYE_LEDS
from .shown import RobotShown

EYE_LINKS = tuple(f"{side}_eye_led_{led}" for side in "rl" for led in range(EYE_LEDS))
EYE_GLOW = (89, 180, 255)  # of eyes that nothing colours


def node_names(robot: Robot, root: str) -> tuple[str, ...]:
    """The scene node of each moving frame below `root`, parents first."""
    names: list[str] = []
    for frame in robot.tree.frames:
        parent = root if frame.parent < 0 else names[frame.parent]
        names.append(f"{parent}/{frame.joint.replace('/', '_')}")
    return tuple(names)


def eye_nodes(robot: Robot, root: str) -> tuple[str, ...]:
    """The scene nodes of the LED segments, right eye first; none where the robot has not all."""
    links = {shape.link for shape in robot.shapes}
    if not links.issuperset(EYE_LINKS):
        return ()
    names = node_names(robot, root)
    carrier = robot.tree.links[EYE_LINKS[0]][0]
    return tuple(f"{names[carrier]}/{link}" for link in EYE_LINKS)


def add_robot(scene: viser.SceneApi, robot: Robot, root: str) -> None:
    """Add a robot at rest below `root`; to the server's scene, so that pages share it."""
    rest = robot.tree.rest_wxyz
    offset = robot.tree.offset
    names = node_names(robot, root)
    scene.add_frame(root, show_axes=False)
    for k, name in enumerate(names):
        scene.add_frame(name, show_axes=False, wxyz=rest[k], position=offset[k])
    eyes = eye_nodes(robot, root)
    for index, glb in _glbs(robot, bool(eyes)).items():
        parent = root if index < 0 else names[index]
        # no shadows on it: shadow maps speckle curved shells
        scene.add_glb(f"{parent}/shape", glb, cast_shadow=True, receive_shadow=False)
    segments = {shape.link: shape.mesh for shape in robot.shapes if shape.link in EYE_LINKS}
    for name, link in zip(eyes, EYE_LINKS, strict=False):
        scene.add_mesh_simple(
            name,
            np.asarray(segments[link].vertices, dtype=np.float32),
            np.asarray(segments[link].faces, dtype=np.uint32),
            color=EYE_GLOW,
            cast_shadow=False,
            receive_shadow=False,
        )


def robot_shown(
    robot: Robot,
    joints: Sequence[str],
    root: str,
    *,
    name: str = "",
    spot: Sequence[float] = (0.0, 0.0, 0.0),
    copy_of: int | None = None,
) -> RobotShown:
    """What the page needs to pose a robot of `add_robot`.

    Args:
        joints: (J,) names of a motion's columns; a joint that is none of them rests where its
            limits allow.
        root: as in `add_robot`; of the robot that it copies where `copy_of` is its index.
        spot: (3,) metres.
    """
    tree = robot.tree
    column = {joint: i for i, joint in enumerate(joints)}
    columns, offsets = [], []
    for frame in tree.frames:
        index = -1 if frame.driver is None else column.get(frame.driver, -1)
        rests = 0.0 if frame.driver is None or index >= 0 else robot.neutral(frame.driver)
        columns.append(index)
        offsets.append(frame.offset + frame.multiplier * rests)
    return RobotShown(
        name=name or robot.name,
        root=root,
        nodes=node_names(robot, root),
        rest_wxyz=tree.rest_wxyz,
        rest_position=tree.offset,
        axes=tree.axes,
        sliding=tree.sliding,
        columns=np.array(columns, dtype=np.int32),
        factors=np.array([frame.multiplier for frame in tree.frames]),
        offsets=np.array(offsets),
        spot=np.asarray(spot, dtype=np.float32),
        eyes=eye_nodes(robot, root),
        copy_of=copy_of,
    )


@lru_cache(maxsize=16)
def _glbs(robot: Robot, eyes_apart: bool) -> dict[int, bytes]:
    """One GLB for each moving frame that carries shapes; -1 is the base."""
    shapes: dict[int, list[Shape]] = {}
    for shape in robot.shapes:
        if not (eyes_apart and shape.link in EYE_LINKS):
            shapes.setdefault(shape.frame, []).append(shape)
    return {index: to_glb(group) for index, group in sorted(shapes.items())}
