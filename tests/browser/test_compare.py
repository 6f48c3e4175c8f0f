"""Two models side by side: one drag on one map, and how far each robot goes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from explorer_page import ExplorerPage, Open
from numpy.typing import NDArray

from rnnpb_explorer.app.page.server import App, ServerOptions, start

ANGLES = "[...part.robots.robots[{}].motion.angles.data]"
PUCK = "[...part.maps[{}].puck]"
STEP = (0.1, 0.06)  # on the map, in units of mu


@pytest.fixture(scope="module")
def pair() -> Iterator[App]:
    running = start(
        ServerOptions(checkpoints=("strong", "deterministic"), port=0, motion="Happy_4", frame=20)
    )
    yield running
    running.stop()


@pytest.fixture
def comparing(pair: App, open_explorer: Open) -> ExplorerPage:
    explorer = open_explorer(pair.url)
    explorer.choose("Compare with", "deterministic")
    explorer.wait_for("part.maps[1].view !== null && part.landscapes[1].shown?.complete")
    return explorer


def angles(explorer: ExplorerPage) -> list[NDArray[np.float64]]:
    """Each robot's motion."""
    return [np.array(explorer.part(ANGLES.format(robot))) for robot in (0, 1)]


def mean_change(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Degrees of mean joint angle, root mean square over the motion."""
    return float(np.rad2deg(np.sqrt(np.square(after - before).mean())))


def dragged(explorer: ExplorerPage, board: int) -> tuple[list[float], list[list[float]]]:
    """Drag the puck of a map by STEP: how far each robot's motion changes, and each puck goes."""
    pucks = [explorer.part(PUCK.format(slot)) for slot in (0, 1)]
    before = angles(explorer)
    name = ("map", "map-2")[board]
    x, y = pucks[board]
    explorer.drag(explorer.pixel(name, (x, y)), explorer.pixel(name, (x + STEP[0], y + STEP[1])))
    for robot in (0, 1):
        explorer.until(
            lambda robot=robot: mean_change(before[robot], angles(explorer)[robot]) > 0,
            f"robot {robot} does not move",
        )
    explorer.wait_for("part.landscapes.every((one) => one.shown.complete)")
    changes = [mean_change(a, b) for a, b in zip(before, angles(explorer), strict=True)]
    ways = [list(np.subtract(explorer.part(PUCK.format(slot)), pucks[slot])) for slot in (0, 1)]
    return changes, ways


def test_one_drag_moves_two_robots_and_the_rugged_one_farther(comparing: ExplorerPage) -> None:
    assert comparing.names() == ["strong", "deterministic"]
    for board in ("map", "map-2", "landscape", "landscape-2"):
        box = comparing.plot(board).bounding_box()
        assert box is not None
        assert box["width"] > 150
        assert box["y"] + box["height"] <= 720
    changes, ways = dragged(comparing, 0)
    for way in ways:
        np.testing.assert_allclose(way, STEP, atol=0.02)
    strong, deterministic = changes
    assert 0 < strong < 2
    assert deterministic > 5 * strong
    comparing.screenshot("compare")


def test_a_drag_on_the_other_map_moves_both_and_undo_takes_both_back(
    comparing: ExplorerPage,
) -> None:
    before = angles(comparing)
    _, ways = dragged(comparing, 1)
    for way in ways:
        np.testing.assert_allclose(way, STEP, atol=0.02)
    comparing.wait_for("part.map.shown.title === 'strong'")  # each stays where it is
    comparing.press("z")
    for robot in (0, 1):
        comparing.until(
            lambda robot=robot: np.array_equal(angles(comparing)[robot], before[robot]),
            "undo does not take both back",
        )


def test_in_standard_deviations_they_are_less_far_apart(comparing: ExplorerPage) -> None:
    absolute, _ = dragged(comparing, 0)
    comparing.press("z")
    comparing.choose("One hand", "moves all, as many sd of μ")
    comparing.wait_for("part.landscapes.every((one) => one.shown.complete)")
    scaled, ways = dragged(comparing, 0)
    assert ways[1][0] < 0.5 * ways[0][0]
    assert scaled[1] < absolute[1]


def test_a_reload_brings_the_comparison_back(pair: App, comparing: ExplorerPage) -> None:
    comparing.reload(pair)
    comparing.wait_for("part.maps[1].view !== null")
    assert comparing.plot("map-2").is_visible()
    comparing.choose("Compare with", "nothing")
    comparing.page.locator("[data-board=map-2]").wait_for(state="detached")
