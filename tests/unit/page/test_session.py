"""The whole app behind its wire: what a browser sends, and what becomes of it; no page is drawn."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch
from msgspec.structs import replace

from rnnpb_explorer.app.engine.engine import Delivered
from rnnpb_explorer.app.page import server as server_module
from rnnpb_explorer.app.page import session as session_module
from rnnpb_explorer.app.page.screen import Screen
from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.app.page.session import LOST, STOPPED, Event, Session
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import Document
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.statecode import PREFIX
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.app.state.wanted import wanted
from rnnpb_explorer.core.checkpoint import load_checkpoint, save_checkpoint
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS

from ..wire_browser import TIMEOUT, WireBrowser

NAMES = ("wave", "bow", "rest")


def save_model(path: Path, *, pb_dim: int = 3, names: tuple[str, ...] = NAMES) -> Path:
    """A checkpoint of random weights that moves Pepper's joints."""
    info = ModelInfo(joints=PEPPER_JOINTS, motions=names, lengths=(12, 9, 15)[: len(names)])
    config = ModelConfig(num_joints=17, pb_dim=pb_dim, hidden_size=16, num_motions=len(names))
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(pb_dim)
        model = RNNPB(config, info)
        torch.nn.init.normal_(model.mu)
        torch.nn.init.normal_(model.log_var, mean=-2.0, std=0.5)
    save_checkpoint(model, path)
    return path


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_model(tmp_path_factory.mktemp("models") / "tiny.pt")


@pytest.fixture(scope="module")
def app(checkpoint: Path) -> Iterator[App]:
    running = start(ServerOptions(checkpoints=(str(checkpoint),), port=0))
    yield running
    running.stop()


Open = Callable[..., tuple[WireBrowser, Session]]


@pytest.fixture
def open_browser(app: App) -> Iterator[Open]:
    """Open browsers, each with the session that serves it, its screen complete."""
    opened: list[WireBrowser] = []

    def open_one(
        storage: dict[str, str] | None = None, of: App = app
    ) -> tuple[WireBrowser, Session]:
        before = set(of.sessions)
        browser = WireBrowser(of.url, storage)
        opened.append(browser)
        browser.widget("Motion")  # the session builds its screen
        session = of.sessions[max(set(of.sessions) - before)]
        until(session, complete)
        return browser, session

    yield open_one
    for browser in opened:
        browser.leave()


def until(session: Session, condition: Callable[[Picture], bool]) -> Picture:
    """Wait until a picture that fulfils the condition has been shown; that picture."""
    seen: list[Picture] = []

    def fulfils(picture: Picture) -> bool:
        seen[:] = [picture]
        return condition(picture)

    assert session.wait_for(fulfils, TIMEOUT)
    return seen[0]


def complete(picture: Picture) -> bool:
    """Whether all that this picture shows has been computed."""
    return not picture.computed.missing(wanted(picture.facts, picture.document))


def now(session: Session) -> Picture:
    """What is on the screen."""
    return until(session, lambda _: True)


def steps(session: Session) -> int:
    """How often one could undo."""
    return len(session._history.past)


def mu(picture: Picture) -> tuple[float, ...]:
    return picture.choice.latent.mu


def leave(browser: WireBrowser, session: Session) -> None:
    """Close the window and wait until the server has noticed."""
    noticed, close = threading.Event(), session.close

    def closing() -> None:
        close()
        noticed.set()

    session.close = closing  # type: ignore[method-assign]
    browser.leave()
    assert noticed.wait(TIMEOUT)


def shown(picture: Picture) -> list[str]:
    """The motion that each model shows."""
    pairs = zip(picture.facts, picture.document.models, strict=True)
    return [facts.motions[model.latent.motion] for facts, model in pairs]


def upload(browser: WireBrowser, motion: Motion, name: str = "mine.csv") -> None:
    browser.upload("Upload a motion", name, format_motion(motion).encode())


@pytest.fixture(scope="module")
def target(checkpoint: Path) -> Motion:
    """A motion that the model can make: its third one, a little longer."""
    model = load_checkpoint(checkpoint)
    with torch.inference_mode():
        positions = model.generate(model.mu[2:3], 20)[0].numpy()
    return Motion("mine", PEPPER_JOINTS, positions)


