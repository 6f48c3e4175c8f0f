"""From one's own recordings to the screen, for a robot that is not Pepper; by the real commands."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from arm import RECORDED_JOINTS, options_for_the_arm, recording

from rnnpb_explorer.app.page.server import App, start
from rnnpb_explorer.app.page.session import Session
from rnnpb_explorer.core.motion import format_motion

from ..wire_browser import WireBrowser
from .pictures import complete, until


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[App]:
    """The explorer with a model that `rnnpb train` made of three recordings, and with the arm."""
    running = start(options_for_the_arm(tmp_path_factory.mktemp("arm")))
    yield running
    running.stop()


@pytest.fixture
def browser(app: App) -> Iterator[WireBrowser]:
    opened = WireBrowser(app.url)
    opened.widget("Motion")
    yield opened
    opened.leave()


@pytest.fixture
def session(app: App, browser: WireBrowser) -> Session:
    session = app.sessions[max(app.sessions)]
    until(session, complete)
    browser.wait_for_all()
    return session


def html(browser: WireBrowser) -> str:
    return " ".join(str(known.get("content", "")) for known in browser.widgets.values())


def test_map_landscape_and_robot_are_there(
    app: App, browser: WireBrowser, session: Session
) -> None:
    assert app.facts[0].joints == RECORDED_JOINTS
    assert app.facts[0].motions == ("bend", "turn", "wave")
    assert app.facts[0].data[0] is not None  # the recordings are the targets
    assert browser.shown["MapShown"]["names"] == ["bend", "turn", "wave"]
    assert np.isfinite(browser.shown["LandscapeShown"]["correlation"]).all()
    assert any(name.endswith("/a/b/c/d/slide") for name in browser.nodes)
    arm = browser.shown["RobotsShown"]["robots"][0]
    assert set(arm["nodes"]) <= set(browser.nodes)


def test_joints_without_a_match_are_on_the_screen(browser: WireBrowser, session: Session) -> None:
    browser.wait_for(lambda: "4 of the 5 joints of the model" in html(browser))
    assert "so not seen: e." in html(browser)
    assert "Not moved by the model: slide." in html(browser)


def test_a_drag_moves_the_arm(browser: WireBrowser, session: Session) -> None:
    before = browser.shown["MotionShown 0"]["angles"]
    x, y = browser.shown["PuckShown"]["on_map"].tolist()
    browser.drag("map", (x, y), (x + 0.3, y), (x + 0.5, y + 0.2))
    browser.wait_for(lambda: not np.array_equal(browser.shown["MotionShown 0"]["angles"], before))


def test_a_recording_is_recognised(browser: WireBrowser, session: Session) -> None:
    browser.upload("Upload a motion", "new.csv", format_motion(recording("new", 0.5)).encode())
    until(session, lambda picture: picture.document.target is not None)
    browser.set("Method", "as published: sampling and Adam")
    browser.set("Iterations", 20)
    until(session, lambda picture: picture.document.recognition.iterations == 20)
    browser.press("Start")
    done = until(session, lambda picture: picture.run_status == "finished" and complete(picture))
    assert done.trace is not None
    assert done.trace.loss.min() < done.trace.loss[0, 0]


def test_it_is_exported_and_has_no_naoqi(browser: WireBrowser, session: Session) -> None:
    browser.set("Format", "JSON")
    until(session, lambda picture: picture.document.export.file_format == "json")
    browser.press("Export the motion")
    browser.wait_for(lambda: any(name.endswith(".json") for name in browser.files))
    browser.set("Format", "NAOqi script")
    until(session, lambda picture: picture.document.export.file_format == "naoqi")
    browser.press("Export the motion")
    browser.wait_for(
        lambda: any("NAOqi on Pepper has no joint" in said for said in browser.notices)
    )
