"""Where things stand: robots that leave each other room, and a camera that has them all in view."""

from __future__ import annotations

import math
from itertools import pairwise, product

import numpy as np
import pytest

from rnnpb_explorer.app.page.stage import (
    FOV,
    ROBOT_HALF_WIDTH,
    Stage,
    Vector,
    camera_position,
    stage_for,
)

ROBOTS = pytest.mark.parametrize("robots", [1, 2, 3, 5])
PEPPER = (0.55, 1.21)  # half width, height, metres
BASE_RADIUS = 0.24


def project(p: Vector, eye: Vector, width: float, height: float) -> tuple[float, float]:
    """Pixels from the top left corner, for a camera at `eye` that looks along -x, upright."""
    ahead, right, up = (p - eye) * (-1, 1, 1)
    focal = height / 2 / math.tan(FOV / 2)
    return width / 2 + focal * right / ahead, height / 2 - focal * up / ahead


def must_be_seen(stage: Stage, half_width: float, height: float) -> list[Vector]:
    return [
        spot + np.array(offset)
        for spot in stage.robots
        for side in (-1, 1)
        for offset in (
            (0.0, side * half_width, 0.0),
            (0.0, side * half_width, height),
            (BASE_RADIUS, side * BASE_RADIUS, 0.0),  # the feet
        )
    ]


@ROBOTS
def test_nothing_stands_in_anothers_way(robots: int) -> None:
    spots = stage_for(robots, *PEPPER).robots
    assert len(spots) == robots
    for one, other in pairwise(spots):
        np.testing.assert_allclose(other - one, [0, 1.1, 0])


@ROBOTS
@pytest.mark.parametrize("aspect", [0.5, 0.8, 1.0, 570 / 590, 16 / 9, 3.0])
def test_everything_is_in_view_and_no_smaller_than_it_must_be(robots: int, aspect: float) -> None:
    stage = stage_for(robots, *PEPPER)
    position = camera_position(stage, aspect)
    width, height = 1000 * aspect, 1000.0
    points = must_be_seen(stage, ROBOT_HALF_WIDTH, PEPPER[1])
    at = np.array([project(p, position, width, height) for p in points])
    assert (at >= 0).all()
    assert (at <= [width, height]).all()
    span = np.ptp(at, axis=0) / [width, height]
    assert span.max() > 0.75


def test_a_canvas_without_a_width_has_a_camera_too() -> None:
    assert np.isfinite(camera_position(stage_for(1, *PEPPER), 0.0)).all()


def test_a_large_robot_has_its_room() -> None:
    stage = stage_for(2, half_width=1.0, height=3.0)
    assert stage.robots[1][1] - stage.robots[0][1] == 2.0
    position = camera_position(stage, 4 / 3)
    for point in must_be_seen(stage, 1.0, 3.0):
        x, y = project(point, position, 4 / 3, 1.0)
        assert 0 <= x <= 4 / 3
        assert 0 <= y <= 1


def test_what_reaches_towards_the_camera_is_in_view_too() -> None:
    stage = stage_for(1, *PEPPER, 1.2)
    position = camera_position(stage, 4 / 3)
    for side, up in product((-0.3, 0.3), (0.0, 0.9)):
        x, y = project(np.array([1.2, side, up]), position, 4 / 3, 1.0)
        assert 0 <= x <= 4 / 3
        assert 0 <= y <= 1
