"""Moving the latent by hand: puck, slider, click, key; the motion and the landscape follow."""

from __future__ import annotations

import pytest
from explorer_page import ExplorerPage, agree


def moved(explorer: ExplorerPage, board: str, x: float, y: float) -> None:
    """Drag a board's puck by so many pixels, and wait until the server has heard of it."""
    start = explorer.puck(board)
    end = start[0] + x, start[1] + y
    explorer.drag(start, end)
    explorer.wait_heard()
    assert explorer.puck(board) == pytest.approx(end, abs=2)


def test_dragging_on_the_map_moves_mu_pose_and_landscape(explorer: ExplorerPage) -> None:
    pose, mu, landscape = explorer.pose(), explorer.mu(), explorer.puck("landscape")
    with explorer.landscape_follows():
        moved(explorer, "map", -12, -10)  # within the landscape's window, which stays
    explorer.until(lambda: not agree(explorer.pose(), pose), "the robot does not follow the puck")
    assert explorer.mu() != pytest.approx(mu, abs=0.02)
    assert explorer.puck("landscape") != pytest.approx(landscape, abs=2)


def test_dragging_on_the_landscape_moves_its_two_components_only(explorer: ExplorerPage) -> None:
    pose, mu, on_map = explorer.pose(), explorer.mu(), explorer.puck("map")
    moved(explorer, "landscape", 35, -20)
    explorer.until(lambda: not agree(explorer.pose(), pose), "the robot does not follow the puck")
    explorer.until(lambda: explorer.mu()[1] > mu[1] + 0.02, "the sliders do not follow")
    assert explorer.mu()[0] > mu[0] + 0.05
    assert explorer.mu()[2:] == mu[2:]
    assert explorer.puck("map") != pytest.approx(on_map, abs=2)


def test_a_click_on_a_point_selects_its_motion(explorer: ExplorerPage) -> None:
    pose, name = explorer.pose(), "Fearful_1"
    index = explorer.part("part.map.shown.names").index(name)
    point = explorer.part(f"[...part.map.shown.points.data.slice({2 * index}, {2 * index + 2})]")
    with explorer.landscape_follows():
        explorer.page.mouse.click(*explorer.pixel("map", point))
    assert explorer.told("map", "selected") == f"Selected motion: {name}"
    assert explorer.told("landscape", "target").startswith(f"Compared with {name} ")
    assert explorer.field("Motion").input_value() == name
    assert explorer.part("[...part.map.puck]") == pytest.approx(point, abs=1e-3)
    assert not agree(explorer.pose(), pose)


def test_a_slider_moves_the_puck_and_the_landscape(explorer: ExplorerPage) -> None:
    on_map, on_landscape = explorer.puck("map"), explorer.puck("landscape")
    with explorer.landscape_follows():
        explorer.set_value("μ 3", explorer.mu()[2] + 0.6)
    assert explorer.puck("map") != pytest.approx(on_map, abs=2)
    # The third component is not on the landscape's axes: its puck stays, its colours change.
    assert explorer.puck("landscape") == pytest.approx(on_landscape, abs=1)


def test_sigma_with_noise_moves_the_robot_but_not_the_puck(explorer: ExplorerPage) -> None:
    still, puck = explorer.pose(), explorer.puck("map")
    explorer.click("New")
    explorer.until(lambda: not agree(explorer.pose(), still), "the robot ignores the noise")
    noisy = explorer.pose()
    for dim in (1, 2, 3, 4):
        explorer.set_value(f"σ {dim}", 0.9)
    explorer.until(lambda: not agree(explorer.pose(), noisy), "the robot ignores σ")
    assert explorer.puck("map") == pytest.approx(puck, abs=1)
    explorer.click("None")
    explorer.until(lambda: agree(explorer.pose(), still), "without noise it is another motion")


def test_undo_and_redo_by_key_take_a_whole_drag(explorer: ExplorerPage) -> None:
    mu, pose = explorer.mu(), explorer.pose()
    moved(explorer, "map", 40, 10)
    explorer.until(lambda: not agree(explorer.pose(), pose), "the robot does not follow the puck")
    explorer.until(lambda: explorer.mu() != mu, "the sliders do not follow")
    puck = explorer.puck("map")
    for _ in range(2):
        explorer.press("z")
        explorer.until(lambda: explorer.mu() == mu, "undo does not bring μ back")
        explorer.until(lambda: agree(explorer.pose(), pose), "undo leaves the robot away")
        explorer.press("y")
        explorer.until(lambda: explorer.puck("map") == puck, "redo does not bring the puck back")
    explorer.until(lambda: not agree(explorer.pose(), pose), "redo leaves the robot away")
