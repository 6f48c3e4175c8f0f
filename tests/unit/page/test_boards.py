"""What a hand on a board asks for, and what the boards show of a picture; no browser is needed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser

from rnnpb_explorer.app.page.boards.board import PUCK_AHEAD, BoardView
from rnnpb_explorer.app.page.boards.drawing import Board
from rnnpb_explorer.app.page.boards.landscape_view import LandscapeView
from rnnpb_explorer.app.page.boards.map_view import MapView
from rnnpb_explorer.app.page.stage import camera_position, stage_for
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.facts import Array, Facts
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.planes import on_landscape
from rnnpb_explorer.app.state.results import LandscapeResult
from rnnpb_explorer.core.windows import Landscape

from ..app_states import (
    FACTS,
    LANDSCAPE,
    ONE_DIMENSION,
    TWELVE_DIMENSIONS,
    Page,
    hand_on,
    landscape_result,
    make_facts,
    make_target,
    make_trace,
)
from .pictures import Clock, after, came_to, open_screen, opening

STAGE = stage_for(1)
EYE = camera_position(STAGE, 1.5)
ALL_SIZES = pytest.mark.parametrize(
    "facts", [ONE_DIMENSION, FACTS, TWELVE_DIMENSIONS], ids=["D1", "D3", "D12"]
)
TWO_DIMENSIONS = (make_facts(2, "flat"),)


class Hand:
    """A person's hand on a board, as viser reports it: rays from the camera through a point."""

    def __init__(self, board: BoardView) -> None:
        self.board = board

    def _world(self, x: float, y: float) -> Array:
        size = self.board.place.size
        across, up = self.board.frame.to_board([x, y], size, size)
        return self.board.place.at(float(across), float(up))

    def _ray(self, x: float, y: float) -> Array:
        """viser's point lies on a plane that faces the camera, not on the board."""
        return EYE + 0.4 * (self._world(x, y) - EYE)

    def drag(self, *points: tuple[float, float], shift: bool = False) -> None:
        phases = ["start", *["update"] * (len(points) - 2), "end"]
        for phase, (x, y) in zip(phases, points, strict=True):
            self.send(phase, self._ray(x, y), shift)

    def send(self, phase: str, through: Array, shift: bool = False) -> None:
        event = SimpleNamespace(
            phase=phase,
            client=SimpleNamespace(camera=SimpleNamespace(position=EYE)),
            end_position=tuple(through),
            modifier="shift" if shift else None,
        )
        hand_on(self.board._on_drag(event))  # type: ignore[arg-type]

    def click(self, x: float, y: float) -> None:
        direction = self._world(x, y) - EYE
        event = SimpleNamespace(ray_origin=tuple(EYE), ray_direction=tuple(direction))
        hand_on(self.board._on_click(event))  # type: ignore[arg-type]


class Setup:
    """A board of each kind on the scene of a server that nobody looks at."""

    def __init__(self, scene: viser.SceneApi, picture: Picture) -> None:
        self.sent: list[do.Intent] = []
        self.clock = Clock()
        self.map = MapView(scene, STAGE.map_board, picture, self.sent.append, self.clock)
        self.landscape = LandscapeView(
            scene, STAGE.landscape_board, picture, self.sent.append, self.clock
        )

    def show(self, picture: Picture) -> None:
        self.clock.now += 1.0
        self.map.show(picture)
        self.landscape.show(picture)


Make = Callable[..., Setup]


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    made = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield made
    made.stop()


@pytest.fixture
def make(server: viser.ViserServer) -> Make:
    def setup(facts: Facts = FACTS, picture: Picture | None = None) -> Setup:
        return Setup(server.scene, open_screen(facts) if picture is None else picture)

    return setup


def middle_of(board: BoardView) -> tuple[float, float]:
    (left, right), (bottom, top) = board.frame.x_range, board.frame.y_range
    return (left + right) / 2, (bottom + top) / 2


