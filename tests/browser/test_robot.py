"""Pepper on the screen: it moves, and nothing else does."""

from __future__ import annotations

from explorer_page import ExplorerPage, differing, grown

ROBOT = "/robot-0"


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
