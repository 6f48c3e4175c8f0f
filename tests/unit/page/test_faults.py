"""What goes wrong with one page, or around the server, and that no other page notices."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch
from viser import _messages as wire

from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.app.page.session import Session
from rnnpb_explorer.core.motion import Motion, format_motion

from ..wire_browser import TIMEOUT, WireBrowser
from .test_session import PEPPER_JOINTS, save_model

Open = Callable[[], tuple[WireBrowser, Session]]
CIRCLE = [(float(np.cos(a)), float(np.sin(a))) for a in np.linspace(0, 6, 40)]


@pytest.fixture
def models(tmp_path: Path) -> Path:
    folder = tmp_path / "models"
    folder.mkdir()
    for name in ("tiny", "second"):
        save_model(folder / f"{name}.pt")
    return folder


@pytest.fixture
def app(models: Path) -> Iterator[App]:
    options = ServerOptions(checkpoints=(str(models / "tiny.pt"),), models=str(models), port=0)
    running = start(options)
    yield running
    running.stop()


@pytest.fixture
def open_page(app: App) -> Iterator[Open]:
    opened: list[WireBrowser] = []

    def open_one() -> tuple[WireBrowser, Session]:
        before = set(app.sessions)
        browser = WireBrowser(app.url)
        opened.append(browser)
        browser.wait_for(lambda: browser.shown.get("LandscapeShown", {}).get("complete"))
        return browser, app.sessions[max(set(app.sessions) - before)]

    yield open_one
    for browser in opened:
        browser.leave()


@pytest.fixture
def bystander(open_page: Open) -> Iterator[WireBrowser]:
    """A page that has nothing to do with it: it is as it was, and goes on."""
    browser, session = open_page()
    before = session.document
    yield browser
    assert session.document == before
    assert browser.notices == []
    browser.drag("map", (0.2, 0.1), (0.25, 0.1))
    browser.wait_for(lambda: browser.shown["PuckShown"]["heard"] == browser.moves)


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + TIMEOUT
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def given() -> bytes:
    time_ = np.linspace(0, 6, 400)[:, None]
    positions = (0.3 * np.sin(time_ + np.arange(17))).astype(np.float32)
    return format_motion(Motion("given", PEPPER_JOINTS, positions)).encode()


# --- a browser that vanishes ---
def drag(browser: WireBrowser) -> None:
    browser.drag("map", *CIRCLE)


def upload(browser: WireBrowser) -> None:
    """The first half of a file."""
    browser.widget("Upload a motion")
    content = given()
    source = browser._uuid("Upload a motion") or ""
    name = ("given.csv", "text/csv", 2, len(content))
    browser._send(wire.FileTransferStartUpload(source, "half", *name))
    browser._send(wire.FileTransferPart(source, "half", 0, content[: len(content) // 2]))


def recognise(browser: WireBrowser) -> None:
    browser.upload("Upload a motion", "given.csv", given())
    browser.wait_for(lambda: any("ready to recognise" in one for one in browser.notices))
    browser.set("Method", "as published: sampling and Adam")
    browser.press("Start")
    browser.wait_for(lambda: len(browser.shown["PathShown"]["radii"]) > 2)


@pytest.mark.parametrize("doing", [drag, upload, recognise])
def test_a_browser_that_vanishes_in_the_middle_leaves_nothing(
    app: App, open_page: Open, bystander: WireBrowser, doing: Callable[[WireBrowser], None]
) -> None:
    browser, session = open_page()
    doing(browser)
    browser.vanish()
    wait_until(lambda: session not in app.sessions.values())
    session.join(TIMEOUT)
    assert not session._thread.is_alive()
    schedule = app._engine._schedule
    wait_until(lambda: not schedule._jobs)  # nothing is computed for nobody
    assert len(app.sessions) == 1


# --- a tab that is frozen ---
def test_a_frozen_page_costs_no_memory_and_comes_back_to_what_is_there(
    open_page: Open, bystander: WireBrowser
) -> None:
    teacher, shows = open_page()
    teacher.press("Present this page")
    teacher.wait_for(lambda: teacher.shown["PresenceShown"]["role"] == "presents")
    browser, session = open_page()
    code = teacher.shown["PresenceShown"]["code"]
    browser._follow = code
    browser.hello()
    browser.wait_for(lambda: browser.shown["PresenceShown"]["there"])
    browser.freeze()
    queued = session._client._websock_connection
    moves = 0
    for number in range(12):
        through = np.roll(CIRCLE, number, axis=0)[:15].tolist()
        teacher.drag("map", *through)
        moves += len(through)
        teacher.wait_for(lambda: teacher.shown["PuckShown"]["heard"] == teacher.moves)
    assert session.wait_for(lambda it: it.document.models == shows.document.models, TIMEOUT)
    waiting = queued._state.message_buffer.message_from_id
    assert len(waiting) < moves / 2  # of each kind the newest alone is kept
    before = browser.messages
    browser.thaw()
    there = teacher.shown["PuckShown"]["on_map"]
    browser.wait_for(lambda: np.allclose(browser.shown["PuckShown"]["on_map"], there))
    assert browser.messages > before


# --- the server's own parts ---
def test_a_fault_of_a_worker_is_told_to_its_page(
    app: App, open_page: Open, bystander: WireBrowser, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = app.library.models["tiny"]
    generate = model.generate

    def breaking(pb: torch.Tensor, steps: int) -> torch.Tensor:
        if (pb[:, 1] == 0.625).any():
            raise RuntimeError("a fault of the processor")
        return generate(pb, steps)

    monkeypatch.setattr(model, "generate", breaking)
    browser, session = open_page()
    browser.set("μ 2", 0.625)
    browser.wait_for(lambda: any("a fault of the processor" in one for one in browser.notices))
    browser.set("μ 2", 0.25)
    assert session.wait_for(lambda it: it.choice.latent.mu[1] == 0.25, TIMEOUT)
    number = browser.shown["MotionShown 0"]["number"]
    browser.set("μ 2", 0.375)
    browser.wait_for(lambda: browser.shown["MotionShown 0"]["number"] > number)


def test_a_checkpoint_that_disappears_is_missed_by_who_has_not_loaded_it(
    models: Path, open_page: Open, bystander: WireBrowser
) -> None:
    browser, session = open_page()
    (models / "tiny.pt").unlink()  # all have that one
    (models / "second.pt").unlink()
    browser.set("Model", "second")
    browser.wait_for(lambda: any("second.pt" in one for one in browser.notices))
    assert session.document.models[0].name == "tiny"
    browser.set("Motion", "bow")
    browser.wait_for(lambda: browser.shown["MapShown"]["selected"] == 1)
    _, other = open_page()
    assert other.document.models[0].name == "tiny"


@pytest.mark.parametrize("jump", [-86_400.0, 86_400.0])
def test_a_clock_that_jumps_changes_nothing(
    open_page: Open, bystander: WireBrowser, monkeypatch: pytest.MonkeyPatch, jump: float
) -> None:
    browser, session = open_page()
    now = time.time
    monkeypatch.setattr(time, "time", lambda: now() + jump)
    browser.drag("map", *CIRCLE)
    browser.wait_for(lambda: browser.shown["PuckShown"]["heard"] == browser.moves)
    recognise(browser)
    steps = len(session._history.past)
    browser.ask("Undo")
    wait_until(lambda: len(session._history.past) < steps)
