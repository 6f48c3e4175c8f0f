"""Two browsers at once, or two windows of one: neither sees what the other does."""

from __future__ import annotations

import pytest
from explorer_page import Open, agree, differing

ROBOT = "/robot-0"


def test_two_browsers_do_not_disturb_each_other(open_explorer: Open) -> None:
    first, second = open_explorer(), open_explorer()
    pose, pixels = second.still_poses(ROBOT), second.still_pixels()
    value = second.value("μ 2")
    first_pose = first.still_poses(ROBOT)

    x, y = first.position("/boards/map-puck")
    with first.landscape_follows():
        first.drag((x, y), (x - 40, y + 15))
    assert not agree(first.still_poses(ROBOT), first_pose)

    # Whatever the first one did would have arrived by the time this answer has.
    second.tab("View")
    second.tab("Explore")
    assert agree(second.still_poses(ROBOT), pose)
    assert second.value("μ 2") == value
    assert not differing(pixels, second.still_pixels()).any()

    # One leaves; the other goes on.
    first.page.goto("about:blank")
    second.set_value("μ 2", value + 0.5)
    second.wait_for(
        lambda: not agree(second.poses(ROBOT), pose), "the second robot does not follow"
    )


def test_two_windows_of_a_browser_come_back_as_each_was(open_explorer: Open) -> None:
    first = open_explorer()
    second = first.another()
    for window, value in ((first, 0.25), (second, 0.75)):
        with window.landscape_follows():
            window.set_value("μ 3", value)
    for window, value in ((first, 0.25), (second, 0.75)):
        window.reload()
        assert window.value("μ 3") == pytest.approx(value, abs=0.01)
    assert second.console_errors == []
