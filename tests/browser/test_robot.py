"""Pepper on the screen: it moves, and nothing else does."""

from __future__ import annotations

import re

import pytest
from explorer_page import ExplorerPage, agree, differing, grown

ROBOT, SECOND = "/robot-0", "/robot-1"


def test_pepper_moves_and_nothing_else_does(explorer: ExplorerPage) -> None:
    pictures, robots = [], []
    for frame in (0, 45):
        explorer.seek(frame, ROBOT)
        picture = explorer.still_pixels()
        explorer.screenshot(f"pepper-at-frame-{frame}")
        explorer.set_visible(ROBOT, visible=False)
        pictures.append(picture)
        robots.append(differing(picture, explorer.still_pixels()))  # the robot and its shadow
        explorer.set_visible(ROBOT, visible=True)
        explorer.still_pixels()
    changed = differing(*pictures)
    assert changed.sum() > 50, "the two pictures hardly differ"
    elsewhere = changed & ~grown(robots[0] | robots[1])
    assert not elsewhere.any(), f"{elsewhere.sum()} pixels changed away from the robot"


def test_the_limited_motion_moves_beside_the_raw_one(explorer: ExplorerPage) -> None:
    explorer.text("within the robot's limits").wait_for()
    for dim in (1, 2, 3, 4):  # far from everything learnt
        explorer.set_value(f"μ {dim}", 9 * (-1) ** dim)
    explorer.text("the limits").wait_for()
    explorer.tab("Robot")
    explorer.page.get_by_text(re.compile(r": .* rad.*, frames? \d")).first.wait_for()
    explorer.tick("Side by side", True)
    explorer.wait_for(lambda: explorer.poses(f"{SECOND}/"), "no second robot")
    explorer.still_camera()
    raw, limited = (explorer.still_poses(f"{root}/") for root in (ROBOT, SECOND))
    moved = {name.removeprefix(SECOND): pose for name, pose in limited.items()}
    same = {name.removeprefix(ROBOT): pose for name, pose in raw.items()}
    assert moved.keys() == same.keys()
    assert not agree(moved, same), "the limited motion is the raw one"
    assert [explorer.label(f"/names/{spot}") for spot in (0, 1)] == ["raw", "limited"]
    explorer.reload()
    explorer.wait_for(lambda: explorer.poses(f"{SECOND}/"), "the second robot left")
    assert agree(explorer.still_poses(f"{SECOND}/"), limited)
    explorer.tab("Robot")
    explorer.tick("Side by side", False)
    explorer.wait_for(lambda: not explorer.poses(f"{SECOND}/"), "the second robot stays")


@pytest.mark.parametrize(
    ("label", "suffix"), [("CSV", ".csv"), ("JSON", ".json"), ("NAOqi script", ".py")]
)
def test_what_is_exported_can_be_uploaded(explorer: ExplorerPage, label: str, suffix: str) -> None:
    explorer.tab("Robot")
    explorer.choose("Format", label)
    name, content = explorer.download("Export the motion")
    assert name == f"Alienated_1_strong{suffix}"
    explorer.text(f"{name}: 307 frames").wait_for()
    explorer.tab("Recognise")
    explorer.upload(name, content)
    explorer.text("307 frames at 25 Hz").wait_for()


def test_space_starts_and_stops_it_once_a_press(explorer: ExplorerPage) -> None:
    start = explorer.poses(ROBOT)
    explorer.click("Play")
    explorer.button("Pause").wait_for()
    explorer.wait_for(lambda: explorer.poses(ROBOT) != start, "the robot does not play")
    # The button has the focus now and reacts to Space, too: one press must still toggle once.
    for shown in ("Play", "Pause", "Play"):
        explorer.page.keyboard.press("Space")
        explorer.button(shown).wait_for()
    still = explorer.still_pixels()
    assert not differing(still, explorer.still_pixels()).any()