def test_a_touch_that_comes_at_once_finds_the_boards_ready(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    on_click = viser.ImageHandle.on_click

    def clicked(image: viser.ImageHandle, callback: Callable[..., Any]) -> None:
        on_click(image, callback)
        direction = np.asarray(image.position) - EYE
        event = SimpleNamespace(ray_origin=tuple(EYE), ray_direction=tuple(direction))
        hand_on(callback(event))

    monkeypatch.setattr(viser.ImageHandle, "on_click", clicked)
    on_map, on_landscape = make().sent
    assert isinstance(on_map, (do.MoveOnMap, do.SelectMotion))
    assert isinstance(on_landscape, do.MoveOnLandscape)


# --- the puck ---
@ALL_SIZES
def test_the_puck_stands_where_mu_is(make: Make, facts: Facts) -> None:
    picture = open_screen(facts)
    boards = make(facts, picture)
    boards.show(picture)
    coordinates = facts[0].latent_map.project(picture.choice.latent.mu)
    for board, at in (
        (boards.map.board, [coordinates[axis] for axis in picture.document.map_axes]),
        (
            boards.landscape.board,
            on_landscape(facts[0], picture.document, picture.choice.latent.mu),
        ),
    ):
        size = board.place.size
        hit = board.place.hit(EYE, board.puck - PUCK_AHEAD * board.place.normal)
        assert hit is not None
        shown = board.frame.from_board(hit, size, size)
        np.testing.assert_allclose(shown[: len(at)], at, atol=1e-6)


def test_a_puck_outside_of_the_picture_waits_at_its_rim(make: Make) -> None:
    boards = make()
    picture = after(open_screen(), do.SetMu(0, 15.0), do.SetMu(1, -15.0))
    boards.show(picture)
    board = boards.map.board
    offset = board.puck - board.place.center
    assert (np.abs(offset[1:]) < board.place.size / 2).all()


def test_the_puck_stands_before_the_board(make: Make) -> None:
    boards = make()
    boards.show(open_screen())
    for board in (boards.map.board, boards.landscape.board):
        assert (board.puck - board.place.center) @ board.place.normal == pytest.approx(PUCK_AHEAD)


# --- dragging on the map ---
@ALL_SIZES
def test_a_drag_on_the_map_asks_for_the_pointers_place(make: Make, facts: Facts) -> None:
    boards = make(facts)
    x, y = middle_of(boards.map.board)
    Hand(boards.map.board).drag((x, y), (x + 0.1, y), (x + 0.2, y + 0.1))
    axes = open_screen(facts).document.map_axes
    moves = [intent for intent in boards.sent if isinstance(intent, do.MoveOnMap)]
    assert len(moves) == len(boards.sent) == 3
    assert {move.axes for move in moves} == {axes}
    expected = [(x, y), (x + 0.1, y), (x + 0.2, y + 0.1)]
    np.testing.assert_allclose(
        [move.to for move in moves], [point[: len(axes)] for point in expected], atol=1e-9
    )


def test_one_drag_is_one_gesture_and_the_next_another(make: Make) -> None:
    boards = make()
    for board in (boards.map.board, boards.landscape.board, boards.map.board):
        at = middle_of(board)
        Hand(board).drag(at, at, at)
    gestures = [
        intent.gesture
        for intent in boards.sent
        if isinstance(intent, do.MoveOnMap | do.MoveOnLandscape)
    ]
    assert len(gestures) == 9
    assert len({*gestures[:3]}) == len({*gestures[3:6]}) == len({*gestures[6:]}) == 1
    assert len(set(gestures)) == 3


def test_two_browsers_never_share_a_gesture(make: Make) -> None:
    """The numbers go into the states' undo; a browser must not go on with another's drag."""
    one, other = make(), make()
    for boards in (one, other):
        at = middle_of(boards.map.board)
        Hand(boards.map.board).drag(at, at)
    (first, *_), (second, *_) = one.sent, other.sent
    assert isinstance(first, do.MoveOnMap)
    assert isinstance(second, do.MoveOnMap)
    assert first.gesture != second.gesture


def test_a_drag_past_the_rim_stays_at_it(make: Make) -> None:
    boards = make()
    frame = boards.map.board.frame
    Hand(boards.map.board).drag(middle_of(boards.map.board), (frame.x_range[1] + 9.0, 0.0))
    last = boards.sent[-1]
    assert isinstance(last, do.MoveOnMap)
    assert last.to[0] == pytest.approx(frame.x_range[1])


def test_a_drag_uses_the_axes_that_are_shown(make: Make) -> None:
    boards = make(TWELVE_DIMENSIONS)
    boards.show(after(open_screen(TWELVE_DIMENSIONS), do.SetMapAxes((4, 7))))
    at = middle_of(boards.map.board)
    Hand(boards.map.board).drag(at, at)
    assert isinstance(boards.sent[0], do.MoveOnMap)
    assert boards.sent[0].axes == (4, 7)


def test_with_shift_the_pointers_way_moves_the_next_components(make: Make) -> None:
    facts = TWELVE_DIMENSIONS
    picture = open_screen(facts)
    boards = make(facts, picture)
    boards.show(picture)
    before = facts[0].latent_map.project(picture.choice.latent.mu)
    x, y = middle_of(boards.map.board)
    Hand(boards.map.board).drag((x, y), (x + 0.3, y - 0.2), (x + 0.5, y), shift=True)
    moves = [intent for intent in boards.sent if isinstance(intent, do.MoveOnMap)]
    assert {move.axes for move in moves} == {(2, 3)}
    ways = np.array([[0.0, 0.0], [0.3, -0.2], [0.5, 0.0]])
    np.testing.assert_allclose([move.to for move in moves], before[[2, 3]] + ways, atol=1e-9)


def test_a_second_drag_with_shift_begins_where_the_components_are(make: Make) -> None:
    facts = TWELVE_DIMENSIONS
    boards = make(facts)
    at = middle_of(boards.map.board)
    Hand(boards.map.board).drag(at, (at[0] + 0.3, at[1]), shift=True)
    picture = after(open_screen(facts), boards.sent[-1])
    boards.show(picture)
    boards.sent.clear()
    Hand(boards.map.board).drag(at, at, shift=True)
    now = facts[0].latent_map.project(picture.choice.latent.mu)
    assert isinstance(boards.sent[0], do.MoveOnMap)
    np.testing.assert_allclose(boards.sent[0].to, now[[2, 3]], atol=1e-9)


@pytest.mark.parametrize(
    ("facts", "hidden"),
    [(ONE_DIMENSION, None), (TWO_DIMENSIONS, None), (FACTS, (2,)), (TWELVE_DIMENSIONS, (2, 3))],
)
def test_shift_moves_what_is_hidden_and_nothing_else(
    make: Make, facts: Facts, hidden: tuple[int, ...] | None
) -> None:
    boards = make(facts)
    at = middle_of(boards.map.board)
    Hand(boards.map.board).drag(at, at, shift=True)
    axes = [intent.axes for intent in boards.sent if isinstance(intent, do.MoveOnMap)]
    assert axes == ([] if hidden is None else [hidden, hidden])


# --- clicking on the map ---
@ALL_SIZES
def test_a_click_on_a_point_selects_its_motion(make: Make, facts: Facts) -> None:
    boards = make(facts)
    axes = list(open_screen(facts).document.map_axes)
    for index, point in enumerate(facts[0].latent_map.points[:, axes]):
        boards.sent.clear()
        Hand(boards.map.board).click(float(point[0]), float(point[1]) if len(axes) > 1 else 0.0)
        assert boards.sent == [do.SelectMotion(index)]


def test_a_click_elsewhere_moves_the_puck_there(make: Make) -> None:
    boards = make()
    frame = boards.map.board.frame
    corner = frame.x_range[0], frame.y_range[1]
    Hand(boards.map.board).click(*corner)
    (move,) = boards.sent
    assert isinstance(move, do.MoveOnMap)
    np.testing.assert_allclose(move.to, corner, atol=1e-9)


# --- the landscape ---
@ALL_SIZES
def test_a_drag_on_the_landscape_asks_for_values_of_its_axes(make: Make, facts: Facts) -> None:
    boards = make(facts)
    x, y = middle_of(boards.landscape.board)
    Hand(boards.landscape.board).drag((x, y), (x + 0.1, y + 0.2))
    last = boards.sent[-1]
    assert isinstance(last, do.MoveOnLandscape)
    axes = min(facts[0].pb_dim, 2)
    np.testing.assert_allclose(last.to, (x + 0.1, y + 0.2)[:axes], atol=1e-9)


@ALL_SIZES
def test_before_the_first_landscape_its_window_is_there(make: Make, facts: Facts) -> None:
    picture = opening(facts)
    board = make(facts, picture).landscape.board
    axes = list(picture.document.map_axes)
    middle = middle_of(board)[: len(axes)]
    np.testing.assert_allclose(middle, np.array(picture.choice.anchor)[axes], atol=1e-9)
    left, right = board.frame.x_range
    assert 2.0 <= right - left < 2.2  # +-1 and half a cell


# --- rays that mean nothing ---
def test_a_ray_that_misses_the_board_asks_for_nothing(make: Make) -> None:
    boards = make()
    for board in (boards.map.board, boards.landscape.board):
        hand = Hand(board)
        hand.send("start", EYE + board.place.right)  # past it
        hand.send("update", EYE + board.place.normal)  # away from it
        hand.send("end", EYE)
        hand.send("end", np.array([np.nan, 0.0, 0.0]))
    assert boards.sent == []


# --- redrawing ---
def count_pictures(board: BoardView, monkeypatch: pytest.MonkeyPatch) -> list[object]:
    drawn: list[object] = []
    show = board.show_picture

    def counted(picture: Board) -> None:
        drawn.append(picture.frame)
        show(picture)

    monkeypatch.setattr(board, "show_picture", counted)
    return drawn


def test_a_picture_is_drawn_anew_only_for_what_it_shows(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = open_screen()
    boards = make(FACTS, picture)
    on_map = count_pictures(boards.map.board, monkeypatch)
    on_plane = count_pictures(boards.landscape.board, monkeypatch)
    for _ in range(3):
        picture = after(picture, do.Tick(0.1), do.Seek(3), do.SetJoint("b"))
        boards.show(picture)
    assert (on_map, on_plane) == ([], [])
    picture = after(picture, do.SetColouring("valence"))
    boards.show(picture)
    boards.show(picture)
    assert (len(on_map), len(on_plane)) == (1, 0)
    picture = after(picture, do.SetMu(0, 0.6))
    boards.show(picture)
    assert (len(on_map), len(on_plane)) == (2, 0)  # the landscape is the same, the puck moves


def test_while_much_changes_pictures_are_few_and_the_last_one_is_right(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = open_screen()
    boards = make(FACTS, picture)
    drawn = count_pictures(boards.map.board, monkeypatch)
    boards.clock.now += 10.0
    for step in range(20):
        picture = after(picture, do.SetMu(0, 0.01 * step))
        boards.map.show(picture)
    assert len(drawn) == 1
    boards.show(picture)
    assert len(drawn) == 2
    boards.show(picture)
    assert len(drawn) == 2


def test_a_path_that_leaves_the_map_widens_it(make: Make) -> None:
    picture = after(open_screen(), do.SetTarget(make_target()), do.StartRecognition())
    boards = make(FACTS, picture)
    before = boards.map.board.frame
    far = np.array([[[0.0, 0.0, 0.0]], [[9.0, 9.0, 9.0]], [[0.1, 0.1, 0.1]]])
    picture = came_to(picture, make_trace(far))
    boards.show(picture)
    frame = boards.map.board.frame
    for mu in far[:, 0]:
        assert frame.contains(FACTS[0].latent_map.project(mu)[:2])
    picture = after(picture, do.CancelRecognition(), do.ClearTarget())
    boards.show(picture)
    assert boards.map.board.frame == before


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_path_that_runs_away_is_drawn_as_far_as_it_goes(make: Make, value: float) -> None:
    picture = after(open_screen(), do.SetTarget(make_target()), do.StartRecognition())
    boards = make(FACTS, picture)
    before = boards.map.board.frame
    lost = np.array([[[0.1, 0.1, 0.1]], [[0.2, 0.1, 0.1]], [[value] * 3]])
    picture = came_to(picture, make_trace(lost))
    boards.show(picture)
    frame = boards.map.board.frame
    assert np.isfinite([*frame.x_range, *frame.y_range]).all()
    if not np.isfinite(value):
        assert frame == before


def test_a_landscape_becomes_complete_on_the_board(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = Page().compute()
    page.do(do.SetMu(2, 0.9)).deliver(LANDSCAPE, landscape_result(complete=False), done=False)
    boards = make(FACTS, page.picture)
    drawn = count_pictures(boards.landscape.board, monkeypatch)
    axis = np.linspace(-1.0, 1.0, 20)
    better = Landscape(np.ones((20, 20), np.float32), axis, axis)
    boards.show(page.deliver(LANDSCAPE, LandscapeResult(better)).picture)
    boards.show(page.picture)
    assert len(drawn) == 1


# --- side by side ---
def test_the_boards_turn_to_the_active_model(make: Make) -> None:
    facts = (FACTS[0], ONE_DIMENSION[0], TWELVE_DIMENSIONS[0])
    picture = open_screen(facts)
    boards = make(facts, picture)
    for index, axes in ((1, (0,)), (2, (0, 1)), (0, (0, 1))):
        picture = after(picture, do.SelectModel(index))
        boards.show(picture)
        boards.sent.clear()
        Hand(boards.map.board).drag(*[middle_of(boards.map.board)] * 2)
        Hand(boards.landscape.board).drag(*[middle_of(boards.landscape.board)] * 2)
        on_map, _, on_plane, _ = boards.sent
        assert isinstance(on_map, do.MoveOnMap)
        assert isinstance(on_plane, do.MoveOnLandscape)
        assert on_map.axes == axes
        assert len(on_plane.to) == len(axes)
        for board in (boards.map.board, boards.landscape.board):
            assert np.isfinite(board.puck).all()
