"""The page as it opens, in any size; what it survives."""

from __future__ import annotations

import io

import numpy as np
import pytest
from explorer_page import ExplorerPage, Open, agree
from PIL import Image
from playwright.sync_api import Browser, expect

from rnnpb_explorer.app.commands.photograph import photograph
from rnnpb_explorer.app.page.server import App, ServerOptions, start

CANVAS, TIME_BAR = "canvas[data-engine]", ".rb-timebar"
OPEN_TAB = '[role="tab"][aria-selected="true"]'
DESK = (1280, 720)
CAMERA = "() => window.__viserMutable.camera.position.toArray()"
Box = tuple[float, float, float, float]  # left, top, right, bottom


def box(explorer: ExplorerPage, selector: str) -> Box:
    found = explorer.page.locator(selector).bounding_box()
    assert found is not None, selector
    return found["x"], found["y"], found["x"] + found["width"], found["y"] + found["height"]


def wait_framed(explorer: ExplorerPage) -> None:
    """Until the robot fills the canvas's height from the floor to the head, and stands in it."""

    def framed() -> bool:
        left, top, right, bottom = box(explorer, CANVAS)
        x, y = explorer.positions("/robot").T
        inside = left < x.min() and x.max() < right and top < y.min() and y.max() < bottom
        return bool(inside and y.max() - y.min() > 0.55 * (bottom - top))

    explorer.until(framed, "the camera does not frame the robot")


def test_it_opens_quietly_and_offers_no_tunnel_to_the_outside(explorer: ExplorerPage) -> None:
    for tab in ("Explore", "Recognise", "Robot", "View", "Help"):
        explorer.tab(tab)
    assert not explorer.page.get_by_role("alert").filter(visible=True).count()
    assert explorer.page.get_by_text("Share", exact=True).count() == 0
    assert explorer.page.locator(".tabler-icon-share").count() == 0


@pytest.mark.parametrize("size", [(1920, 1080), (3840, 2160), DESK])  # the last one stays
def test_all_of_it_is_in_view(explorer: ExplorerPage, size: tuple[int, int]) -> None:
    explorer.page.set_viewport_size({"width": size[0], "height": size[1]})
    explorer.until(lambda: box(explorer, CANVAS)[0] >= 0.24 * size[0], "the boards stay small")
    explorer.until(lambda: box(explorer, CANVAS)[0] <= 0.3 * size[0], "the boards stay large")
    wait_framed(explorer)
    left, _, right, bottom = box(explorer, CANVAS)
    bar = box(explorer, TIME_BAR)
    assert bar[:3] == pytest.approx((left, bottom, right), abs=1)
    assert bar[3] <= size[1]
    for board in ("map", "landscape"):
        plot = box(explorer, f"[data-board={board}] .rb-plot")
        assert plot[0] >= 0
        assert plot[2] <= left
        assert plot[3] <= size[1]
        assert min(plot[2] - plot[0], plot[3] - plot[1]) >= 220  # legible
    explorer.screenshot(f"explorer-{size[0]}x{size[1]}")


def test_on_a_phone_the_panels_are_folded_and_a_finger_does_the_rest(
    app: App, open_explorer: Open
) -> None:
    explorer = open_explorer(
        app.url,
        size=(390, 844),
        resolution=1,
        has_touch=True,
        is_mobile=True,
        device_scale_factor=2,
    )
    wait_framed(explorer)
    explorer.screenshot("explorer-390x844")
    expect(explorer.page.get_by_role("tab", name="Explore")).not_to_be_visible()
    pose, start = explorer.pose(), explorer.puck("map")
    finger, end = explorer.touch(), (start[0] + 60, start[1] - 50)
    explorer.fingers(finger, "touchStart", start)
    explorer.fingers(finger, "touchMove", end)
    explorer.fingers(finger, "touchEnd")
    explorer.wait_heard()
    explorer.until(lambda: not agree(explorer.pose(), pose), "the robot ignores the finger")
    explorer.button("Undo").tap()
    explorer.until(lambda: agree(explorer.pose(), pose), "undo leaves the robot away")
    explorer.button("Play").tap()
    explorer.until(lambda: not agree(explorer.pose(), pose), "the robot does not play")
    explorer.button("Pause").tap()
    explorer.button("Landscape").tap()
    expect(explorer.plot("landscape")).to_be_visible()
    expect(explorer.plot("map")).not_to_be_visible()
    explorer.page.get_by_text("rnnpb-explorer").first.tap()
    expect(explorer.page.get_by_role("tab", name="Explore")).to_be_visible()


