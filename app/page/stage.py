"""Where things stand in the scene: robots side by side on the floor, the camera before them.

World frame: z up, metres; robots face +x, towards the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

ROBOT_HALF_WIDTH = 0.62  # room for Pepper's arms
ROBOT_SPACING = 0.95
HEADROOM = 0.2  # metres above the head, for names and raised arms
FLOOR_IN_FRONT = 0.09  # metres below the floor's middle that the robot's base reaches in the view
FOV = math.radians(30)  # vertical
MARGIN = 1.02  # around what must be seen


@dataclass(frozen=True, eq=False)
class Stage:
    """The places for a number of robots, and what has to be in view."""

    robots: tuple[Vector, ...]  # where each one's base stands
    middle: Vector  # of all that must be seen
    half_width: float
    half_height: float


def stage_for(robots: int, half_width: float, height: float) -> Stage:
    """Robots in a row.

    Args:
        half_width, height: metres, of each robot; one that is no larger than Pepper gets its room.
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
    )


def camera_position(stage: Stage, aspect: float) -> Vector:
    """From where everything is in view in a canvas of this width to height."""
    height = max(stage.half_height, stage.half_width / max(aspect, 0.2))
    distance = MARGIN * height / math.tan(FOV / 2)
    position: Vector = stage.middle + np.array([distance, 0.0, 0.0])
    return position
