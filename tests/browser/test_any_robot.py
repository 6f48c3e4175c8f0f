"""Another robot, with a model of its own recordings, on the screen."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from arm import options_for_the_arm, recording
from explorer_page import Open, agree

from rnnpb_explorer.app.page.server import App, start
from rnnpb_explorer.core.motion import format_motion


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[App]:
    folder = tmp_path_factory.mktemp("arm")
    running = start(options_for_the_arm(folder, ("zero", "deterministic")))
    yield running
    running.stop()


def test_two_models_of_an_arm_are_compared_and_one_recognises(
    arm: App, open_explorer: Open
) -> None:
    explorer = open_explorer(arm.url)
    explorer.tab("Robot")
    explorer.text("4 of the 5 joints of the model").wait_for()
    explorer.click("Pause")
    explorer.tab("Explore")
    explorer.wait_for("part.robots.unsettled === 0")
    bent, other = explorer.pose(), explorer.pose(1)
    assert explorer.names() == ["zero", "deterministic"]
    with explorer.landscape_follows():
        explorer.set_value("μ 1", explorer.value("μ 1") - 5)  # beyond the landscape's window
    assert not agree(explorer.pose(), bent), "the arm does not move"
    assert agree(explorer.pose(1), other), "the other model's arm moves, too"
    explorer.screenshot("two-arms")
    explorer.choose("Model", "deterministic")
    explorer.wait_for("part.map.shown.title === 'deterministic'")
    explorer.set_value("μ 1", explorer.value("μ 1") - 5)
    explorer.until(lambda: not agree(explorer.pose(1), other), "the other model's arm stays")
    explorer.tab("Recognise")
    explorer.upload("new.csv", format_motion(recording("new", 0.5)).encode())
    explorer.choose("Method", "as published: sampling and Adam")
    explorer.set_value("Iterations", 20)
    explorer.click("Start")
    explorer.text("Best: iteration").wait_for()
