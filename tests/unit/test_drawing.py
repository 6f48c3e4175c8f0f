"""Boards: pixels at known data coordinates, and the map between the two."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rnnpb_explorer.app.page.boards.drawing import (
    Board,
    PlotFrame,
    RecognitionPath,
    axis_names,
    draw_landscape,
    draw_map,
    landscape_frame,
    map_frame,
    style_points,
)
from rnnpb_explorer.app.page.boards.labels import Label, place_labels
from rnnpb_explorer.app.page.boards.masks import text_sprite, text_width
from rnnpb_explorer.app.page.boards.palette import (
    PATH_ENDS,
    PATH_STRONG,
    SAMPLE,
    SELECTED,
    UNKNOWN,
    WARNING,
    correlation_colors,
)
from rnnpb_explorer.app.page.boards.plot import Area, area_of, nice_ticks
from rnnpb_explorer.core.correlation import landscape_stages
from rnnpb_explorer.core.latent_map import LatentMap
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.windows import Landscape

Pixels = NDArray[np.uint8]
SIZE = 512
finite = st.floats(-1e3, 1e3)


def landscape(
    correlation: NDArray[np.floating], x: float = 0.0, y: float = 0.0, complete: bool = True
) -> Landscape:
    rows, columns = correlation.shape
    ys = y + np.linspace(-1, 1, rows) if rows > 1 else np.zeros(1)
    xs = x + np.linspace(-1, 1, columns)
    return Landscape(correlation.astype(np.float32), xs, ys, complete)


def random_landscape(rows: int = 20, columns: int = 20, seed: int = 0) -> Landscape:
    values = np.random.default_rng(seed).uniform(-1, 1, (rows, columns))
    return landscape(values, x=-1.3, y=0.4)


def pixel(board: Board, x: float, y: float) -> list[int]:
    """The colour at data coordinates."""
    column, row = board.frame.to_uv([x, y]) * len(board.picture)
    color: list[int] = board.picture[int(row), int(column)].tolist()
    return color


def close(a: object, b: object, tolerance: int = 12) -> bool:
    return bool(np.abs(np.subtract(a, b, dtype=int)).max() <= tolerance)  # type: ignore[call-overload]


def plot_area(board: Board) -> tuple[slice, slice]:
    area = area_of(board.frame, len(board.picture))
    return slice(area.top, area.bottom), slice(area.left, area.right)


def changed(a: Board, b: Board) -> NDArray[np.bool_]:
    """(size, size) which pixels differ."""
    different: NDArray[np.bool_] = (a.picture != b.picture).any(axis=-1)
    return different


def changed_outside_plot(a: Board, b: Board) -> int:
    different = changed(a, b)
    different[plot_area(a)] = False
    return int(different.sum())


def cloud(count: int = 30, seed: int = 1) -> NDArray[np.float64]:
    """Points on a jittered grid: no two under one mark."""
    rng = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(count)))
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    points: NDArray[np.float64] = grid[:count] + rng.uniform(-0.1, 0.1, (count, 2))
    return points


# --- the frame ---


@st.composite
def frames(draw: st.DrawFn) -> PlotFrame:
    low_x, low_y = draw(finite), draw(finite)
    span_x, span_y = draw(st.floats(1e-3, 1e3)), draw(st.floats(1e-3, 1e3))
    left, top = draw(st.floats(0, 0.4)), draw(st.floats(0, 0.4))
    right, bottom = draw(st.floats(0.6, 1)), draw(st.floats(0.6, 1))
    return PlotFrame((low_x, low_x + span_x), (low_y, low_y + span_y), left, top, right, bottom)


@given(frames(), st.lists(st.tuples(finite, finite), min_size=1, max_size=5))
def test_data_survives_the_way_to_picture_and_board_and_back(
    frame: PlotFrame, points: list[tuple[float, float]]
) -> None:
    data = np.array(points)
    # float64 resolves a narrow range far from 0 only this well
    span = max(*np.abs(frame.x_range), *np.abs(frame.y_range), np.abs(data).max(), 1.0)
    uv = frame.to_uv(data)
    np.testing.assert_allclose(frame.to_data(uv), data, rtol=0, atol=1e-11 * span)
    at = frame.to_board(data, 0.9, 1.2)
    np.testing.assert_allclose(frame.from_board(at, 0.9, 1.2), data, rtol=0, atol=1e-11 * span)


def test_y_points_up_and_the_board_is_centred() -> None:
    frame = PlotFrame((-2.0, 2.0), (0.0, 10.0), 0.1, 0.2, 0.9, 0.8)
    np.testing.assert_allclose(
        frame.to_uv([[-2, 0], [2, 10], [0, 5]]), [[0.1, 0.8], [0.9, 0.2], [0.5, 0.5]]
    )
    np.testing.assert_allclose(frame.to_board([2, 10], 0.9, 1.2), [0.36, 0.36])
    np.testing.assert_allclose(frame.clamp([7.0, -3.0]), [2.0, 0.0])
    assert frame.contains(np.array([[0, 5], [2, 10], [2.1, 5]])).tolist() == [True, True, False]


@given(st.floats(-1e4, 1e4), st.floats(1e-4, 1e4))
@example(6.1e-05, 1e-4)
@example(0.9999, 2e-4)
def test_ticks_are_round_few_and_inside(low: float, span: float) -> None:
    ticks = nice_ticks(low, low + span)
    values = [value for value, _ in ticks]
    assert 2 <= len(values) <= 8
    assert all(low - span * 1e-3 <= value <= low + span * 1.001 for value in values)
    labels = [label for _, label in ticks]
    assert len(set(labels)) == len(labels)
    for value, label in ticks:
        assert float(label.replace("−", "-")) == pytest.approx(value, abs=span * 0.02)


def test_tick_labels_have_a_true_minus_and_no_negative_zero() -> None:
    assert [label for _, label in nice_ticks(-1.0, 1.0, most=4)] == [
        "−1.0",
        "−0.5",
        "0.0",
        "0.5",
        "1.0",
    ]


# --- the landscape ---


@settings(max_examples=12, deadline=None)
@given(st.integers(2, 45), st.integers(2, 45), st.sampled_from([256, 512]))
def test_every_cell_has_its_colour_where_its_values_are(rows: int, columns: int, size: int) -> None:
    """Row = second axis, upwards; column = first axis, to the right."""
    given_ = random_landscape(rows, columns, seed=rows)
    board = draw_landscape(given_, size=size)
    expected = correlation_colors(given_.correlation)
    for row, column in [(0, 0), (0, columns - 1), (rows - 1, 0), (rows // 2, columns // 3)]:
        seen = pixel(board, float(given_.x[column]), float(given_.y[row]))
        assert seen == expected[row, column].tolist()


def test_colour_scale_is_the_papers() -> None:
    """Red -1, white 0, blue 1, as in Fig. 4."""
    negative, zero, positive = correlation_colors([-1.0, 0.0, 1.0]).tolist()
    assert negative[0] > 90 > 40 > max(negative[1], negative[2])
    assert min(zero) > 240
    assert positive[2] > 90 > positive[1] > positive[0]
    assert correlation_colors([7.0]).tolist() == [positive]
    assert correlation_colors([np.nan]).tolist() == [list(UNKNOWN)]


# Machado, Oliveira, Fernandes 2009, severity 1: how the world looks to the colour-blind.
COLOUR_BLIND = {
    "protan": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "deutan": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "tritan": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}


@pytest.mark.parametrize("kind", COLOUR_BLIND)
def test_colour_scale_tells_signs_apart_to_the_colour_blind(kind: str) -> None:
    strengths = np.linspace(0.3, 1, 15)
    blue, red = correlation_colors(strengths), correlation_colors(-strengths)
    matrix = np.array(COLOUR_BLIND[kind])

    def seen(colors: Pixels) -> NDArray[np.float64]:
        linear = (colors / 255.0) ** 2.2
        result: NDArray[np.float64] = np.clip(linear @ matrix.T, 0, 1) ** (1 / 2.2) * 255
        return result

    assert np.linalg.norm(seen(blue) - seen(red), axis=1).min() > 30
    brightness = seen(blue) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(brightness) < 0).all()  # the stronger the darker


def test_best_cells_are_outlined() -> None:
    values = np.full((10, 10), 0.2)
    values[4:6, 4:6] = 0.95
    values[5, 5] = 1.0
    given_ = landscape(values)
    board = draw_landscape(given_, size=SIZE)
    edge = float((given_.x[3] + given_.x[4]) / 2)
    middle = float(given_.y[4])
    assert close(pixel(board, edge, middle), SELECTED)
    assert not close(pixel(board, -edge - 0.4, middle), SELECTED)
    values[0, 0] = np.nan  # which has no say in it
    board = draw_landscape(landscape(values), size=SIZE)
    assert close(pixel(board, edge, middle), SELECTED)
    flat = draw_landscape(landscape(np.full((10, 10), 0.2)), size=SIZE)
    inside = flat.picture[plot_area(flat)]
    assert (inside == correlation_colors(np.float32(0.2))).all()


def test_unknown_cells_are_grey_and_harmless() -> None:
    values = np.full((4, 4), 0.5)
    values[1, 2] = np.nan
    given_ = landscape(values)
    assert pixel(draw_landscape(given_, size=SIZE), given_.x[2], given_.y[1]) == list(UNKNOWN)
    draw_landscape(landscape(np.full((4, 4), np.nan)), size=SIZE)


def test_coarse_and_complete_differ_in_words_only() -> None:
    values = random_landscape().correlation
    coarse = draw_landscape(landscape(values, complete=False), size=SIZE)
    complete = draw_landscape(landscape(values), size=SIZE)
    different = changed(coarse, complete)
    assert different.any()
    assert not different[plot_area(coarse)].any()


@pytest.mark.parametrize(
    "words",
    [
        {"title": "Happy_4"},
        {"window": "±0.7 sd"},
        {"note": "target: own reconstruction"},
        {"x_label": "PC1 (41 %)"},
        {"y_label": "PC2"},
    ],
)
def test_words_stand_outside_the_plot(words: dict[str, str]) -> None:
    plain = draw_landscape(random_landscape(), size=SIZE)
    other = draw_landscape(random_landscape(), size=SIZE, **words)  # type: ignore[arg-type]
    assert changed_outside_plot(plain, other) > 20
    assert not changed(plain, other)[plot_area(plain)].any()


def test_numbers_follow_the_values() -> None:
    a, b = random_landscape(seed=1), random_landscape(seed=2)
    assert changed_outside_plot(draw_landscape(a, size=SIZE), draw_landscape(b, size=SIZE)) > 20


def test_one_dimension_is_drawn_as_columns() -> None:
    values = np.linspace(-0.9, 0.9, 10)[None]
    given_ = landscape(values)
    board = draw_landscape(given_, y_label=None, size=SIZE)
    assert board.frame.y_range == (-1.0, 1.0)
    for column in (0, 2, 7, 9):
        x, value = float(given_.x[column]), float(values[0, column])
        assert pixel(board, x, value / 2) == correlation_colors(np.float32(value)).tolist()
        assert min(pixel(board, x, -value / 2)) > 225  # the other side of zero is empty


def test_redrawing_gives_the_same_picture_whatever_was_done_to_the_last() -> None:
    first = draw_landscape(random_landscape(), size=SIZE)
    kept = first.picture.copy()
    first.picture[...] = 0
    assert (draw_landscape(random_landscape(), size=SIZE).picture == kept).all()
    assert kept.shape == (SIZE, SIZE, 3)
    assert kept.dtype == np.uint8


def test_landscape_frame_is_the_drawn_one() -> None:
    assert (
        landscape_frame(random_landscape(), SIZE)
        == draw_landscape(random_landscape(), size=SIZE).frame
    )


def test_learned_mu_is_marked() -> None:
    board = draw_landscape(random_landscape(), learned=(-1.0, 0.7), size=SIZE)
    assert close(pixel(board, -1.0, 0.7), SELECTED)


# --- a recognition's path ---


def a_path(current: int | None = None) -> RecognitionPath:
    mu = np.array([[0.5, 0.5], [2.0, 0.5], [2.0, 3.0], [3.5, 3.5]])
    sigma = np.array([[1.0], [0.8], [0.5], [0.1]]) * np.ones((4, 4))
    pb = np.array([[1.0, 4.5], [4.6, 2.0], [0.2, 3.2]])
    return RecognitionPath(mu, sigma, pb, current)


def path_map(path: RecognitionPath | None) -> Board:
    return draw_map(np.array([[0.0, 0.0], [5.0, 5.0]]), path=path, size=1024)


def test_path_runs_from_dot_to_cross_through_its_points() -> None:
    board = path_map(a_path())
    assert close(pixel(board, 0.5, 0.5), PATH_ENDS)
    assert close(pixel(board, 3.5, 3.5), PATH_ENDS)
    assert close(pixel(board, 2.0, 1.5), PATH_STRONG, 40)  # half way between two iterations
    assert close(pixel(board, 4.6, 2.0), SAMPLE, 40)


def test_circles_shrink_with_sigma() -> None:
    board, empty = path_map(a_path()), path_map(None)

    def beside(x: float, y: float) -> bool:
        """Is it painted 20 pixels off, inside a circle of sigma 0.8 and outside one of 0.5?"""
        column, row = (board.frame.to_pixels([x, y], 1024) + 14).astype(int)
        return bool((board.picture[row, column] != empty.picture[row, column]).any())

    assert beside(2.0, 0.5)
    assert not beside(3.5, 3.5)


def test_scrubbing_draws_up_to_the_current_iteration() -> None:
    at_one, empty, full = path_map(a_path(1)), path_map(None), path_map(a_path())
    assert close(pixel(at_one, 4.6, 2.0), SAMPLE, 40)  # sampled at iteration 1
    assert pixel(at_one, 0.2, 3.2) == pixel(empty, 0.2, 3.2)  # at iteration 2
    assert close(pixel(full, 0.2, 3.2), SAMPLE, 40)
    assert close(pixel(at_one, 2.0, 0.5), PATH_ENDS)  # here it stands
    faint, strong = pixel(at_one, 2.0, 1.5), pixel(full, 2.0, 1.5)
    assert sum(strong) < sum(faint) < 3 * 250
    assert (path_map(a_path(99)).picture == full.picture).all()


def test_path_stays_inside_the_plot_wherever_it_goes() -> None:
    wild = np.array(
        [[0.5, 0.5], [1e12, -1e12], [np.nan, 0.0], [np.inf, 1.0], [-1e3, 2.0], [2.0, 2.0]]
    )
    path = RecognitionPath(wild, np.full((6, 4), np.inf), wild)
    board, empty = path_map(path), path_map(None)
    assert changed(board, empty).any()
    assert changed_outside_plot(board, empty) == 0
    (left, right), (bottom, top) = empty.frame.x_range, empty.frame.y_range
    corners = np.array([[left, bottom], [left, top], [right, top], [right, bottom]])
    for current in range(4):
        path = RecognitionPath(corners, np.ones((4, 4)), corners, current)
        assert changed_outside_plot(path_map(path), empty) == 0
    given_ = random_landscape()
    on_landscape = draw_landscape(given_, path=path, size=SIZE)
    assert changed_outside_plot(on_landscape, draw_landscape(given_, size=SIZE)) == 0


def test_path_on_the_landscape_is_in_its_coordinates() -> None:
    board = draw_landscape(
        random_landscape(),
        path=RecognitionPath(np.array([[-1.9, 0.0], [-0.8, 0.9]]), np.ones((2, 4))),
        size=SIZE,
    )
    assert close(pixel(board, -1.9, 0.0), PATH_ENDS)
    assert close(pixel(board, -0.8, 0.9), PATH_ENDS)


@pytest.mark.parametrize("rows", [0, 1, 2])
def test_short_paths_are_fine(rows: int) -> None:
    path_map(RecognitionPath(np.ones((rows, 2)), np.ones((rows, 3)), np.ones((rows, 2)), rows - 1))


# --- the map ---


def test_points_lie_where_their_values_are_in_their_colours() -> None:
    points = cloud()
    style = style_points("class", classes=[f"class {i // 2}" for i in range(30)])
    board = draw_map(points, style=style, size=SIZE)
    for point, color in zip(points, style.rgb.tolist(), strict=True):
        assert pixel(board, *point) == color


def test_points_far_from_the_slice_are_smaller_and_fainter() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]])
    board = draw_map(points, off_plane=[0.0, 1.0, 5.0, 1.0], size=1024)
    near, middle, far = (sum(pixel(board, *point)) for point in points[:3])
    assert near < middle < far < 3 * 250
    reach = 11 / 1024 * (board.frame.x_range[1] - board.frame.x_range[0])
    assert sum(pixel(board, reach, 0.0)) == near
    assert sum(pixel(board, 2 + reach, 0.0)) > far


def test_selected_point_has_a_ring_and_its_name() -> None:
    points = cloud()
    names = [f"Motion_{i}" for i in range(30)]
    plain = draw_map(points, names=names, size=1024)
    board = draw_map(points, names=names, selected=8, size=1024)
    column, row = board.frame.to_pixels(points[8], 1024).astype(int)
    assert close(board.picture[row, column + 19], SELECTED)
    dark = (board.picture[plot_area(board)].max(axis=-1) < 60).sum()
    assert dark > (plain.picture[plot_area(plain)].max(axis=-1) < 60).sum() + 150


def test_names_are_those_nearest_to_the_puck() -> None:
    points = cloud(25)
    names = [f"M{i}" for i in range(25)]
    alone = {"near": points[12], "max_labels": 3, "name_others": False, "size": SIZE}
    bare = draw_map(points, **alone)
    board = draw_map(points, names=names, **alone)
    rows, columns = np.nonzero(changed(bare, board))
    where = board.frame.to_data(np.stack([columns / SIZE, rows / SIZE], axis=1))
    assert len(where) > 100
    assert np.linalg.norm(where - points[12], axis=1).max() < 2.2
    # the same points, but the nearest ones are far off the slice: others are named
    apart = np.where(np.linalg.norm(points - points[12], axis=1) < 1.6, 100.0, 0.0)
    there = draw_map(points, names=names, off_plane=apart, **alone)
    plain = draw_map(points, off_plane=apart, **alone)
    rows, columns = np.nonzero(changed(plain, there))
    where = board.frame.to_data(np.stack([columns / SIZE, rows / SIZE], axis=1))
    assert np.linalg.norm(where - points[12], axis=1).max() > 1.6
    # and where there is room, all are
    everyone = draw_map(points, names=names, near=points[12], size=1024)
    bare = draw_map(points, near=points[12], size=1024)
    for point in points:
        row, column = everyone.frame.to_pixels(point, 1024)[::-1].astype(int)
        window = slice(row - 60, row + 60), slice(column - 90, column + 90)
        assert changed(everyone, bare)[window].sum() > 30


@given(
    st.lists(st.tuples(st.integers(0, 400), st.integers(0, 400)), min_size=1, max_size=40),
    st.booleans(),
)
@settings(deadline=None)
def test_names_never_cover_each_other_and_stay_inside(
    points: list[tuple[int, int]], on_a_line: bool
) -> None:
    area = Area(50, 60, 450, 440, 512)
    pixels = np.array(points, dtype=np.float64)
    if on_a_line:
        pixels[:, 1] = 250
    weights = ["strong", *["plain"] * 7, *["quiet"] * 40]
    labels = [Label(i, f"AskForAttention_{i}_tr", weights[i]) for i in range(len(points))]  # type: ignore[arg-type]
    puck = pixels[-1]
    placed = place_labels(
        area, labels, pixels, np.full(len(points), 6.0), puck=puck, on_a_line=on_a_line
    )
    boxes = [one.box for one in placed]
    assert any(one.label.weight == "strong" for one in placed)
    for i, (left, top, right, bottom) in enumerate(boxes):
        assert area.left <= left < right <= area.right
        assert area.top <= top < bottom <= area.bottom
        for other in boxes[:i]:
            assert left >= other[2] or other[0] >= right or top >= other[3] or other[1] >= bottom
    for one in placed:
        left, top, right, bottom = one.box
        beside_x = left > puck[0] + 12 or right < puck[0] - 12
        beside_y = top > puck[1] + 12 or bottom < puck[1] - 12
        assert beside_x or beside_y or one.label.weight == "strong"


def test_ellipse_passes_one_and_two_sigma() -> None:
    points = np.array([[-3.0, -3.0], [3.0, 3.0]])
    covariance = np.diag([0.25, 1.0])
    board = draw_map(points, ellipse=covariance, ellipse_center=(0.0, 0.0), size=1024)
    for x, y in [(0.5, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -2.0)]:
        assert close(pixel(board, x, y), SELECTED, 70), (x, y)
    assert sum(pixel(board, 0.25, 0.3)) < sum(pixel(board, 0.7, 0.3)) < sum(pixel(board, 1.2, 0.3))


def test_no_sigma_no_ellipse() -> None:
    points = cloud()
    without = draw_map(points, selected=3, size=SIZE)
    zero = draw_map(points, selected=3, ellipse=np.zeros((2, 2)), size=SIZE)
    assert (zero.picture == without.picture).all()
    thin = draw_map(points, selected=3, ellipse=[[1.0, 1.0], [1.0, 1.0]], size=SIZE)
    assert changed(thin, without).any()


def test_extrapolation_is_marked_above_one_only() -> None:
    points = cloud()
    plain = draw_map(points, size=SIZE)
    assert (draw_map(points, extrapolation=1.0, size=SIZE).picture == plain.picture).all()
    marked = draw_map(points, extrapolation=1.7, size=SIZE)
    area = area_of(marked.frame, SIZE)
    assert marked.picture[area.top, area.left + 50].tolist() == list(WARNING)
    assert changed_outside_plot(plain, marked) > 100
    draw_map(points, extrapolation=float("inf"), size=SIZE)


def test_one_dimension_lies_on_a_line() -> None:
    points = np.linspace(-2, 2, 9)[:, None]
    style = style_points("arousal", values=np.linspace(0, 1, 9))
    board = draw_map(
        points,
        style=style,
        names=[f"M{i}" for i in range(9)],
        selected=4,
        near=[0.1],
        ellipse=[[0.04]],
        y_label=None,
        path=None,
        size=SIZE,
    )
    assert board.frame.y_range == (-1.0, 1.0)
    for i in (0, 2, 8):
        assert close(pixel(board, float(points[i, 0]), 0.0), style.rgb[i])
    assert min(pixel(board, 0.02, 0.3)) < 240  # under the bell
    assert min(pixel(board, -1.55, 0.3)) > 250
    line = RecognitionPath(np.array([[-1.0], [1.1]]), np.ones((2, 1)), np.array([[0.5]]))
    drawn = draw_map(points, y_label=None, path=line, size=SIZE)
    assert close(pixel(drawn, -1.0, 0.0), PATH_ENDS)
    assert close(pixel(drawn, 0.5, 0.0), PATH_STRONG, 60)


@pytest.mark.parametrize("dimensions", [1, 2])
def test_one_motion_is_enough(dimensions: int) -> None:
    point = np.full((1, dimensions), 0.7)
    label = None if dimensions == 1 else "PC2"
    board = draw_map(
        point, names=["Happy"], selected=0, near=point[0], off_plane=[0.0], y_label=label, size=SIZE
    )
    assert board.frame.contains([0.7, 0.7 if dimensions == 2 else 0.0])
    low, high = board.frame.x_range
    assert high - low == pytest.approx(4.0)
    assert axis_names(point) == (("PC1", None) if dimensions == 1 else ("PC1", "PC2"))


def test_empty_and_strange_names_are_fine() -> None:
    points = cloud(4)
    draw_map(points, names=["", "", "", ""], selected=0, near=points[0], size=SIZE)
    draw_map(points, names=(), selected=2, near=points[0], size=SIZE)
    draw_map(
        points, names=["a\nb" * 200, "é ∂ 漢字", " ", "x"], selected=0, near=points[0], size=SIZE
    )
    draw_landscape(random_landscape(), title="a\tb\n" * 99, note="", window="", size=SIZE)


@given(
    st.lists(st.tuples(finite, finite), min_size=1, max_size=12),
    st.lists(st.tuples(finite, finite), max_size=4),
)
def test_map_frame_shows_everything_at_one_scale(
    points: list[tuple[float, float]], more: list[tuple[float, float]]
) -> None:
    frame = map_frame(points, include=more or None)
    assert frame.contains(points + more).all()
    scale_x = (frame.right - frame.left) / (frame.x_range[1] - frame.x_range[0])
    scale_y = (frame.bottom - frame.top) / (frame.y_range[1] - frame.y_range[0])
    assert scale_x == pytest.approx(scale_y, rel=0.01)


def test_axis_names_carry_the_share_of_variance() -> None:
    points = np.array([[3.0, 1.0, 0.0], [-3.0, 1.0, 0.0], [3.0, -1.0, 0.0], [-3.0, -1.0, 0.0]])
    assert axis_names(points) == ("PC1 (90 %)", "PC2 (10 %)")
    assert axis_names(points, (2, 0)) == ("PC3 (0 %)", "PC1 (90 %)")


def test_map_redraws_to_the_same_picture() -> None:
    points = cloud()
    first = draw_map(points, selected=1, path=a_path(2), size=SIZE)
    kept = first.picture.copy()
    first.picture[...] = 0
    assert (draw_map(points, selected=1, path=a_path(2), size=SIZE).picture == kept).all()


def test_boards_of_a_real_model(tiny_model: RNNPB) -> None:
    """What the numerics give is what the boards take; coarse and complete lie on one frame."""
    mu, sigma = tiny_model.mu.numpy(), tiny_model.sigma.numpy()
    latent_map = LatentMap.fit(mu)
    x_label, y_label = axis_names(latent_map.points)
    board = draw_map(
        latent_map.points[:, :2],
        selected=1,
        off_plane=latent_map.off_plane(mu[1], (0, 1)),
        near=latent_map.project(mu[1])[:2],
        ellipse=latent_map.ellipse(sigma[1], (0, 1)),
        extrapolation=latent_map.extrapolation(mu[1] + 9),
        names=tiny_model.info.motions,
        x_label=x_label,
        y_label=y_label,
        size=SIZE,
    )
    assert board.frame.contains(latent_map.points[:, :2]).all()
    target = tiny_model.reconstruct(0, 20)
    stages = list(landscape_stages(tiny_model, target, mu[0]))
    coarse, complete = (draw_landscape(stage, size=SIZE) for stage in stages)
    assert coarse.frame == complete.frame
    center = complete.frame.to_data([(coarse.frame.left + coarse.frame.right) / 2, 0.5])
    assert center[0] == pytest.approx(mu[0, 0], abs=1e-6)


# --- palette and text ---


def test_a_class_has_one_look_and_no_two_classes_share_it() -> None:
    classes = [f"class {i:02}" for i in range(36)] * 2
    style = style_points("class", classes=classes)
    looks = list(zip(map(tuple, style.rgb.tolist()), style.shapes, strict=True))
    assert looks[:36] == looks[36:]
    assert len(set(looks)) == 36


def test_ratings_run_along_their_scale_and_unknown_ones_are_grey() -> None:
    for by in ("valence", "arousal"):
        style = style_points(by, values=[0.0, 0.5, 1.0, None, float("nan")])
        assert len({tuple(color) for color in style.rgb.tolist()}) == 4
        assert style.rgb[3].tolist() == style.rgb[4].tolist() == list(UNKNOWN)
        assert style.rgb[0].tolist() == style.legend.table[0].tolist()
        assert style.rgb[2].tolist() == style.legend.table[-1].tolist()


def test_legend_follows_the_colouring() -> None:
    points = cloud(4)
    boards = [
        draw_map(points, style=style, size=SIZE)
        for style in (
            style_points("class", classes=list("abcd")),
            style_points("valence", values=[0.1] * 4),
            style_points("arousal", values=[0.1] * 4),
        )
    ]
    assert changed_outside_plot(boards[0], boards[1]) > 100
    assert changed_outside_plot(boards[1], boards[2]) > 100


def test_font_has_what_the_boards_write() -> None:
    missing = text_sprite("\U0010ffff", 40).ink.tobytes()
    for letter in "μσβ×±−·…→²°éñ":
        assert text_sprite(letter, 40).ink.tobytes() != missing, letter


def test_dimension_numbers_are_set_small() -> None:
    assert text_width("μ12", 40) < text_width("μ", 40) + text_width("12", 40) - 5