# --- one browser ---
def test_the_screen_opens_with_a_motion_that_plays(open_browser: Open, app: App) -> None:
    browser, session = open_browser()
    assert browser.widget("Motion")["value"] == "wave"
    assert browser.widget("μ 1")["value"] == pytest.approx(app.facts[0].mu[0, 0], abs=0.01)
    until(session, lambda picture: picture.document.playback.phase > 0)
    assert "/boards/map" in browser.nodes
    assert "/boards/landscape" in browser.nodes
    assert any(name.startswith("/robot-0/") for name in browser.nodes)


def test_the_robot_moves_on_the_screen(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.command("Play or pause")
    until(session, lambda picture: not picture.document.playback.playing)
    browser.set("Frame", 3)
    until(session, lambda picture: picture.document.playback.phase == pytest.approx(3 / 11))
    before = {name: node.get("wxyz") for name, node in browser.nodes.items()}
    browser.set("Frame", 9)
    browser.wait_for(
        lambda: any(node.get("wxyz") != before.get(name) for name, node in browser.nodes.items())
    )
    moved = [n for n, node in browser.nodes.items() if node.get("wxyz") != before.get(n)]
    assert all(name.startswith("/robot-0/") for name in moved)


def test_a_slider_moves_mu_and_the_motion(open_browser: Open) -> None:
    browser, session = open_browser()
    before = now(session).motion()
    browser.set("μ 2", 0.5)
    moved = until(session, lambda picture: mu(picture)[1] == 0.5 and complete(picture))
    assert not np.allclose(moved.motion(), before)


def test_a_drag_on_the_map_moves_the_puck_to_the_pointer(open_browser: Open, app: App) -> None:
    browser, session = open_browser()
    board = app.facts[0].latent_map
    before = board.project(session.document.current.latent.mu)
    node = browser.nodes["/boards/map"]
    place = node["position"]
    through = [(place[0], place[1] + y, place[2]) for y in (0.0, 0.05, 0.1)]
    browser.drag("/boards/map", *through)
    until(session, lambda picture: steps(session) == 1 and complete(picture))
    after = board.project(session.document.current.latent.mu)
    assert not np.allclose(after[:2], before[:2])
    np.testing.assert_allclose(after[2:], before[2:], atol=1e-9)
    at = np.array(browser.nodes["/boards/map-puck"]["position"])
    eye = np.array([4.0, 0.0, 1.0])
    ray = np.array(through[-1]) - eye
    pointer = eye + (at[0] - eye[0]) / ray[0] * ray
    np.testing.assert_allclose(at[1:], pointer[1:], atol=0.01)
    browser.command("Undo")
    until(session, lambda _: not steps(session))
    np.testing.assert_allclose(board.project(session.document.current.latent.mu), before)


def test_a_motion_is_chosen_from_the_list(open_browser: Open, app: App) -> None:
    browser, session = open_browser()
    browser.set("Motion", "rest")
    until(session, lambda picture: picture.choice.latent.motion == 2 and complete(picture))
    assert session.document.current.latent.mu == tuple(app.facts[0].mu[2].tolist())
    browser.wait_for(lambda: browser.widget("Frame")["max"] == 14)


def test_an_upload_is_recognised(open_browser: Open, target: Motion) -> None:
    browser, session = open_browser()
    upload(browser, target)
    until(session, lambda picture: picture.document.target is not None)
    assert session.document.target is not None
    np.testing.assert_array_equal(session.document.target.array, target.positions)
    browser.set("Iterations", 10)
    until(session, lambda picture: picture.document.recognition.iterations == 10)
    browser.press("Start")
    done = until(session, lambda picture: picture.run_status == "finished" and complete(picture))
    assert done.trace is not None
    assert done.trace.iterations == 10
    browser.wait_for(lambda: bool(browser.widget("Iteration")["visible"]))


def test_a_failed_upload_leaves_the_target_and_the_session(
    open_browser: Open, target: Motion
) -> None:
    browser, session = open_browser()
    upload(browser, target)
    until(session, lambda picture: picture.document.target is not None)
    kept = session.document.target
    browser.upload("Upload a motion", "bad.csv", b"HeadYaw,HeadPitch\n1,2\n")
    browser.wait_for(lambda: any("bad.csv" in notice for notice in browser.notices))
    assert session.document.target is kept
    browser.set("μ 1", 0.25)
    until(session, lambda picture: mu(picture)[0] == 0.25)


def test_an_export_arrives_and_can_be_uploaded_again(open_browser: Open) -> None:
    browser, session = open_browser()
    positions = now(session).motion()
    assert positions is not None
    for label, suffix in (("CSV", ".csv"), ("JSON", ".json"), ("NAOqi script", ".py")):
        browser.set("Format", label)
        browser.press("Export the motion")
        name = f"wave_tiny{suffix}"
        browser.wait_for(lambda name=name: name in browser.files)
        browser.upload("Upload a motion", name, browser.files[name])
        got = until(session, lambda now: now.document.target is not None and complete(now))
        assert got.document.target is not None
        assert got.checked is not None
        found = got.document.target.array
        assert found.shape == positions.shape
        within = got.checked.report.light == "green"
        assert np.allclose(found, positions, atol=1e-6) == within
        browser.press("Forget the target")
        until(session, lambda picture: picture.document.target is None and complete(picture))


def test_the_limited_robot_comes_back_after_a_reload(open_browser: Open) -> None:
    storage: dict[str, str] = {}
    browser, session = open_browser(storage)
    assert not any(name.startswith("/robot-1") for name in browser.nodes)
    browser.set("Side by side", True)
    until(session, lambda picture: picture.document.side_by_side and complete(picture))
    checked = now(session).checked
    assert checked is not None
    assert checked.limited is not None
    browser.wait_for(lambda: "/robot-1" in browser.nodes)
    browser.leave()
    again, session = open_browser(storage)
    again.wait_for(lambda: "/robot-1" in again.nodes)
    assert session.document.side_by_side
    again.wait_for(lambda: again.widget("Side by side")["value"])


def test_a_code_of_the_screen_restores_it(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.set("μ 3", 0.75)
    until(session, lambda picture: mu(picture)[2] == 0.75)
    browser.press("Show the code of this screen")
    browser.wait_for(lambda: str(browser.widget("Code")["value"]).startswith("rnnpb2-"))
    code = browser.widget("Code")["value"]
    other, other_session = open_browser()
    other.set("Code", code)
    other.press("Restore from the code")
    until(other_session, lambda picture: mu(picture)[2] == 0.75)


def test_a_code_brings_an_upload_and_its_recognition_to_another_page(
    open_browser: Open, target: Motion
) -> None:
    browser, session = open_browser()
    upload(browser, target)
    browser.set("Iterations", 10)
    until(session, lambda picture: picture.document.recognition.iterations == 10)
    browser.press("Start")
    end = until(session, lambda picture: picture.run_status == "finished" and complete(picture))
    browser.press("Show the code of this screen")
    browser.wait_for(lambda: str(browser.widget("Code")["value"]).startswith(PREFIX))
    other, other_session = open_browser()
    other.set("Code", browser.widget("Code")["value"])
    other.press("Restore from the code")
    again = until(
        other_session, lambda picture: picture.document.target is not None and complete(picture)
    )
    assert again.document.target == end.document.target
    assert again.document.run == end.document.run
    assert again.run_status == "finished"
    assert again.trace is not None
    assert end.trace is not None
    np.testing.assert_array_equal(again.trace.loss, end.trace.loss)
    np.testing.assert_array_equal(again.motion(), end.motion())
    other.wait_for(lambda: bool(other.widget("Iteration")["visible"]))


def test_a_code_too_long_for_a_line_is_a_file_that_can_be_uploaded(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session_module, "MAX_LINE", 200)
    browser, session = open_browser()
    browser.set("μ 3", 0.75)
    until(session, lambda picture: mu(picture)[2] == 0.75)
    browser.press("Show the code of this screen")
    browser.wait_for(lambda: any("saved as a file" in notice for notice in browser.notices))
    assert browser.widget("Code")["value"] == ""
    ((name, content),) = browser.files.items()
    other, other_session = open_browser()
    other.upload("Upload a motion", name, content)
    until(other_session, lambda picture: mu(picture)[2] == 0.75)
    assert other_session.document.target is None
    assert steps(other_session) == 1


def test_nonsense_for_a_code_is_a_notice(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.set("Code", "nonsense")
    browser.press("Restore from the code")
    browser.wait_for(lambda: any("not a state code" in notice for notice in browser.notices))
    assert steps(session) == 0


# --- undo ---
def test_undo_of_an_upload_takes_the_upload_alone(open_browser: Open, target: Motion) -> None:
    browser, session = open_browser()
    browser.set("Uploaded target", False)
    until(session, lambda picture: not picture.document.use_target)
    before = now(session).document
    upload(browser, target)
    until(session, lambda picture: picture.document.target is not None and complete(picture))
    browser.wait_for(lambda: bool(browser.widget("Uploaded target")["value"]))
    browser.command("Undo")
    undone = until(session, lambda picture: picture.document.target is None and complete(picture))
    assert not undone.document.use_target
    assert undone.document == replace(before, playback=undone.document.playback)
    reference, own = undone.reference(), undone.facts[0].lengths[0]
    assert reference is not None
    assert len(reference) == own
    browser.wait_for(lambda: not browser.widget("Uploaded target")["value"])
    browser.command("Redo")
    until(session, lambda picture: picture.document.use_target and complete(picture))
    assert session.document.target is not None


# --- what comes late, or twice ---
def test_a_result_that_comes_late_is_not_shown_as_current(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser, session = open_browser()
    browser.command("Play or pause")
    before = until(session, lambda picture: not picture.document.playback.playing)
    late = dict(before.computed.entries)
    browser.set("μ 3", 0.75)  # across the landscape
    moved = until(session, lambda picture: mu(picture)[2] == 0.75 and complete(picture))
    shown: list[Picture] = []
    show = Screen.show

    def noting(screen: Screen, picture: Picture) -> None:
        shown.append(picture)
        show(screen, picture)

    monkeypatch.setattr(Screen, "show", noting)
    for slot, entry in late.items():
        session.send(Delivered(slot, entry.work, entry.result, done=True))
    browser.set("Frame", 3)  # comes after them
    end = until(session, lambda picture: picture.frame() == 3)
    assert all(picture.landscape_complete for picture in shown)
    assert end.motion() is moved.motion()
    assert end.landscape == moved.landscape


def test_what_was_answered_while_it_was_not_wanted_comes_all_the_same(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody goes away and back while the answer waits to be heard of."""
    browser, session = open_browser()
    browser.command("Play or pause")
    until(session, lambda picture: not picture.document.playback.playing and complete(picture))
    here = mu(now(session))[2]
    held: list[Event] = []
    answered, next_events = threading.Event(), Session._next_events

    def holding(of: Session, wait: float | None) -> list[Event]:
        """Only with the answers do the two moves before and after them come, all at once."""
        events = next_events(of, wait)
        if of is not session or answered.is_set():
            return events
        mine = [event for event in events if isinstance(event, Delivered)]
        held.extend(mine)
        if any(event.slot[0] == "motion" and event.done for event in held):
            answered.set()
            return [do.SetMu(2, here), *held, do.SetMu(2, 0.75)]
        return [event for event in events if event not in mine]

    monkeypatch.setattr(Session, "_next_events", holding)
    browser.set("μ 3", 0.75)
    until(session, lambda picture: answered.is_set() and complete(picture))
    assert mu(now(session))[2] == 0.75


def test_a_file_can_be_asked_for_again_and_again(open_browser: Open) -> None:
    browser, session = open_browser()
    for times in (1, 2, 3):
        browser.press("Export the motion")
        browser.wait_for(lambda times=times: saved(browser) == times)
    assert complete(now(session))


def saved(browser: WireBrowser) -> int:
    """How often the browser was told that a file was written."""
    return sum("wave_tiny" in notice for notice in browser.notices)


# --- several browsers ---
def test_each_browser_has_a_session_of_its_own(open_browser: Open) -> None:
    (one, first), (_, second) = open_browser(), open_browser()
    before = second.document.current.latent
    one.set("μ 1", 0.125)
    one.set("Motion", "bow")
    until(first, lambda picture: picture.choice.latent.motion == 1 and complete(picture))
    assert second.document.current.latent is before
    assert first is not second


def test_a_reload_brings_the_same_screen_back(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    browser.leave()
    again, session = open_browser(browser.storage)
    assert session.document.current.latent.mu[0] == 0.125
    assert again.widget("μ 1")["value"] == pytest.approx(0.125, abs=0.01)
    _, stranger = open_browser()
    assert stranger.document.current.latent.mu[0] != 0.125


def test_a_reload_in_the_middle_of_a_run_goes_on_with_it(
    open_browser: Open, target: Motion
) -> None:
    browser, session = open_browser()
    upload(browser, target)
    browser.set("Iterations", 300)
    browser.set("Trials", 10)
    until(session, lambda picture: picture.document.recognition.trials == 10)
    browser.press("Start")
    until(
        session, lambda picture: picture.run_status == "running" and picture.document.run.done > 0
    )
    leave(browser, session)
    _, session = open_browser(browser.storage)
    end = until(session, lambda picture: picture.run_status == "finished" and complete(picture))
    assert end.trace is not None
    assert end.trace.loss.shape == (300, 10)


def test_each_of_two_pages_of_a_browser_gets_its_own_screen_back(open_browser: Open) -> None:
    storage: dict[str, str] = {}
    pages = [open_browser(storage) for _ in range(2)]
    for value, (page, session) in zip((0.125, 0.25), pages, strict=True):
        page.set("μ 1", value)
        until(session, lambda picture, value=value: mu(picture)[0] == value)
    for value, (page, session) in zip((0.125, 0.25), pages, strict=True):
        leave(page, session)
        page, again = open_browser(storage)
        assert again.document.current.latent.mu[0] == value
    # A third one finds none that was closed.
    page.set("μ 1", 0.375)
    until(again, lambda picture: mu(picture)[0] == 0.375)
    _, third = open_browser(storage)
    assert third.document.current.latent.mu[0] == 0.375


def test_a_second_page_begins_with_what_the_first_one_shows(open_browser: Open) -> None:
    storage: dict[str, str] = {}
    page, session = open_browser(storage)
    page.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    _, second = open_browser(storage)
    assert second.document.current.latent.mu[0] == 0.125


def test_a_page_that_is_reloaded_again_before_it_shows_anything_loses_nothing(
    app: App, open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, session = open_browser()
    page.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    leave(page, session)
    session.join(TIMEOUT)  # so that it shows nothing any more
    building, go_on = threading.Event(), threading.Event()

    def slow(screen: Screen, picture: Picture) -> None:
        if mu(picture)[0] == 0.125:
            building.set()
            assert go_on.wait(TIMEOUT)

    with monkeypatch.context() as patch:
        patch.setattr(Screen, "show", slow)
        hasty = WireBrowser(app.url, page.storage)
        assert building.wait(TIMEOUT)
        session = app.sessions[max(app.sessions)]
        leave(hasty, session)
        go_on.set()
        session.join(TIMEOUT)
    _, session = open_browser(page.storage)
    assert session.document.current.latent.mu[0] == 0.125


def test_no_more_pages_than_the_server_takes(
    checkpoint: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server_module, "MAX_SESSIONS", 1)
    running = start(ServerOptions(checkpoints=(str(checkpoint),), port=0))
    try:
        first = WireBrowser(running.url)
        first.widget("Motion")
        (session,) = running.sessions.values()
        second = WireBrowser(running.url)
        second.wait_for(lambda: "1 pages already" in str(second.widgets))
        assert list(running.sessions.values()) == [session]
        leave(first, session)
        second.leave()
        WireBrowser(running.url, second.storage).widget("Motion")
    finally:
        running.stop()


# --- faults ---
Break = Callable[[Document, do.Intent], bool]


@pytest.fixture
def break_when(monkeypatch: pytest.MonkeyPatch) -> Callable[[Break], None]:
    """Have the update of some states and intents fail."""

    def install(breaks: Break) -> None:
        def failing(facts: Facts, document: Document, intent: do.DocumentIntent) -> Document:
            if breaks(document, intent):
                raise ZeroDivisionError("made for a test")
            return update(facts, document, intent)

        monkeypatch.setattr(session_module, "update", failing)

    return install


def has_stopped(browser: WireBrowser) -> None:
    browser.wait_for(lambda: STOPPED in browser.notices)


def stop_and_reload(
    browser: WireBrowser, session: Session, open_browser: Open
) -> tuple[WireBrowser, Session]:
    """Move mu 1, which goes well, then mu 2, which meets the fault; the page is as before it."""
    browser.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    browser.set("μ 2", 0.5)
    has_stopped(browser)
    browser.leave()
    again, session = open_browser(browser.storage)
    assert session.document.current.latent.mu[0] == 0.125
    return again, session


def test_a_page_that_meets_a_fault_says_so_and_comes_back_as_it_was(
    open_browser: Open, break_when: Callable[[Break], None]
) -> None:
    break_when(lambda _, intent: intent == do.SetMu(1, 0.5))
    browser, session = open_browser()
    again, session = stop_and_reload(browser, session, open_browser)
    again.set("μ 2", 0.25)
    until(session, lambda picture: mu(picture)[1] == 0.25)
    assert again.notices == []


def test_a_state_that_cannot_be_shown_is_not_kept(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    show = Screen.show

    def fails(screen: Screen, picture: Picture) -> None:
        if mu(picture)[1] == 0.5:
            raise ZeroDivisionError("made for a test")
        show(screen, picture)

    monkeypatch.setattr(Screen, "show", fails)
    browser, session = open_browser()
    again, session = stop_and_reload(browser, session, open_browser)
    assert session.document.current.latent.mu[1] != 0.5
    assert again.notices == []


def test_a_kept_screen_that_cannot_be_built_gives_way_to_the_opening_one(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    reset_view = Screen.reset_view
    browser, session = open_browser()
    opening = session.document.current.latent.mu[0]
    browser.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    leave(browser, session)
    built: list[Screen] = []

    def fails(screen: Screen) -> None:
        """At the end of building the first one."""
        built.append(screen)
        if len(built) == 1:
            raise ZeroDivisionError("made for a test")
        reset_view(screen)

    monkeypatch.setattr(Screen, "reset_view", fails)
    again, session = open_browser(browser.storage)
    assert session.document.current.latent.mu[0] == opening
    again.wait_for(lambda: again.notices == [LOST])
    labels = [widget.get("label") for widget in again.widgets.values()]
    assert labels.count("Motion") == 1
    again.set("μ 1", 0.25)
    until(session, lambda picture: mu(picture)[0] == 0.25)


def test_a_screen_that_leads_to_a_fault_twice_is_given_up(
    app: App, open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It can be shown, but the motion that it asks for ends the page."""
    follow = Session._deliver

    def failing(session: Session, event: Delivered, screen: Screen) -> None:
        if event.slot[0] == "motion" and session.document.current.latent.mu[0] == 0.125:
            raise ZeroDivisionError("made for a test")
        follow(session, event, screen)

    monkeypatch.setattr(Session, "_deliver", failing)
    browser, session = open_browser()
    opening = session.document.current.latent.mu[0]
    browser.set("μ 1", 0.125)
    has_stopped(browser)
    browser.leave()
    again = WireBrowser(app.url, browser.storage)
    has_stopped(again)
    again.leave()
    last, session = open_browser(browser.storage)
    assert session.document.current.latent.mu[0] == opening
    last.wait_for(lambda: last.notices == [LOST])


# --- at rest ---
@pytest.fixture
def resting(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Set whenever a session waits for nothing but an intent."""
    rests, drain = threading.Event(), Session._next_events

    def noting(session: Session, wait: float | None) -> list[Event]:
        if wait is None:
            rests.set()
        return drain(session, wait)

    monkeypatch.setattr(Session, "_next_events", noting)
    return rests


def paused(browser: WireBrowser, session: Session, resting: threading.Event) -> None:
    browser.command("Play or pause")
    until(session, lambda picture: not picture.document.playback.playing)
    assert resting.wait(TIMEOUT)
    resting.clear()


def test_a_session_rests_where_nothing_changes_and_goes_on_from_there(
    open_browser: Open, resting: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser, session = open_browser()
    assert not resting.is_set()  # the motion plays
    paused(browser, session, resting)
    ticks: list[float] = []

    def noting(facts: Facts, document: Document, intent: do.DocumentIntent) -> Document:
        if isinstance(intent, do.Tick):
            ticks.append(intent.seconds)
        return update(facts, document, intent)

    monkeypatch.setattr(session_module, "update", noting)
    browser.command("Play or pause")
    until(session, lambda picture: picture.document.playback.playing)
    assert ticks[0] == 0.0
    phase = session.document.playback.phase
    until(session, lambda picture: picture.document.playback.phase != phase)


def test_a_session_at_rest_resets_the_view(
    open_browser: Open, resting: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser, session = open_browser()
    paused(browser, session, resting)
    went_home = threading.Event()
    monkeypatch.setattr(Screen, "reset_view", lambda screen: went_home.set())
    browser.command("Reset the view")
    assert went_home.wait(TIMEOUT)


def test_a_session_at_rest_shows_its_code(open_browser: Open, resting: threading.Event) -> None:
    browser, session = open_browser()
    paused(browser, session, resting)
    browser.press("Show the code of this screen")
    browser.wait_for(lambda: str(browser.widget("Code")["value"]).startswith("rnnpb2-"))


def test_a_page_at_rest_shows_other_sliders_at_once(
    checkpoint: Path, tmp_path: Path, open_browser: Open, resting: threading.Event
) -> None:
    wide = save_model(tmp_path / "wide.pt", pb_dim=12)
    running = start(ServerOptions(checkpoints=(str(wide),), port=0))
    try:
        browser, session = open_browser(of=running)
        paused(browser, session, resting)
        assert not browser.has("μ 9")
        browser.set("Dimensions", "9–12")
        browser.wait_for(lambda: browser.has("μ 12") and not browser.has("μ 8"))
        assert browser.widget("Dimensions")["value"] == "9–12"
        browser.set("μ 9", 0.5)
        until(session, lambda picture: mu(picture)[8] == 0.5)
        browser.command("Undo")
        until(session, lambda picture: mu(picture)[8] != 0.5)
        assert browser.has("μ 9")  # undo leaves the page of sliders
    finally:
        running.stop()


def test_what_is_written_late_is_written_before_a_rest(
    open_browser: Open, resting: threading.Event
) -> None:
    """A widget that a person holds gets the state's value only when it is let go."""
    browser, session = open_browser()
    paused(browser, session, resting)
    browser.set("Frame", 99)
    browser.wait_for(lambda: browser.widget("Frame")["value"] == 11)


# --- leaving ---
def page_threads() -> set[threading.Thread]:
    return {thread for thread in threading.enumerate() if thread.name.startswith("page-")}


def test_after_a_fault_nothing_is_kept_for_the_page_and_its_place_is_free(
    open_browser: Open, break_when: Callable[[Break], None], app: App
) -> None:
    break_when(lambda _, intent: intent == do.SetMu(1, 0.5))
    browser, session = open_browser()
    browser.set("μ 2", 0.5)
    has_stopped(browser)
    assert session not in app.sessions.values()
    session.join(TIMEOUT)
    waiting = session._events.qsize()
    browser.set("μ 1", 0.125)  # the page is still open, and somebody goes on in it
    session.send(do.SetMu(0, 0.25))
    _, other = open_browser()  # by then the server has heard of it
    assert session._events.qsize() == waiting
    assert complete(now(other))


def test_pages_that_leave_take_their_threads_with_them(
    app: App, open_browser: Open, resting: threading.Event
) -> None:
    before = set(threading.enumerate())
    pages = [open_browser() for _ in range(16)]
    assert len(page_threads() - before) == 16  # one each: the engine's are everybody's
    new = set(threading.enumerate()) - before
    paused(*pages[0], resting)  # the others play
    for browser, session in pages:
        leave(browser, session)
        session.join(TIMEOUT)
        assert session not in app.sessions.values()
    for thread in new:
        if thread.name.startswith(("page-", "upload")):
            assert not thread.is_alive()


def test_a_browser_that_leaves_at_the_door_leaves_nothing(app: App, open_browser: Open) -> None:
    hasty = WireBrowser(app.url, silent=True)
    assert hasty.asked.wait(TIMEOUT)  # the server waits for an answer now
    sessions = set(app.sessions)
    hasty.leave()
    _, session = open_browser()  # by then the server has noticed
    left = {app.sessions[number] for number in set(app.sessions) - sessions}
    assert left == {session}


def test_stopping_ends_every_session_and_frees_the_port(
    checkpoint: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = set(threading.enumerate())
    running = start(ServerOptions(checkpoints=(str(checkpoint),), port=0))
    browsers = [WireBrowser(running.url) for _ in range(2)]
    for browser in browsers:
        browser.widget("Motion")
    sessions = list(running.sessions.values())
    mine = {t for t in set(threading.enumerate()) - before if t.name.startswith(("page", "engine"))}
    told: list[bool] = []
    join = Session.join

    def noting(session: Session, timeout: float) -> None:
        told.append(all(each._closed for each in sessions))
        join(session, timeout)

    monkeypatch.setattr(Session, "join", noting)
    running.stop()
    assert told == [True, True]  # all were told to end before any was waited for
    assert not any(thread.is_alive() for thread in mine)
    port = int(running.url.rpartition(":")[2])
    again = start(ServerOptions(checkpoints=(str(checkpoint),), port=port))
    assert again.url == running.url
    again.stop()


# --- models side by side ---
def test_two_models_of_different_sizes_on_one_screen(
    checkpoint: Path, tmp_path: Path, open_browser: Open, resting: threading.Event
) -> None:
    line = save_model(tmp_path / "line.pt", pb_dim=1, names=("bow", "wave"))
    wide = save_model(tmp_path / "wide.pt", pb_dim=12)
    both = start(ServerOptions(checkpoints=(str(line), str(wide), str(checkpoint)), port=0))
    try:
        browser, session = open_browser(of=both)
        assert shown(now(session)) == ["bow", "bow", "bow"]
        assert {"/robot-0", "/robot-1", "/robot-2"} <= set(browser.nodes)
        paused(browser, session, resting)
        for name in ("wide", "tiny", "line"):
            before = browser.widget("μ 1")
            browser.set("Model", name)
            until(session, lambda picture, name=name: picture.model.name == name)
            # Another model has sliders of its own.
            browser.wait_for(lambda before=before: browser.widget("μ 1") is not before)
            browser.set("Motion", "wave")
            until(session, lambda picture: shown(picture) == ["wave"] * 3 and complete(picture))
            resting.clear()
            browser.set("Speed ×", 1.5)  # it has only to wake the page
            assert resting.wait(TIMEOUT)  # all is drawn: a hand on another model's board is none
            taken = steps(session)
            browser.drag("/boards/map", (0.0, -1.0, 1.1), (0.0, -0.9, 1.1))
            browser.drag("/boards/landscape", (0.0, -1.0, 0.4), (0.0, -0.9, 0.4))
            # One hand: it takes a slider when it has let go of the board.
            until(session, lambda _, taken=taken: steps(session) == taken + 2)
            browser.set("μ 1", 0.5)
            until(session, lambda picture: mu(picture)[0] == 0.5 and complete(picture))
            browser.set("Motion", "bow")
            until(session, lambda picture: shown(picture) == ["bow"] * 3 and complete(picture))
    finally:
        both.stop()
