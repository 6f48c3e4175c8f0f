"""Where things stand: the boards' geometry, and a camera that has everything in view."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
import viser.transforms
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rnnpb_explorer.app.page.stage import (
    FOV,
    ROBOT_HALF_WIDTH,
    Place,
    Stage,
    Vector,
    camera_position,
    stage_for,
)

ROBOTS = pytest.mark.parametrize("robots", [1, 2, 3, 4])
PEPPER_HEIGHT = 1.25  # metres
BASE_RADIUS = 0.24

coordinate = st.floats(-2, 2)
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)


def tilted() -> Place:
    """A board that faces neither an axis nor the camera."""
    turn = viser.transforms.SO3.from_rpy_radians(0.3, -0.4, 0.5).as_matrix()
    return Place(np.array([0.2, -0.7, 1.1]), right=turn[:, 1], up=turn[:, 2], size=0.7)


def corners(place: Place) -> list[Vector]:
    half = place.size / 2
    return [place.at(x, y) for x in (-half, half) for y in (-half, half)]


def project(p: Vector, eye: Vector, width: float, height: float) -> tuple[float, float]:
    """Pixels from the top left corner, for a camera at `eye` that looks along -x, upright."""
    ahead, right, up = (p - eye) * (-1, 1, 1)
    focal = height / 2 / math.tan(FOV / 2)
    return width / 2 + focal * right / ahead, height / 2 - focal * up / ahead


def must_be_seen(stage: Stage) -> list[Vector]:
    points = corners(stage.map_board) + corners(stage.landscape_board)
    body = [
        np.array(offset)
        for side in (-1, 1)
        for offset in (
            (0.0, side * ROBOT_HALF_WIDTH, 0.0),
            (0.0, side * ROBOT_HALF_WIDTH, PEPPER_HEIGHT),
            (BASE_RADIUS, side * BASE_RADIUS, 0.0),
        )
    ]
    return points + [spot + offset for spot in stage.robots for offset in body]


# --- a place ---
@given(coordinate, coordinate, point)
@settings(deadline=None)
def test_a_ray_through_a_point_of_the_board_hits_it_there(x: float, y: float, eye: Vector) -> None:
    place = tilted()
    on_board = place.at(x, y)
    assume(abs((eye - on_board) @ place.normal) > 0.05)
    hit = place.hit(eye, on_board)
    assert hit is not None
    np.testing.assert_allclose(hit, (x, y), atol=1e-9)
    # viser reports another point of the same ray, nearer to the camera or farther away.
    np.testing.assert_allclose(place.hit(eye, eye + 0.3 * (on_board - eye)), (x, y), atol=1e-9)
    np.testing.assert_allclose(place.hit(eye, eye + 3.0 * (on_board - eye)), (x, y), atol=1e-9)


def test_a_ray_that_misses_the_plane_hits_nothing() -> None:
    place = tilted()
    eye = place.at(0.1, 0.2, ahead=2.0)
    assert place.hit(eye, eye + place.right) is None  # along the board
    assert place.hit(eye, eye + place.normal) is None  # away from it
    assert place.hit(eye, eye) is None  # nowhere
    assert place.hit(eye, eye - place.normal) == pytest.approx((0.1, 0.2))


def test_ahead_of_a_board_is_towards_the_one_who_looks() -> None:
    place = stage_for(1).map_board
    np.testing.assert_allclose(place.normal, [1, 0, 0])
    np.testing.assert_allclose(place.at(0, 0, 0.5) - place.center, [0.5, 0, 0])
    np.testing.assert_allclose(place.at(0.1, 0.2) - place.center, [0, 0.1, 0.2])


# --- the stage ---
@ROBOTS
def test_nothing_stands_in_anothers_way(robots: int) -> None:
    stage = stage_for(robots)
    assert len(stage.robots) == robots
    boards = (stage.map_board, stage.landscape_board)
    for board in boards:
        low, high = np.min(corners(board), axis=0), np.max(corners(board), axis=0)
        assert low[2] > 0  # above the floor
        for spot in stage.robots:
            assert high[1] <= spot[1] - ROBOT_HALF_WIDTH + 1e-9
    lower, upper = sorted(boards, key=lambda board: board.center[2])
    assert max(c[2] for c in corners(lower)) < min(c[2] for c in corners(upper))
    for one, other in combinations(stage.robots, 2):
        assert np.linalg.norm(one - other) >= 0.9


# --- the camera ---
@ROBOTS
@pytest.mark.parametrize("aspect", [0.6, 0.8, 1.0, 1.33, 960 / 720, 16 / 9, 2.4])
def test_everything_is_in_view_and_no_smaller_than_it_must_be(robots: int, aspect: float) -> None:
    stage = stage_for(robots)
    position = camera_position(stage, aspect)
    width, height = 1000 * aspect, 1000.0
    at = np.array([project(p, position, width, height) for p in must_be_seen(stage)])
    assert (at >= 0).all()
    assert (at <= [width, height]).all()
    span = np.ptp(at, axis=0) / [width, height]
    assert span.max() > 0.9


@given(st.floats(0.6, 2.4), st.integers(1, 4))
@settings(deadline=None)
def test_the_boards_are_in_view_in_a_window_of_any_shape(aspect: float, robots: int) -> None:
    stage = stage_for(robots)
    position = camera_position(stage, aspect)
    for place in (stage.map_board, stage.landscape_board):
        for corner in corners(place):
            x, y = project(corner, position, aspect, 1.0)
            assert 0 <= x <= aspect
            assert 0 <= y <= 1


def test_a_window_without_a_width_has_a_camera_too() -> None:
    assert np.isfinite(camera_position(stage_for(1), 0.0)).all()


def test_the_map_is_left_of_the_robot_and_above_the_landscape_as_one_sees_it() -> None:
    stage = stage_for(1)
    position = camera_position(stage, 1.5)

    def seen(p: Vector) -> tuple[float, float]:
        return project(p, position, 1500, 1000)

    board, below = seen(stage.map_board.center), seen(stage.landscape_board.center)
    assert board[0] == pytest.approx(below[0])
    assert board[1] < below[1]
    assert board[0] < seen(stage.robots[0])[0]


def test_a_large_robot_has_its_room() -> None:
    stage = stage_for(2, half_width=1.0, height=3.0)
    assert max(c[1] for c in corners(stage.map_board)) <= -1.0 + 1e-9
    assert stage.robots[1][1] - stage.robots[0][1] >= 2.0
    position = camera_position(stage, 4 / 3)
    for y, z in ((-1.0, 0.0), (3.0, 0.0), (0.0, 3.0)):
        at = project(np.array([0.0, y, z]), position, 4 / 3, 1.0)
        assert 0 <= at[0] <= 4 / 3
        assert 0 <= at[1] <= 1
