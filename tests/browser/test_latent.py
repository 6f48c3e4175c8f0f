"""Moving the latent by hand: puck, slider, click; the motion and the landscape follow."""

from __future__ import annotations

import pytest
from explorer_page import ExplorerPage, agree, differing

from rnnpb_explorer.app.page.stage import BOARD_SIZE

ROBOT = "/robot-0"
MAP, LANDSCAPE = "/boards/map", "/boards/landscape"


def sliders(explorer: ExplorerPage) -> list[float]:
    return [explorer.value(f"μ {dim}") for dim in (1, 2, 3, 4)]


def test_dragging_the_puck_changes_pose_and_landscape(explorer: ExplorerPage) -> None:
    pose, values, before = explorer.poses(ROBOT), sliders(explorer), explorer.still_pixels()
    puck = explorer.position(f"{MAP}-puck")
    target = puck[0] - 30, puck[1] - 25
    with explorer.landscape_follows():
        explorer.drag(puck, target)
    assert not agree(explorer.still_poses(ROBOT), pose), "the robot does not follow the puck"
    assert explorer.position(f"{MAP}-puck") == pytest.approx(target, abs=3)
    assert sliders(explorer) != pytest.approx(values, abs=0.02)
    after = explorer.still_pixels()
    landscape = explorer.region(LANDSCAPE, BOARD_SIZE)
    assert differing(before[landscape], after[landscape]).mean() > 0.02


def test_dragging_on_the_landscape_moves_its_two_components_only(explorer: ExplorerPage) -> None:
    pose, values = explorer.poses(ROBOT), sliders(explorer)
    map_puck = explorer.position(f"{MAP}-puck")
    puck = explorer.position(f"{LANDSCAPE}-puck")
    target = puck[0] + 35, puck[1] - 20
    explorer.drag(puck, target)
    explorer.wait_for(
        lambda: explorer.position(f"{LANDSCAPE}-puck") == pytest.approx(target, abs=3),
        "the puck is not where it was dragged to",
    )
    assert not agree(explorer.still_poses(ROBOT), pose), "the robot does not follow the puck"
    moved = sliders(explorer)
    assert moved[0] > values[0] + 0.05
    assert moved[1] > values[1] + 0.02
    assert moved[2:] == values[2:]
    assert explorer.position(f"{MAP}-puck") != pytest.approx(map_puck, abs=2)


@pytest.mark.parametrize("board", [MAP, LANDSCAPE])
def test_a_slow_drag_draws_every_frame_of_its_way(explorer: ExplorerPage, board: str) -> None:
    """While the button is held, viser draws an arrow of its own, which broke the page once.

    It is there where one drags the board, not the puck. The fixture asserts that the page has
    logged no error.
    """
    x, y = explorer.position(board)
    start, end = (x + 40, y + 20), (x + 15, y + 40)
    explorer.drag(start, end, steps=4, held=explorer.draw_drag_arrow)
    explorer.wait_for(
        lambda: explorer.position(f"{board}-puck") == pytest.approx(end, abs=3),
        "the puck is not where it was dragged to",
    )


def test_a_slider_moves_the_puck_and_the_landscape(explorer: ExplorerPage) -> None:
    pucks = [explorer.position(f"{board}-puck") for board in (MAP, LANDSCAPE)]
    before = explorer.still_pixels()
    with explorer.landscape_follows():
        explorer.set_value("μ 3", sliders(explorer)[2] + 0.6)
    assert explorer.position(f"{MAP}-puck") != pytest.approx(pucks[0], abs=2)
    # The third component is not on the landscape's axes: its puck stays, its colours change.
    assert explorer.position(f"{LANDSCAPE}-puck") == pytest.approx(pucks[1], abs=1)
    after = explorer.still_pixels()
    landscape = explorer.region(LANDSCAPE, BOARD_SIZE)
    assert differing(before[landscape], after[landscape]).mean() > 0.02


def test_sigma_with_noise_moves_the_robot_but_not_the_puck(explorer: ExplorerPage) -> None:
    explorer.click("New")
    pose, puck = explorer.still_poses(ROBOT), explorer.position(f"{MAP}-puck")
    for dim in (1, 2, 3, 4):
        explorer.set_value(f"σ {dim}", 0.9)
    explorer.wait_for(lambda: not agree(explorer.poses(ROBOT), pose), "the robot ignores σ")
    assert explorer.position(f"{MAP}-puck") == pytest.approx(puck, abs=1)


def test_undo_takes_a_whole_drag_back(explorer: ExplorerPage) -> None:
    values, pose = sliders(explorer), explorer.poses(ROBOT)
    x, y = explorer.position(f"{MAP}-puck")
    explorer.drag((x, y), (x + 40, y + 10))
    explorer.wait_for(
        lambda: not agree(explorer.poses(ROBOT), pose), "the robot does not follow the puck"
    )
    explorer.click("Undo")
    explorer.wait_for(lambda: sliders(explorer) == values, "undo does not bring μ back")
    explorer.wait_for(lambda: agree(explorer.poses(ROBOT), pose), "undo leaves the robot away")
