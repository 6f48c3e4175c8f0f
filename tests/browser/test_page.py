"""The page as it opens: complete, quiet, and everything in view."""

from __future__ import annotations

import numpy as np
import pytest
from explorer_page import ExplorerPage, Open, agree

from rnnpb_explorer.app.page.stage import BOARD_SIZE

BOARDS = ("/boards/map", "/boards/landscape")
ROBOT = "/robot-0"


def assert_boards_in_view(explorer: ExplorerPage) -> None:
    """Both boards lie in the canvas as a whole, and no panel hides any part of them."""
    left, top, width, height = explorer.canvas_box()
    for board in BOARDS:
        corners = np.array(explorer.corners(board, (BOARD_SIZE, BOARD_SIZE)))
        low, high = corners.min(axis=0), corners.max(axis=0)
        assert left <= low[0] < high[0] <= left + width, board
        assert top <= low[1] < high[1] <= top + height, board
        shares = np.linspace(0.02, 0.98, 9)
        points = [tuple(low + (high - low) * (x, y)) for x in shares for y in shares]
        assert set(explorer.topmost(points)) == {"CANVAS"}, f"a panel covers {board}"


def test_page_opens_without_an_alert(explorer: ExplorerPage) -> None:
    for tab in ("Explore", "Joints", "Recognise", "Robot", "View", "Help"):
        explorer.tab(tab)
    assert not explorer.page.get_by_role("alert").filter(visible=True).count()


def test_page_offers_no_tunnel_to_the_outside(explorer: ExplorerPage) -> None:
    assert explorer.page.get_by_text("Share", exact=True).count() == 0
    assert explorer.page.locator(".tabler-icon-share").count() == 0


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1920, 1080)])
def test_both_boards_are_in_view(open_explorer: Open, width: int, height: int) -> None:
    explorer = open_explorer(width, height, resolution=1)
    assert_boards_in_view(explorer)
    rows, columns = explorer.region(BOARDS[0], BOARD_SIZE)
    assert min(rows.stop - rows.start, columns.stop - columns.start) >= 300  # pixels: legible


def test_the_robot_hides_no_part_of_a_board(explorer: ExplorerPage) -> None:
    with_robot = explorer.still_pixels()
    explorer.set_visible(ROBOT, visible=False)
    without = explorer.still_pixels()
    assert np.any(with_robot != without)
    for board in BOARDS:
        region = explorer.region(board, BOARD_SIZE)
        assert not np.any(with_robot[region] != without[region]), board


def test_resizing_and_resetting_the_view_shows_everything_again(explorer: ExplorerPage) -> None:
    before = explorer.canvas_box()
    explorer.page.set_viewport_size({"width": 1000, "height": 800})
    explorer.wait_for(lambda: explorer.canvas_box() != before, "the canvas keeps its size")
    explorer.press("r")
    explorer.still_camera()
    assert_boards_in_view(explorer)


def test_a_reload_brings_the_same_screen_back(explorer: ExplorerPage) -> None:
    explorer.tab("Explore")
    moved = explorer.value("μ 3") + 0.5  # across the landscape: along it, its window may stay
    with explorer.landscape_follows():
        explorer.set_value("μ 3", moved)
    pose = explorer.still_poses(ROBOT)
    explorer.reload()
    explorer.tab("Explore")
    assert explorer.value("μ 3") == pytest.approx(moved, abs=0.01)
    assert agree(explorer.still_poses(ROBOT), pose)
