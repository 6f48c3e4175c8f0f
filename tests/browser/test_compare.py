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


def test_the_zoom_of_both_maps_comes_back(pair: App, comparing: ExplorerPage) -> None:
    for slot, board in enumerate(("map", "map-2")):
        box = comparing.plot(board).bounding_box()
        assert box is not None
        comparing.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        comparing.page.mouse.wheel(0, -300)
        comparing.wait_for(f"part.maps[{slot}].zoom !== null")
    views = comparing.part("part.maps.map((map) => map.zoom)")
    comparing.until(
        lambda: any(one.document.seen.map_2 for one in pair.sessions.values()),
        "the server is not told where one looks",
    )
    comparing.reload(pair)
    comparing.wait_for("part.maps.every((map) => map.zoom !== null)")
    assert comparing.part("part.maps.map((map) => map.zoom)") == views


# --- two ways to walk ---
def walking(comparing: ExplorerPage) -> None:
    comparing.choose("Way to", "Fear_1")
    comparing.wait_for("part.steps.shown.length === 2 && part.maps.every((map) => map.ways)")


def stand(comparing: ExplorerPage, step: int) -> list[NDArray[np.float64]]:
    """Both robots' motions once they stand there."""
    comparing.wait_for(f"part.steps.shown.every(({{ at }}) => at === {step})")
    comparing.wait_for("part.landscapes.every((one) => one.shown.complete)")
    return angles(comparing)


def test_a_click_on_the_curve_goes_there_and_the_cliff_is_one_step(comparing: ExplorerPage) -> None:
    walking(comparing)
    curve = comparing.page.locator(".rb-steps")
    curve.scroll_into_view_if_needed()
    box = curve.bounding_box()
    assert box is not None
    edges = 30, 8  # left and right of the curve
    x = edges[0] + (box["width"] - sum(edges)) * 12 / 40
    curve.click(position={"x": x, "y": 60})
    stand(comparing, 12)
    assert comparing.value("Step") == 12
    steepest = comparing.part("part.steps.shown[0].steepest")
    change = comparing.part("part.steps.shown[0].changes.data[part.steps.shown[0].steepest]")
    comparing.click("Before")
    before = stand(comparing, steepest)
    comparing.screenshot("walk")
    comparing.click("After")
    after = stand(comparing, steepest + 1)
    # Measured over 120 frames, of which the motion on the screen has 83.
    assert mean_change(before[0], after[0]) == pytest.approx(change, rel=0.5)
    # Each has one ghost; the second robot is a copy of the first one itself.
    assert comparing.part("part.robots.robots.map(({ copies }) => copies.length)") == [1, 2]


def test_the_way_is_played_and_taken_away_as_one_motion(comparing: ExplorerPage) -> None:
    walking(comparing)
    happy = angles(comparing)[0]
    comparing.tick("As one motion", True)
    comparing.wait_for("part.steps.shown.every(({ shares }) => shares !== null)")
    comparing.wait_for("part.robots.robots[0].motion.angles.shape[0] === 229")
    morph = angles(comparing)[0].reshape(229, -1)
    joints = morph.shape[1]
    # It begins as the one motion, and ends as neither began.
    np.testing.assert_allclose(morph[:57], happy.reshape(-1, joints)[:57], atol=1e-4)
    name, content = comparing.download("Download it (CSV)")
    assert name == "Happy_4_to_Fear_1_strong.csv"
    table = np.loadtxt(content.decode().splitlines(), delimiter=",", skiprows=1)
    np.testing.assert_allclose(table[:, -joints:], morph, atol=1e-4)
    comparing.tick("As one motion", False)
    comparing.wait_for("part.steps.shown.every(({ shares }) => shares === null)")


# --- uncertainty side by side ---
def test_both_bands_are_drawn_and_the_deterministic_model_has_none(
    comparing: ExplorerPage,
) -> None:
    comparing.page.get_by_label("Joint").select_option("HeadPitch")
    comparing.tab("View")
    comparing.tick("Uncertainty", True)
    comparing.wait_for("part.timebar.bands[0] !== null")
    assert comparing.part("part.timebar.bands[1]") is None
    whose = comparing.page.locator(".rb-whose")
    assert whose.inner_text().split("━")[1:] == [" strong ", " deterministic (σ = 0, no band)"]
    assert comparing.names() == ["strong", "deterministic: no σ, no samples"]
    comparing.screenshot("uncertainty-of-two")
    comparing.tab("Explore")
    comparing.choose("Compare with", "weak")
    comparing.wait_for("part.timebar.bands[0] !== null && part.timebar.bands[1] !== null")
    assert len(comparing.part("part.timebar.others")) == 1
