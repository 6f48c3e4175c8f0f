"""The browser's part in a real browser: hands, clock, reload, what goes wrong."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from explorer_page import TIMEOUT_MS
from playwright.sync_api import Browser, expect
from web_page import Server, WebPage

expect.set_options(timeout=TIMEOUT_MS)

OpenWeb = Callable[..., WebPage]
ELSEWHERE = (1.2, 1.4)  # on the map, off every learned point


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    running = Server()
    yield running
    running.thaw()
    running.kill()


@pytest.fixture
def open_web(browser: Browser, server: Server) -> Iterator[OpenWeb]:
    """Open windows; each is closed after the test, and none may have logged an error."""
    opened: list[WebPage] = []

    def open_page(*arguments: Any, **options: Any) -> WebPage:
        options.setdefault("server", server)
        opened.append(WebPage.open(browser, *arguments, **options))
        return opened[-1]

    yield open_page
    for web in opened:
        web.close()
    assert [error for web in opened for error in web.console_errors] == []


@pytest.fixture
def web(open_web: OpenWeb) -> WebPage:
    return open_web()


def place(text: str) -> list[float]:
    """The numbers in 'Puck at PC 1 0.52, PC 2 −1.20, ...'."""
    words = text.replace("−", "-").replace(",", " ").split()
    return [float(word) for word in words if "." in word]


# --- hands ---
def test_a_drag_on_the_map_moves_puck_motion_and_landscape(web: WebPage) -> None:
    poses, landscape = web.poses(), web.told("landscape", "puck")
    number = web.part("part.timebar.motion.number")
    web.drag(web.pixel("map", (0, -0.8)), web.pixel("map", ELSEWHERE))
    last = web.wait_moved("MoveOnMap")
    assert last["axes"] == [0, 1]
    assert last["to"] == pytest.approx(ELSEWHERE, abs=0.02)
    assert place(web.told("map", "puck"))[:2] == pytest.approx(ELSEWHERE, abs=0.02)
    assert web.told("landscape", "puck") != landscape
    web.wait_for(f"part.timebar.motion.number > {number} && part.robots.unsettled === 0")
    web.wait_for("part.playback.moved === false")
    assert any(not np.allclose(poses[name], pose) for name, pose in web.poses().items())


def test_a_drag_on_the_landscape_moves_the_puck_on_the_map(web: WebPage) -> None:
    before = web.told("map", "puck")
    extent = web.part("part.landscape.home")
    to = (extent["left"] + 0.3, extent["top"] - 0.3)
    start = tuple(web.part("part.landscape.puck"))
    web.drag(web.pixel("landscape", start), web.pixel("landscape", to))
    assert web.wait_moved("MoveOnLandscape")["to"] == pytest.approx(to, abs=0.02)
    web.wait_heard()
    assert place(web.told("landscape", "puck"))[:2] == pytest.approx(to, abs=0.02)
    assert web.told("map", "puck") != before


def test_the_puck_is_under_the_pointer_in_the_same_frame(web: WebPage) -> None:
    x, y = web.pixel("map", ELSEWHERE)
    web.page.mouse.move(*web.pixel("map", (0, -0.8)))
    web.page.mouse.down()
    drawn = web.page.evaluate(
        """([x, y]) => new Promise((done) => {
            const { map } = window.rnnpb.part, before = map.surface.draws;
            const event = { clientX: x, clientY: y, pointerId: 1, bubbles: true };
            map.parts.plot.dispatchEvent(new PointerEvent("pointermove", event));
            requestAnimationFrame(() => done([map.surface.draws - before, map.puck]));
        })""",
        [x, y],
    )
    web.page.mouse.up()
    assert drawn[0] == 1
    assert drawn[1] == pytest.approx(ELSEWHERE, abs=0.02)


def test_of_many_moves_at_once_few_are_sent_and_always_the_last(web: WebPage) -> None:
    web.page.mouse.move(*web.pixel("map", (0, -0.8)))
    web.page.mouse.down()
    web.wait_asked("MoveOnMap")
    web.forget()
    x, y = web.pixel("map", ELSEWHERE)
    web.page.evaluate(
        """([x, y]) => {
            const { plot } = window.rnnpb.part.map.parts;
            for (let i = 300; i >= 0; i--) plot.dispatchEvent(new PointerEvent("pointermove",
                { clientX: x - i / 4, clientY: y, pointerId: 1, bubbles: true }));
        }""",
        [x, y],
    )
    web.page.mouse.move(x, y)
    web.page.mouse.up()
    web.wait_moved("MoveOnMap")
    moves = web.asked("MoveOnMap")
    assert len(moves) < 12
    assert moves[-1]["to"] == pytest.approx(ELSEWHERE, abs=0.02)


def test_two_fast_drags_end_at_the_last_place(web: WebPage) -> None:
    a, b = web.pixel("map", (-1.8, 2.0)), web.pixel("map", ELSEWHERE)
    web.drag(web.pixel("map", (0, -0.8)), a, steps=2)
    web.drag(a, b, steps=2)
    web.wait_moved("MoveOnMap")
    assert place(web.told("map", "puck"))[:2] == pytest.approx(ELSEWHERE, abs=0.02)
    done = [move for move in web.asked("MoveOnMap") if move["done"]]
    assert len({move["gesture"] for move in done}) == 2
    assert done[-1]["to"] == pytest.approx(ELSEWHERE, abs=0.02)


def test_a_finger_drags_the_puck_and_taps_a_point(open_web: OpenWeb) -> None:
    web = open_web(size=(390, 844), has_touch=True, is_mobile=True, device_scale_factor=2)
    session = web.touch()
    start, end = web.pixel("map", tuple(web.part("part.map.puck"))), web.pixel("map", ELSEWHERE)
    web.fingers(session, "touchStart", start)
    for share in (0.3, 0.6, 1.0):
        web.fingers(
            session,
            "touchMove",
            (start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])),
        )
    web.fingers(session, "touchEnd")
    web.wait_heard()
    assert place(web.told("map", "puck"))[:2] == pytest.approx(ELSEWHERE, abs=0.03)
    point = web.part("[...part.map.shown.points.data.slice(2 * 12, 2 * 13)]")
    at = web.pixel("map", tuple(point))
    web.fingers(session, "touchStart", at)
    web.fingers(session, "touchEnd")
    index = web.wait_asked("SelectMotion")[0]["index"]
    assert web.part(f"[...part.map.shown.points.data.slice(2 * {index}, 2 * {index} + 2)]") == (
        pytest.approx(point, abs=0.1)
    )


def test_two_fingers_zoom_and_leave_the_puck_alone(open_web: OpenWeb) -> None:
    web = open_web(size=(390, 844), has_touch=True, is_mobile=True, device_scale_factor=2)
    session, puck = web.touch(), web.part("part.map.puck")
    x, y = web.pixel("map", (1.0, 2.2))
    web.fingers(session, "touchStart", (x - 20, y))
    web.fingers(session, "touchStart", (x - 20, y), (x + 20, y))
    for apart in (30, 45, 60):
        web.fingers(session, "touchMove", (x - apart, y), (x + apart, y))
    web.fingers(session, "touchEnd")
    web.wait_for("part.map.zoomed !== null")
    assert web.part("part.map.puck") == puck
    assert web.asked("MoveOnMap") == []


def test_arrow_keys_step_the_puck_and_not_the_camera(web: WebPage) -> None:
    camera = "() => window.__viserMutable.camera.matrixWorld.toArray()"
    before, x = web.page.evaluate(camera), place(web.told("map", "puck"))[0]
    web.plot("map").focus()
    for _ in range(3):
        web.page.keyboard.press("ArrowRight")
    web.wait_for("!part.map.moves.active")
    web.wait_moved("MoveOnMap")
    moves = web.asked("MoveOnMap")
    assert len({move["gesture"] for move in moves}) == 1
    assert place(web.told("map", "puck"))[0] > x + 0.1
    assert web.page.evaluate(camera) == before


def test_the_wheel_zooms_about_the_pointer_and_a_button_shows_all_again(web: WebPage) -> None:
    at = web.pixel("map", ELSEWHERE)
    web.page.mouse.move(*at)
    web.page.mouse.wheel(0, -600)
    web.wait_for("part.map.zoomed !== null")
    assert web.pixel("map", ELSEWHERE) == pytest.approx(at, abs=3)  # a mouse has whole pixels
    web.page.locator("[data-board=map] [title='Show all']").click()
    web.wait_for("part.map.zoomed === null")


def test_the_pointer_names_any_point_and_a_click_selects_it(web: WebPage) -> None:
    names, points = web.part("part.map.shown.names"), web.part("[...part.map.shown.points.data]")
    tip = web.page.locator("[data-board=map] .rb-tip")
    for index in (5, 33, 71):
        web.page.mouse.move(*web.pixel("map", (points[2 * index], points[2 * index + 1])))
        near = np.array(points).reshape(-1, 2) - points[2 * index : 2 * index + 2]
        same = {names[i] for i in np.flatnonzero(np.hypot(*near.T) < 0.02)}
        assert (tip.text_content() or "").split(" · ")[0] in same
    web.page.mouse.click(*web.pixel("map", (points[2 * 71], points[2 * 71 + 1])))
    assert web.wait_asked("SelectMotion")[0]["index"] == 71
    web.wait_for("part.map.shown.selected === 71")
    assert web.told("map", "selected") == f"Selected motion: {names[71]}"


def test_a_point_of_ones_own_has_its_name_and_is_gone_to_by_a_click(web: WebPage) -> None:
    (x, y) = web.part("[...part.map.shown.added.data]")
    web.page.mouse.move(*web.pixel("map", (x, y)))
    tip = web.page.locator("[data-board=map] .rb-tip")
    assert tip.text_content() == "mine · your point"
    assert web.told("map", "added") == "Your points: mine"
    web.page.mouse.click(*web.pixel("map", (x, y)))
    assert web.wait_asked("SelectAdded")[0]["index"] == 4


def test_a_toggle_moves_along_what_is_not_drawn(web: WebPage) -> None:
    puck = place(web.told("map", "puck"))
    web.page.get_by_role("button", name="PC 3, PC 4").click()
    web.drag(web.pixel("map", (0, 0)), web.pixel("map", (0.5, 0.4)))
    move = web.wait_moved("MoveOnMap")
    assert move["axes"] == [2, 3]
    after = place(web.told("map", "puck"))
    assert after == pytest.approx([*puck[:2], puck[2] + 0.5, puck[3] + 0.4], abs=0.05), move


def test_shift_moves_along_what_is_not_drawn(web: WebPage) -> None:
    web.page.keyboard.down("Shift")
    web.drag(web.pixel("map", (0, 0)), web.pixel("map", (0.5, 0.4)))
    web.page.keyboard.up("Shift")
    assert web.wait_moved("MoveOnMap")["axes"] == [2, 3]


def test_the_landscape_reads_its_cells_out(web: WebPage) -> None:
    x = web.part("[...part.landscape.grid.x]")
    y = web.part("[...part.landscape.grid.y]")
    values = web.part("[...part.landscape.grid.values]")
    web.page.mouse.move(*web.pixel("landscape", (x[4], y[15])))
    words = (web.page.locator("[data-board=landscape] .rb-tip").text_content() or "").split(" · ")
    assert words[-1] == f"r = {values[15 * 20 + 4]:.2f}".replace("-", "−")
    assert web.told("landscape", "landscape") == "Landscape 20×20 complete"
    assert "Mean 0." in web.told("landscape", "numbers")


# --- the clock ---
def test_playback_goes_on_while_the_server_is_frozen(web: WebPage) -> None:
    web.forget()
    web.page.get_by_role("button", name="Play").click()
    web.wait_asked("SetPlaying")
    web.server.freeze()
    try:
        frames = web.part("part.playback.frames")
        poses = web.poses()
        stop = time.monotonic() + 2
        while time.monotonic() < stop:
            web.page.wait_for_timeout(100)
        assert web.part("part.playback.frames") >= frames + 4
        assert any(not np.allclose(poses[name], pose) for name, pose in web.poses().items())
        web.page.get_by_role("button", name="Pause").click()
        assert not web.part("part.playback.clock.playing")
        web.page.get_by_role("slider", name="Frame").press("Home")
        assert web.part("part.playback.clock.frame") == 0
    finally:
        web.server.thaw()
    assert web.wait_asked("SetPlaying", 2)[-1]["playing"] is False
    assert web.wait_asked("Seek")[-1]["frame"] == 0


def test_a_page_that_plays_sends_nothing(web: WebPage) -> None:
    web.page.get_by_role("button", name="Play").click()
    web.wait_asked("SetPlaying")
    web.forget()
    frames = web.part("part.playback.frames")
    web.wait_for(f"part.playback.frames > {frames + 10}")
    assert [one for one in web.server.said[web._since :] if "page" in one] == []


def test_another_motion_keeps_the_phase(web: WebPage) -> None:
    web.page.get_by_role("slider", name="Frame").press("ArrowRight")
    frame = web.part("part.playback.clock.frame")
    number = web.part("part.timebar.motion.number")
    web.drag(web.pixel("map", (0, -0.8)), web.pixel("map", ELSEWHERE))
    web.wait_for(f"part.timebar.motion.number > {number}")
    assert web.part("part.playback.clock.frame") == frame == 41


def test_space_plays_and_pauses_once_wherever_the_focus_is(web: WebPage) -> None:
    def playing() -> bool:
        return bool(web.part("part.playback.clock.playing"))

    web.page.keyboard.press("Space")
    assert playing()
    web.page.get_by_role("button", name="Pause").focus()
    web.page.keyboard.press("Space")
    assert not playing()
    web.page.get_by_role("button", name="Other button").click()  # the focus stays on it
    web.page.keyboard.press("Space")
    assert playing()
    field = web.page.get_by_role("textbox").last
    field.click()
    web.page.keyboard.type("a b")
    assert playing()
    assert field.input_value() == "a b"
    web.page.keyboard.press("Tab")  # to the button, by key: its own Space
    web.page.keyboard.press("Space")
    assert playing()


def test_scrub_and_observed_part(web: WebPage) -> None:
    box = web.page.locator(".rb-curves").bounding_box()
    assert box is not None
    left, width, y = box["x"] + 10, box["width"] - 20, box["y"] + box["height"] / 2
    if not web.part("part.playback.clock.playing"):
        web.part("part.playback.toggle()")
    web.page.mouse.click(left + width / 2, y)
    web.wait_for("!part.playback.clock.playing")  # it rests where one has gone to
    assert web.wait_asked("Seek")[-1]["frame"] == pytest.approx(69.5, abs=0.5)
    web.drag((left + 0.8 * width, y), (left + 0.4 * width, y))
    web.wait_asked("SetObserved")
    web.wait_for("Math.abs(part.timebar.observed - 0.4) < 0.01")


# --- robots ---
def test_ghosts_and_second_robots_share_the_first_ones_geometry(
    browser: Browser, open_web: OpenWeb
) -> None:
    own = Server("--two", "--eyes")
    try:
        web = open_web(server=own)
        web.wait_for("part.robots.robots[1].copies[0]?.meshes > 20")
        own.command("ghosts on")
        web.wait_for("part.robots.robots[0].copies.length === 8")
        web.wait_for("part.robots.unsettled === 0")
        shared, poses, opacity = web.page.evaluate(
            """() => {
                const { robots } = window.rnnpb.part.robots;
                const robot = window.__viserMutable.nodeRefFromName["/robot"];
                const meshes = (node) =>
                    [...(node.isMesh ? [node] : []), ...node.children.flatMap(meshes)];
                const own = new Set(meshes(robot).map((mesh) => mesh.geometry));
                const shares = ({ root }) =>
                    meshes(root).every(({ geometry }) => own.has(geometry));
                const copies = [...robots[0].copies, ...robots[1].copies];
                return [
                    copies.every(shares),
                    copies.map(({ nodes }) => nodes[3].quaternion.toArray()),
                    copies.map(({ root }) => meshes(root)[0].material.opacity),
                ];
            }"""
        )
        assert shared
        assert len({tuple(pose) for pose in poses}) == 9
        assert all(one < 0.5 for one in opacity[:8])
        assert opacity[8] == 1
        web.screenshot("web-ghosts")
        own.command("ghosts off")
        web.wait_for("part.robots.robots[0].copies.length === 0")
    finally:
        own.kill()


# --- what is lost and comes back ---
def test_a_reload_brings_the_document_back(web: WebPage) -> None:
    web.drag(web.pixel("map", (0, -0.8)), web.pixel("map", ELSEWHERE))
    web.wait_heard()
    web.page.wait_for_function("() => sessionStorage.getItem('rnnpb.document')")
    puck = web.told("map", "puck")
    web.forget()
    web.page.reload()
    web.wait_ready()
    hello = web.wait_asked("Hello")[0]
    assert json.loads(hello["document"])["motion"] == 0
    assert web.told("map", "puck") == puck


def test_a_server_that_was_started_again_gets_the_document_back(open_web: OpenWeb) -> None:
    first = Server()
    web = open_web(server=first)
    web.drag(web.pixel("map", (0, -0.8)), web.pixel("map", ELSEWHERE))
    web.wait_heard()
    web.page.wait_for_function("() => sessionStorage.getItem('rnnpb.document')")
    puck = web.told("map", "puck")
    first.kill()
    second = Server("--port", str(first.port))
    try:
        assert second.port == first.port
        web.server, web._since = second, 0
        web.page.bring_to_front()
        hello = web.wait_asked("Hello")[0]
        assert hello["document"] is not None
        assert hello["playback"]["frame"] == 40
        web.wait_for("part.map.state.heard === 0")
        assert web.told("map", "puck") == puck
        expect(web.plot("map")).to_be_visible()
    finally:
        web.console_errors.clear()  # the browser's own words on the lost connection
        second.kill()


def test_boards_come_back_after_a_tab_was_switched_and_a_panel_folded(web: WebPage) -> None:
    web.page.get_by_role("tab", name="Other tab").click()
    expect(web.plot("map")).not_to_be_visible()
    web.page.get_by_role("tab", name="Map").click()
    expect(web.plot("map")).to_be_visible()
    draws = web.part("part.map.surface.draws")
    web.server.command("sibling")  # viser throws the tab's content away and makes it anew
    web.page.get_by_text("Another").wait_for()
    expect(web.plot("map")).to_be_visible()
    web.page.mouse.move(*web.pixel("map", ELSEWHERE))
    web.wait_for(f"part.map.surface.draws > {draws}")
    web.drag(web.pixel("map", (0, -0.8)), web.pixel("map", ELSEWHERE))
    assert web.wait_moved("MoveOnMap")["to"] == pytest.approx(ELSEWHERE, abs=0.02)


# --- what goes wrong ---
def test_nonsense_from_a_page_costs_that_message(web: WebPage) -> None:
    web.page.evaluate(
        """() => {
            const send = (payload) =>
                window.__viserMutable.sendMessage({ type: "RnnpbAsked", payload, more: [1] });
            for (const one of ["", "{", "[]", '{"type":"Nonsense"}', null, 7, {}, "x".repeat(3e5),
                '{"type":"SelectMotion","model":0,"index":-1}',
                '{"type":"SelectMotion","model":0,"index":"1"}',
                '{"type":"Seek","frame":1e99}', "[".repeat(9e4),
                '{"type":"MoveOnMap","model":0,"axes":[0],"to":[1,2],"gesture":1,"number":1,"done":true}',
            ]) send(one);
        }"""
    )
    web.server.command("refused")
    for _ in range(100):
        counts = [one["refused"] for one in web.server.said if "refused" in one]
        if counts and counts[-1] == 13:
            break
        web.page.wait_for_timeout(100)
        web.server.command("refused")
    assert counts[-1] == 13
    assert web.asked("SelectMotion") == []
    web.drag(web.pixel("map", (0, -0.8)), web.pixel("map", ELSEWHERE))
    web.wait_heard()
    assert place(web.told("map", "puck"))[:2] == pytest.approx(ELSEWHERE, abs=0.02)


def test_another_viser_is_said_in_one_line(open_web: OpenWeb) -> None:
    web = open_web(
        ready=False,
        init="""let real;
            Object.defineProperty(window, "__viserMutable", {
                configurable: true,
                get: () => real && { ...real, nodeRefFromName: undefined },
                set: (value) => { real = value; },
            });""",
    )
    line = "The boards need viser 1.1.1; this page's viser lacks nodeRefFromName."
    expect(web.page.get_by_role("alert").filter(has_text=line)).to_be_visible()
    assert web.wait_asked("Broken")[0]["reason"] == line
    assert web.console_errors == [f"rnnpb-explorer: {line}"]
    web.console_errors.clear()


# --- how it looks ---
@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (3840, 2160), (390, 844)])
def test_all_of_it_is_on_the_screen_and_crisp(open_web: OpenWeb, size: tuple[int, int]) -> None:
    phone = size[0] == 390
    web = open_web(
        size=size,
        resolution=1 if size[0] < 3000 else 0.5,
        device_scale_factor=2 if phone else 1,
    )
    web.server.command("path")
    web.wait_for("part.map.path !== null")
    boards = ["map"] if phone else ["map", "landscape"]
    for board in boards:
        plot = web.plot(board).bounding_box()
        assert plot is not None
        assert plot["width"] >= 220
        assert plot["height"] >= 200
        assert plot["x"] >= 0
        assert plot["y"] + plot["height"] <= size[1]
        canvas = f"part.{board}.surface.canvas"
        ratio = web.part(f"{canvas}.width / {canvas}.clientWidth")
        assert ratio == pytest.approx(2 if phone else 1, abs=0.01)
    at = web.pixel("map", ELSEWHERE)
    web.drag(web.pixel("map", tuple(web.part("part.map.puck"))), at)
    web.wait_heard()
    assert place(web.told("map", "puck"))[:2] == pytest.approx(ELSEWHERE, abs=0.02)
    bar = web.page.locator(".rb-timebar").bounding_box()
    canvas = web.page.locator("canvas[data-engine]").bounding_box()
    assert bar is not None
    assert canvas is not None
    assert bar["y"] + bar["height"] <= size[1]
    assert bar["x"] + bar["width"] <= size[0]
    assert canvas["y"] + canvas["height"] <= bar["y"] + 1
    web.page.wait_for_timeout(1500)  # for the picture
    web.screenshot(f"web-{size[0]}x{size[1]}")


def test_dark(open_web: OpenWeb) -> None:
    web = open_web(color_scheme="dark")
    assert web.asked("Hello")[0]["dark"]
    web.server.command("dark on")
    web.wait_for("part.map.theme.plot === '#1a1d21'")
    background = "getComputedStyle(document.querySelector('.rb-timebar')).backgroundColor"
    assert web.part(background) == "rgb(36, 36, 36)"  # as viser's panels
    web.page.wait_for_timeout(1500)  # for the picture
    web.screenshot("web-dark")
