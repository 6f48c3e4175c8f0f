"""From one's own recordings to the screen, for a robot that is not Pepper; by the real commands."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from arm import RECORDED_JOINTS, options_for_the_arm, recording

from rnnpb_explorer.app.page.server import App, start
from rnnpb_explorer.app.page.session import Session
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.wanted import wanted
from rnnpb_explorer.core.motion import format_motion

from ..wire_browser import TIMEOUT, WireBrowser


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
    return session


def until(session: Session, condition: Callable[[Picture], bool]) -> None:
    assert session.wait_for(condition, TIMEOUT)


def complete(picture: Picture) -> bool:
    return not picture.computed.missing(wanted(picture.facts, picture.document))


def html(browser: WireBrowser) -> str:
    return " ".join(str(known.get("content", "")) for known in browser.widgets.values())


def test_map_landscape_and_robot_are_there(
    app: App, browser: WireBrowser, session: Session
) -> None:
    assert app.facts[0].joints == RECORDED_JOINTS
    assert app.facts[0].motions == ("bend", "turn", "wave")
    assert app.facts[0].data[0] is not None  # the recordings are the targets
    assert {"/boards/map", "/boards/landscape"} <= set(browser.nodes)
    landscape = Picture(app.facts, session.document, session._computed).landscape
    assert landscape is not None
    assert landscape[1].correlation.shape == (20, 20)
    assert np.isfinite(landscape[1].correlation).all()
    arm = [name for name in browser.nodes if name.startswith("/robot-0/")]
    assert any(name.endswith("/a/b/c/d/slide") for name in arm)


def test_joints_without_a_match_are_on_the_screen(browser: WireBrowser, session: Session) -> None:
    browser.wait_for(lambda: "4 of the 5 joints of the model" in html(browser))
    assert "so not seen: e." in html(browser)
    assert "Not moved by the model: slide." in html(browser)


def test_a_drag_moves_the_arm(browser: WireBrowser, session: Session) -> None:
    browser.command("Play or pause")
    until(session, lambda picture: not picture.document.playback.playing)
    before = {name: node.get("wxyz") for name, node in browser.nodes.items()}
    x, y, z = browser.nodes["/boards/map"]["position"]
    browser.drag("/boards/map", (x, y, z), (x, y + 0.1, z), (x, y + 0.2, z + 0.1))
    until(session, lambda picture: len(session._history.past) == 1 and complete(picture))
    browser.wait_for(
        lambda: any(
            node.get("wxyz") != before.get(name)
            for name, node in browser.nodes.items()
            if name.startswith("/robot-0/")
        )
    )


def test_a_recording_is_recognised(browser: WireBrowser, session: Session) -> None:
    browser.upload("Upload a motion", "new.csv", format_motion(recording("new", 0.5)).encode())
    until(session, lambda picture: picture.document.target is not None)
    browser.set("Iterations", 20)
    until(session, lambda picture: picture.document.recognition.iterations == 20)
    browser.press("Start")
    ended: list[Picture] = []

    def finished(picture: Picture) -> bool:
        ended[:] = [picture]
        return picture.run_status == "finished" and complete(picture)

    until(session, finished)
    trace = ended[0].trace
    assert trace is not None
    assert trace.loss.min() < trace.loss[0, 0]


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
