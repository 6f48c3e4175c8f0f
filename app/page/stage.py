"""Where things stand in the scene: robots on the floor, boards beside them, the camera before.

World frame: z up, metres; robots face +x, towards the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

BOARD_SIZE = 0.72  # metres; two of them, one above the other, are a little taller than Pepper
BOARD_GAP = 0.03
ROBOT_HALF_WIDTH = 0.62  # room for Pepper's arms
ROBOT_SPACING = 0.95
FOV = math.radians(30)  # vertical; a narrow one keeps the boards square
FLOOR_IN_FRONT = 0.09  # metres below the floor's middle that the robot's base reaches in the view
MARGIN = 1.02  # around what must be seen


@dataclass(frozen=True, eq=False)
class Place:
    """An upright rectangle: its centre, and unit vectors to the right and up as one sees it."""

    center: Vector
    right: Vector
    up: Vector
    size: float  # metres

    @property
    def normal(self) -> Vector:
        """Towards the one who looks at it."""
        normal: Vector = np.cross(self.right, self.up)
        return normal

    def at(self, x: float, y: float, ahead: float = 0.0) -> Vector:
        """World position of a point x right of and y above the centre, `ahead` of the surface."""
        return self.center + x * self.right + y * self.up + ahead * self.normal

    def hit(self, origin: Vector, through: Vector) -> tuple[float, float] | None:
        """Where the ray from `origin` through a point meets the plane: metres right and above."""
        direction = through - origin
        slope = float(direction @ self.normal)
        if abs(slope) < 1e-9:
            return None
        distance = float((self.center - origin) @ self.normal) / slope
        if distance <= 0:
            return None
        offset = origin + distance * direction - self.center
        return float(offset @ self.right), float(offset @ self.up)


@dataclass(frozen=True, eq=False)
class Stage:
    """The places for a number of robots."""

    robots: tuple[Vector, ...]  # where each one's base stands
    map_board: Place
    landscape_board: Place
    middle: Vector  # of all that must be seen
    half_width: float
    half_height: float


def stage_for(robots: int, half_width: float = 0.0, height: float = 0.0) -> Stage:
    """The map above the landscape on the left, robots side by side on the right.

    Args:
        half_width, height: metres, of each robot; one that is no larger than Pepper gets its room.
    """
    room = max(ROBOT_HALF_WIDTH, half_width)
    spacing = max(ROBOT_SPACING, 2 * half_width)
    spots = tuple(np.array([0.0, i * spacing, 0.0]) for i in range(robots))
    left = -room - BOARD_SIZE
    right = (robots - 1) * spacing + room
    top, bottom = max(2 * BOARD_SIZE + 3 * BOARD_GAP, height), -FLOOR_IN_FRONT
    return Stage(
        spots,
        map_board=_board(left, bottom=2 * BOARD_GAP + BOARD_SIZE),
        landscape_board=_board(left, bottom=BOARD_GAP),
        middle=np.array([0.0, (left + right) / 2, (top + bottom) / 2]),
        half_width=(right - left) / 2,
        half_height=(top - bottom) / 2,
    )


def _board(left: float, bottom: float) -> Place:
    return Place(
        center=np.array([0.0, left + BOARD_SIZE / 2, bottom + BOARD_SIZE / 2]),
        right=np.array([0.0, 1.0, 0.0]),
        up=np.array([0.0, 0.0, 1.0]),
        size=BOARD_SIZE,
    )


def camera_position(stage: Stage, aspect: float) -> Vector:
    """From where everything is in view in a window of this width to height."""
    height = max(stage.half_height, stage.half_width / max(aspect, 0.2))
    distance = MARGIN * height / math.tan(FOV / 2)
    position: Vector = stage.middle + np.array([distance, 0.0, 0.0])
    return position
