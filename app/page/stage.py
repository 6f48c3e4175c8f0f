"""Where things stand in the scene: robots side by side on the floor, the camera before them.

World frame: z up, metres; robots face +x, towards the camera. A robot that is much smaller or
larger than a person is shown as large as Pepper: camera, light, shadows, floor and names suit it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...robot.description import Robot
from ...robot.kinematics import extent
from ...robot.tree import KinematicTree, MovingFrame

Vector = NDArray[np.float64]

ROBOT_HALF_WIDTH = 0.62  # room for Pepper's arms
ROBOT_SPACING = 0.95
HEADROOM = 0.2  # metres above the head, for names and raised arms
FLOOR_IN_FRONT = 0.09  # metres below the floor's middle that the robot's base reaches in the view
FOV = math.radians(30)  # vertical
MARGIN = 1.02  # around what must be seen
AS_IT_IS = (0.6, 1.8)  # metres, the largest side of robots that are shown in their own size
SHOWN_SIZE = 1.2  # metres, of all others
SMALLEST = 1e-6  # metres, of a robot of which anything can be seen
FRONT = 0.38  # metres, how far Pepper reaches towards the camera


@dataclass(frozen=True, eq=False)
class Stage:
    """The places for a number of robots, and what has to be in view."""

    robots: tuple[Vector, ...]  # where each one's base stands
    middle: Vector  # of all that must be seen
    half_width: float
    half_height: float
    front: float = FRONT  # how far robots reach towards the camera


def staged(robot: Robot) -> Robot:
    """The robot with its lowest point on the floor, in the size in which it is shown."""
    low, high = extent(robot)
    largest = float((high - low).max())
    as_it_is = AS_IT_IS[0] <= largest <= AS_IT_IS[1] or largest < SMALLEST
    scale = 1.0 if as_it_is else SHOWN_SIZE / largest
    lift = np.array([0.0, 0.0, -scale * low[2]])

    def frame(one: MovingFrame) -> MovingFrame:
        origin = _placed(one.origin, scale, lift, one.parent)
        slide = scale if one.prismatic else 1.0
        return replace(
            one, origin=origin, multiplier=slide * one.multiplier, offset=slide * one.offset
        )

    tree = KinematicTree(
        tuple(map(frame, robot.tree.frames)),
        {
            link: (carrier, _placed(pose, scale, lift, carrier))
            for link, (carrier, pose) in robot.tree.links.items()
        },
        joined={},
    )
    to_scale = np.diag([scale, scale, scale, 1.0])
    shapes = [
        shape.moved(_placed(to_scale, 1.0, lift, shape.frame))
        if scale != 1 or shape.frame < 0
        else shape
        for shape in robot.shapes
    ]
    size = () if as_it_is else (f"{largest:.3g} m large, shown {scale:.3g} times its size",)
    return replace(robot, tree=tree, shapes=tuple(shapes), warnings=(*size, *robot.warnings))


def _placed(pose: Vector, scale: float, lift: Vector, parent: int) -> Vector:
    """A pose (4, 4) scaled; lifted where it is one in the base's frame."""
    placed = pose.copy()
    placed[:3, 3] *= scale
    if parent < 0:
        placed[:3, 3] += lift
    return placed


def room_of(robot: Robot) -> tuple[float, float, float]:
    """Half width (to both sides of the base), height, and how far it reaches to the front."""
    low, high = extent(robot)
    return float(np.abs([low[1], high[1]]).max()), float(high[2]), float(high[0])


def stage_for(robots: int, half_width: float, height: float, front: float = FRONT) -> Stage:
    """Robots in a row.

    Args:
        half_width, height: metres, of each robot; one that is no larger than Pepper gets its room.
        front: metres that each reaches towards the camera.
    """
    room = max(ROBOT_HALF_WIDTH, half_width)
    spacing = max(ROBOT_SPACING, 2 * half_width)
    spots = tuple(np.array([0.0, i * spacing, 0.0]) for i in range(robots))
    left, right = -room, (robots - 1) * spacing + room
    top, bottom = height + HEADROOM, -FLOOR_IN_FRONT
    return Stage(
        spots,
        middle=np.array([0.0, (left + right) / 2, (top + bottom) / 2]),
        half_width=(right - left) / 2,
        half_height=(top - bottom) / 2,
        front=max(front, FRONT),
    )


def camera_position(stage: Stage, aspect: float) -> Vector:
    """From where everything is in view in a canvas of this width to height."""
    height = max(stage.half_height, stage.half_width / max(aspect, 0.2))
    distance = MARGIN * height / math.tan(FOV / 2) + stage.front - FRONT
    position: Vector = stage.middle + np.array([distance, 0.0, 0.0])
    return position