def test_a_paused_frame_gives_the_same_picture_twice(app: App, browser: Browser) -> None:
    one, other = (
        np.asarray(Image.open(io.BytesIO(photograph(browser, app.url, (400, 700)))).convert("RGB"))
        for _ in range(2)
    )
    assert one.shape == (700, 400, 3)
    assert len(np.unique(one.reshape(-1, 3), axis=0)) > 500
    assert np.array_equal(one, other)


def test_a_server_that_was_started_again_gets_the_document_back(open_explorer: Open) -> None:
    first = start(ServerOptions(port=0, motion="0", frame=3))
    explorer = open_explorer(first.url)
    with explorer.landscape_follows():
        explorer.set_value("μ 3", explorer.mu()[2] + 0.5)
    (session,) = first.sessions.values()
    latent = session.document.models[0].latent
    pose, numbers = explorer.pose(), explorer.told("landscape", "numbers")
    first.stop()
    second = start(ServerOptions(port=int(first.url.rpartition(":")[2])))
    try:
        assert second.url == first.url

        def back() -> bool:
            here = [one.document.models[0].latent for one in second.sessions.values()]
            return here == [latent]

        explorer.until(back, "the document is not back")
        explorer.until(lambda: explorer.told("landscape", "numbers") == numbers, "no landscape")
        assert agree(explorer.pose(), pose), "a page that was paused does not go on playing"
        explorer.press("p")
        explorer.until(lambda: not agree(explorer.pose(), pose), "the page does not live on")
    finally:
        explorer.console_errors.clear()  # the browser's own words on the lost connection
        second.stop()


def test_nonsense_from_the_page_does_no_harm(explorer: ExplorerPage) -> None:
    """What has the right form, and makes no sense: there is no such motion, axis, model."""
    hand = '"gesture":1,"number":1,"done":true}'
    words = (
        '{"type":"SelectMotion","index":99999}',
        '{"type":"MoveOnMap","model":0,"axes":[100],"to":[1],' + hand,
        '{"type":"MoveOnMap","model":0,"axes":[1,1],"to":[1,2],' + hand,
        '{"type":"MoveOnMap","model":9,"axes":[0,1],"to":[1,2],' + hand,
        '{"type":"MoveOnLandscape","model":0,"axes":["no","such"],"to":[1,2],' + hand,
        '{"type":"Seek","frame":1e6}',
        '{"type":"SetJoint","joint":999}',
        '{"type":"Hello","document":"none","width":0,"height":0,"ratio":1,"page_width":1280,'
        '"page_height":720,"dark":false,"playback":null}',
        '{"type":"Nonsense"}',
        "{",
    )
    pose = explorer.pose()
    explorer.page.evaluate(
        """(words) => words.forEach((payload) =>
            window.__viserMutable.sendMessage({ type: "RnnpbAsked", payload }))""",
        list(words),
    )
    explorer.alert("That did not work").wait_for()
    explorer.press("p")
    explorer.until(lambda: not agree(explorer.pose(), pose), "the page does not live on")


def test_where_one_looks_comes_back_after_a_reload(explorer: ExplorerPage, app: App) -> None:
    def sees() -> tuple[list[float], list[float], str]:
        zoom: list[float] = explorer.part(
            "['left', 'right', 'bottom', 'top'].map((side) => part.map.view.extent[side])"
        )
        camera: list[float] = explorer.page.evaluate(CAMERA)
        return zoom, camera, str(explorer.page.locator(OPEN_TAB).last.text_content())

    front = sees()
    explorer.page.mouse.move(*explorer.puck("map"))
    explorer.page.mouse.wheel(0, -600)
    explorer.drag((640, 200), (720, 260))  # the camera
    explorer.tab("View")
    explorer.until(lambda: all(a != b for a, b in zip(sees(), front, strict=True)), "nothing moves")
    (session,) = app.sessions.values()
    explorer.until(
        lambda: session.document.seen.camera and session.document.seen.map, "nobody keeps the view"
    )
    zoom, camera, tab = sees()
    explorer.reload(app)
    explorer.until(lambda: sees()[2] == tab == "View", "another tab is open")
    explorer.until(lambda: sees()[0] == pytest.approx(zoom), "the zoom is gone")
    explorer.until(lambda: sees()[1] == pytest.approx(camera, abs=0.02), "the camera is elsewhere")
    explorer.press("r")
    explorer.until(lambda: sees()[1] == pytest.approx(front[1], abs=0.02), "R does not look home")
