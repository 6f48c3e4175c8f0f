"""Where things stand in the scene: robots on the floor, a board on either side, the camera before them.

World frame: z up, metres; robots face +x, towards the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

BOARD_SIZE = 1.2  # metres
ROBOT_HALF_WIDTH = 0.52  # room for Pepper's arms
ROBOT_SPACING = 0.95
FOV = math.radians(30)  # vertical; a narrow one keeps the boards square
LOOK_AT = np.array([0.0, 0.0, 0.72])
CAMERA_HEIGHT = 0.95
MARGIN = 1.04


@dataclass(frozen=True, eq=False)
class Place:
    """An upright rectangle: its centre, and unit vectors to its right and upwards as one sees it."""

    center: Vector
    right: Vector
    up: Vector
    size: float  # metres

    @property
    def normal(self) -> Vector:
        """Towards the one who looks at it."""
        return np.cross(self.right, self.up)

    def at(self, x: float, y: float, ahead: float = 0.0) -> Vector:
        """World position of a point x right of and y above the centre, `ahead` of the surface."""
        return self.center + x * self.right + y * self.up + ahead * self.normal

    def hit(self, origin: Vector, through: Vector) -> tuple[float, float] | None:
        """Where the ray from `origin` through a point meets the plane, right of and above the centre."""
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
    half_width: float  # of all that must be seen, metres


def stage_for(robots: int) -> Stage:
    """Robots side by side in the middle, the map on the left, the landscape on the right."""
    middle = (robots - 1) / 2
    spots = tuple(np.array([0.0, (i - middle) * ROBOT_SPACING, 0.0]) for i in range(robots))
    inner = ROBOT_HALF_WIDTH + middle * ROBOT_SPACING
    offset = inner + BOARD_SIZE / 2
    return Stage(
        spots,
        map_board=_board(-offset),
        landscape_board=_board(offset),
        half_width=offset + BOARD_SIZE / 2,
    )


def _board(y: float) -> Place:
    return Place(
        center=np.array([0.0, y, 0.06 + BOARD_SIZE / 2]),
        right=np.array([0.0, 1.0, 0.0]),
        up=np.array([0.0, 0.0, 1.0]),
        size=BOARD_SIZE,
    )


def camera_position(stage: Stage, aspect: float) -> Vector:
    """From where everything is in view in a window of this width to height."""
    half_height = 0.75
    tangent = math.tan(FOV / 2)
    distance = MARGIN * max(stage.half_width / (tangent * max(aspect, 0.2)), half_height / tangent)
    return np.array([distance, 0.0, CAMERA_HEIGHT])


def project(
    point: Vector, position: Vector, wxyz: Vector, fov: float, width: float, height: float
) -> tuple[float, float]:
    """A world point in pixels of the 3D view, from its top left corner.

    Args:
        position, wxyz: the camera's, which looks along its own +z with -y up (OpenCV).
        fov: vertical, radians.
    """
    w, x, y, z = wxyz / np.linalg.norm(wxyz)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    local = rotation.T @ (point - position)
    focal = height / 2 / math.tan(fov / 2)
    return (
        float(width / 2 + focal * local[0] / local[2]),
        float(height / 2 + focal * local[1] / local[2]),
    )
