"""A class: pages that follow one, a projector without a hand, one page more than fits."""

from __future__ import annotations

import numpy as np
import pytest
from explorer_page import ExplorerPage, Open, agree

from rnnpb_explorer.app.page import server
from rnnpb_explorer.app.page.server import App, ServerOptions, start


def link_of(teacher: ExplorerPage) -> str:
    teacher.tab("View")
    teacher.click("Present this page")
    teacher.page.locator(".rb-link").wait_for()
    return teacher.page.locator(".rb-link").input_value()


def follows(page: ExplorerPage, teacher: ExplorerPage) -> None:
    page.until(
        lambda: (
            np.allclose(page.part("[...part.map.puck]"), teacher.part("[...part.map.puck]"))
            and agree(page.pose(), teacher.pose())
        ),
        "the page does not follow",
    )


def drag(page: ExplorerPage, dx: float, dy: float) -> None:
    x, y = page.puck("map")
    page.drag((x, y), (x + dx, y + dy))


def test_a_page_follows_lets_go_and_comes_back(app: App, open_explorer: Open) -> None:
    teacher = open_explorer(app.url)
    pupil = open_explorer(link_of(teacher))
    teacher.text("1 page follows").wait_for()
    pupil.text("Following").wait_for()
    bar, boards = (
        teacher.page.locator(name).bounding_box() for name in (".rb-presence", "[data-board=map]")
    )
    assert bar is not None
    assert boards is not None
    assert bar["x"] > boards["x"] + boards["width"]  # all of it can be read
    drag(teacher, 30, -20)
    follows(pupil, teacher)
    teacher.screenshot("presents")
    drag(pupil, -50, 10)
    pupil.text("On your own").wait_for()
    assert not np.allclose(
        pupil.part("[...part.map.puck]"), teacher.part("[...part.map.puck]"), atol=0.01
    )
    pupil.reload(app)
    pupil.text("On your own").wait_for()
    pupil.screenshot("on-ones-own")
    pupil.click("Follow again")
    follows(pupil, teacher)
    teacher.click("Stop")
    pupil.text("Waiting for who presents").wait_for()
    teacher.text("1 page follows").wait_for(state="hidden")


def test_a_projector_that_lost_the_server_comes_back_without_a_click(open_explorer: Open) -> None:
    first = start(ServerOptions(port=0, motion="0", frame=3))
    teacher = open_explorer(first.url)
    projector = open_explorer(link_of(teacher))
    projector.text("Following").wait_for()
    drag(teacher, 30, -20)
    follows(projector, teacher)
    there = teacher.part("[...part.map.puck]")
    first.stop()
    second = start(ServerOptions(port=int(first.url.rpartition(":")[2])))
    try:
        for page in (teacher, projector):  # neither has been brought to the front
            page.until(lambda: len(second.sessions) == 2, "the pages are not back")
        projector.text("Following").wait_for()
        projector.until(
            lambda: np.allclose(projector.part("[...part.map.puck]"), there), "it is elsewhere"
        )
        drag(teacher, -20, 20)
        follows(projector, teacher)
    finally:
        for page in (teacher, projector):
            page.console_errors.clear()  # the browser's own words on the lost connection
        second.stop()


def test_one_page_too_many_gets_in_as_soon_as_there_is_room(
    open_explorer: Open, browser: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "MAX_SESSIONS", 1)
    monkeypatch.setattr(server, "RETRY_SECONDS", 1.0)
    full = start(ServerOptions(port=0))
    try:
        first = open_explorer(full.url)
        waiting = first.page.context.new_page()
        waiting.goto(full.url)
        waiting.get_by_text("as many as it takes").wait_for()
        first.page.goto("about:blank")
        waiting.wait_for_function("window.rnnpb?.part?.landscape.shown?.complete")
        waiting.close()
    finally:
        full.stop()
