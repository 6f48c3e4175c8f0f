"""Robots of very different size and base, and of no shapes, as a person sees them."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from explorer_page import Open, agree
from robots_of_sizes import write_desk_arm, write_giant

from rnnpb_explorer.app.page.server import ServerOptions, start

FIELD = Path(__file__).parents[1] / "field" / "urdf"


@pytest.mark.parametrize(
    ("write", "says"),
    [
        (write_desk_arm, "nothing beyond the limits, but 14 joints not checked"),
        (write_giant, "nothing beyond the limits, but 13 joints not checked"),
    ],
)
def test_a_robot_of_any_size_is_in_view_and_moves(
    write: Callable[[Path], Path], says: str, tmp_path: Path, open_explorer: Open
) -> None:
    app = start(ServerOptions(port=0, robot=str(write(tmp_path)), frame=40))
    try:
        explorer = open_explorer(app.url)
        explorer.text(says).wait_for()
        explorer.wait_for("part.robots.unsettled === 0")
        box = explorer.page.locator("canvas").first.bounding_box()
        assert box is not None
        joints = explorer.positions("/robot/") - [box["x"], box["y"]]
        assert (joints > 0).all()
        assert (joints < [box["width"], box["height"]]).all()
        assert np.ptp(joints[:, 1]) > 0.25 * box["height"], "it is small in the picture"
        explorer.screenshot(f"{write.__name__}")
        pose = explorer.pose()
        explorer.page.get_by_role("slider", name="Frame").press("End")
        explorer.until(lambda: not agree(explorer.pose(), pose), "it does not move")
        explorer.tab("Robot")
        explorer.text("times its size").wait_for()
    finally:
        app.stop()


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("no-meshes-found", "joints drawn instead: none.dae"),
        ("capsule", "a capsule, which URDF does not know"),
    ],
)
def test_a_robot_that_cannot_move_or_has_no_shapes_is_said(
    name: str, says: str, tmp_path: Path, open_explorer: Open
) -> None:
    path = shutil.copy(FIELD / f"{name}.urdf", tmp_path)
    app = start(ServerOptions(port=0, robot=str(path), frame=40))
    try:
        explorer = open_explorer(app.url)
        explorer.text(f"{name} stands still: it has none of the joints of strong").wait_for()
        explorer.tab("Robot")
        explorer.text(says).wait_for()
        explorer.screenshot(name)
    finally:
        app.stop()
