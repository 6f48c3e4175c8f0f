"""Moving the latent by hand: puck, slider, click; the motion and the landscape follow."""

from __future__ import annotations

import pytest
from explorer_page import ExplorerPage, agree, differing

from rnnpb_explorer.app.stage import BOARD_SIZE

ROBOT = "/robot-0"
MAP, LANDSCAPE = "/boards/map", "/boards/landscape"


def sliders(explorer: ExplorerPage) -> list[float]:
    return [explorer.value(f"μ {dim}") for dim in (1, 2, 3, 4)]


@pytest.fixture
def paused(explorer: ExplorerPage) -> ExplorerPage:
    explorer.tab("Explore")
    explorer.pause()
    explorer.seek(40, ROBOT)
    return explorer


@pytest.mark.parametrize("board", [MAP, LANDSCAPE])
def test_dragging_the_puck_changes_pose_and_landscape(paused: ExplorerPage, board: str) -> None:
    pose, values, before = paused.poses(ROBOT), sliders(paused), paused.still_pixels()
    puck = paused.position(f"{board}-puck")
    target = puck[0] - 30, puck[1] - 25
    with paused.landscape_follows():
        paused.drag(puck, target)
    assert not agree(paused.still_poses(ROBOT), pose), "the robot does not follow the puck"
    assert paused.position(f"{board}-puck") == pytest.approx(target, abs=3)
    assert sliders(paused) != pytest.approx(values, abs=0.02)
    after = paused.still_pixels()
    landscape = paused.region(LANDSCAPE, BOARD_SIZE)
    assert differing(before[landscape], after[landscape]).mean() > 0.02
    assert paused.console_errors == []


def test_dragging_on_the_landscape_leaves_the_other_components_alone(paused: ExplorerPage) -> None:
    values = sliders(paused)
    x, y = paused.position(f"{LANDSCAPE}-puck")
    with paused.landscape_follows():
        paused.drag((x, y), (x + 35, y - 20))
    assert sliders(paused)[0] > values[0] + 0.05
    assert sliders(paused)[1] > values[1] + 0.02
    assert sliders(paused)[2:] == values[2:]


def test_a_slider_moves_the_puck_and_the_landscape(paused: ExplorerPage) -> None:
    pucks = [paused.position(f"{board}-puck") for board in (MAP, LANDSCAPE)]
    before = paused.still_pixels()
    with paused.landscape_follows():
        paused.set_value("μ 3", sliders(paused)[2] + 0.6)
    assert paused.position(f"{MAP}-puck") != pytest.approx(pucks[0], abs=2)
    # The third component is not on the landscape's axes: its puck stays, its colours change.
    assert paused.position(f"{LANDSCAPE}-puck") == pytest.approx(pucks[1], abs=1)
    after = paused.still_pixels()
    landscape = paused.region(LANDSCAPE, BOARD_SIZE)
    assert differing(before[landscape], after[landscape]).mean() > 0.02


def test_sigma_with_noise_moves_the_robot_but_not_the_puck(paused: ExplorerPage) -> None:
    paused.click("New")
    pose, puck = paused.still_poses(ROBOT), paused.position(f"{MAP}-puck")
    for dim in (1, 2, 3, 4):
        paused.set_value(f"σ {dim}", 0.9)
    paused.wait_for(lambda: not agree(paused.poses(ROBOT), pose), "the robot ignores σ")
    assert paused.position(f"{MAP}-puck") == pytest.approx(puck, abs=1)


def test_undo_takes_a_whole_drag_back(paused: ExplorerPage) -> None:
    values, pose = sliders(paused), paused.poses(ROBOT)
    x, y = paused.position(f"{MAP}-puck")
    paused.drag((x, y), (x + 40, y + 10))
    paused.wait_for(
        lambda: not agree(paused.poses(ROBOT), pose), "the robot does not follow the puck"
    )
    paused.click("Undo")
    paused.wait_for(lambda: sliders(paused) == values, "undo does not bring μ back")
    paused.wait_for(lambda: agree(paused.poses(ROBOT), pose), "undo leaves the robot away")
