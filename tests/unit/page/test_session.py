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
from rnnpb_explorer.app.page.session import NOT_KEPT, STOPPED, Event, Session
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import MAX_ITERATIONS, Document
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.statecode import PREFIX, decode, encode
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.core.checkpoint import load_checkpoint, save_checkpoint
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS

from ..wire_browser import TIMEOUT, WireBrowser
from .pictures import complete, until

PUBLISHED = "as published: sampling and Adam"
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

    def open_one(tab: dict[str, str] | None = None, of: App = app) -> tuple[WireBrowser, Session]:
        before = set(of.sessions)
        browser = WireBrowser(of.url, tab)
        opened.append(browser)
        browser.widget("Motion")  # the session builds its screen
        session = of.sessions[max(set(of.sessions) - before)]
        until(session, complete)
        browser.wait_for_all()
        return browser, session

    yield open_one
    for browser in opened:
        browser.leave()


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


def kept(browser: WireBrowser, session: Session) -> dict[str, str]:
    """What the tab keeps, once it is what is on the screen."""
    code = encode(session.document)
    browser.wait_for(lambda: browser.tab.get("document") == code)
    return browser.tab


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
    browser, _ = open_browser()
    assert browser.widget("Motion")["value"] == "wave"
    assert browser.widget("μ 1")["value"] == pytest.approx(app.facts[0].mu[0, 0], abs=0.01)
    browser.wait_for(lambda: browser.shown["PlaybackShown"]["playing"] is True)
    assert browser.shown["MapShown"]["names"] == list(NAMES)
    assert set(browser.shown["RobotsShown"]["robots"][0]["nodes"]) <= set(browser.nodes)
    assert browser.shown["MotionShown 0"]["angles"].shape == (12, 17)


def test_a_page_that_plays_gets_no_message(open_browser: Open) -> None:
    browser, session = open_browser()
    kept(browser, session)  # the last of what is written late
    before = browser.messages
    browser.ask("SetPlaying", playing=False, frame=3.0)
    until(session, lambda picture: picture.document.playback.phase == pytest.approx(3 / 11))
    kept(browser, session)
    assert browser.messages == before + 1  # the document, for the tab


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
    browser.drag("map", (0.1, 0.2), (0.3, 0.2), (0.25, -0.4))
    until(session, lambda picture: steps(session) == 1 and complete(picture))
    browser.wait_for(lambda: browser.shown["PuckShown"]["heard"] == 3)
    np.testing.assert_allclose(browser.shown["PuckShown"]["on_map"], [0.25, -0.4], atol=1e-6)
    after = board.project(session.document.current.latent.mu)
    np.testing.assert_allclose(after[:2], [0.25, -0.4])
    np.testing.assert_allclose(after[2:], before[2:], atol=1e-9)
    browser.ask("Undo")
    until(session, lambda _: not steps(session))
    np.testing.assert_allclose(board.project(session.document.current.latent.mu), before)


def test_nonsense_from_a_page_costs_that_message_alone(open_browser: Open) -> None:
    browser, session = open_browser()
    before = session.document
    for payload in (
        "",
        "{}",
        '{"type":"SelectMotion"}',
        '{"type":"Seek","frame":1e400}',
        "[" * 999,
    ):
        browser.say({"type": "RnnpbAsked", "payload": payload})
    browser.ask("SelectMotion", model=0, index=999_999)
    browser.ask("MoveOnLandscape", model=0, axes=["PC1"], to=[1.0], gesture=1, number=1, done=True)
    browser.ask("SelectMotion", model=0, index=1)
    until(session, lambda picture: picture.choice.latent.motion == 1)
    assert steps(session) == 1
    browser.ask("Undo")
    until(session, lambda picture: picture.document == before)


def test_a_motion_is_chosen_from_the_list(open_browser: Open, app: App) -> None:
    browser, session = open_browser()
    browser.set("Motion", "rest")
    until(session, lambda picture: picture.choice.latent.motion == 2 and complete(picture))
    assert session.document.current.latent.mu == tuple(app.facts[0].mu[2].tolist())
    browser.wait_for(lambda: len(browser.shown["MotionShown 0"]["angles"]) == 15)


def test_an_upload_is_recognised(open_browser: Open, target: Motion) -> None:
    browser, session = open_browser()
    upload(browser, target)
    until(session, lambda picture: picture.document.target is not None)
    assert session.document.target is not None
    np.testing.assert_array_equal(session.document.target.array, target.positions)
    browser.set("Method", PUBLISHED)
    browser.set("Iterations", 10)
    until(session, lambda picture: picture.document.recognition.iterations == 10)
    until(session, lambda picture: picture.document.target is not None)
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
        within = not got.checked.report.violations
        assert np.allclose(found, positions, atol=1e-6) == within
        browser.press("Forget the target")
        until(session, lambda picture: picture.document.target is None and complete(picture))


def test_the_limited_robot_comes_back_after_a_reload(open_browser: Open) -> None:
    browser, session = open_browser()
    assert len(browser.shown["RobotsShown"]["robots"]) == 1
    browser.set("Side by side", True)
    checked = until(
        session, lambda picture: picture.document.side_by_side and complete(picture)
    ).checked
    assert checked is not None
    assert checked.limited is not None
    browser.wait_for(lambda: "MotionShown 1" in browser.shown)
    tab = kept(browser, session)
    browser.leave()
    again, session = open_browser(tab)
    again.wait_for(lambda: len(again.shown["RobotsShown"]["robots"]) == 2)
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
    browser.set("Method", PUBLISHED)
    browser.set("Iterations", 10)
    until(session, lambda picture: picture.document.recognition.iterations == 10)
    until(session, lambda picture: picture.document.target is not None)
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
    before = now(session)
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
    browser.ask("Seek", frame=3.0)  # comes after them
    end = until(session, lambda picture: not picture.document.playback.playing)
    assert all(picture.landscape_complete for picture in shown)
    assert end.motion() is moved.motion()
    assert end.landscape == moved.landscape


def test_what_was_answered_while_it_was_not_wanted_comes_all_the_same(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody goes away and back while the answer waits to be heard of."""
    browser, session = open_browser()
    here = mu(now(session))[2]
    held: list[Event] = []
    answered, next_events = threading.Event(), Session._next_events

    def holding(of: Session) -> list[Event]:
        """Only with the answers do the two moves before and after them come, all at once."""
        events = next_events(of)
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


def test_a_reload_brings_the_same_screen_back(open_browser: Open, target: Motion) -> None:
    browser, session = open_browser()
    upload(browser, target)
    browser.set("μ 1", 0.125)
    browser.set("Warm start", "baseline: μ = 0")
    until(session, lambda picture: picture.document.recognition.init == "baseline")
    until(session, lambda picture: picture.document.target is not None)
    until(session, lambda picture: mu(picture)[0] == 0.125 and complete(picture))
    tab, before = kept(browser, session), session.document
    browser.leave()
    again, session = open_browser(tab)
    until(session, lambda picture: picture.document == before)
    again.wait_for(lambda: again.widget("μ 1")["value"] == pytest.approx(0.125, abs=0.01))
    _, stranger = open_browser()
    assert stranger.document.current.latent.mu[0] != 0.125


def test_another_server_gets_the_document_back(checkpoint: Path, open_browser: Open) -> None:
    browser, session = open_browser()
    browser.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    tab = kept(browser, session)
    running = start(ServerOptions(checkpoints=(str(checkpoint),), port=0))
    try:
        _, session = open_browser(tab, of=running)
        until(session, lambda picture: mu(picture)[0] == 0.125)
    finally:
        running.stop()


def test_a_page_that_played_on_by_itself_is_not_set_back(open_browser: Open) -> None:
    browser, session = open_browser()
    played = {"playing": True, "frame": 5.5, "speed": 2.0, "loop": False}
    browser.hello(played)
    until(session, lambda picture: picture.document.playback.speed == 2.0)
    playback = session.document.playback
    assert (playback.phase, playback.loop, playback.playing) == (0.5, False, True)
    kept(browser, session)
    assert browser.shown["PlaybackShown"]["speed"] == 1.0  # nothing newer was sent


def test_what_a_tab_keeps_is_checked_like_any_input(open_browser: Open) -> None:
    browser, session = open_browser({"document": "rnnpb2-nonsense"})
    browser.wait_for(lambda: any("damaged" in notice for notice in browser.notices))
    assert complete(now(session))
    assert browser.tab["document"] == "rnnpb2-nonsense"  # it may fit another server
    browser.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    kept(browser, session)


def test_an_upload_too_long_for_the_tab_is_not_kept_and_says_so(
    open_browser: Open, target: Motion, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session_module.asked, "MAX_DOCUMENT", 1500)
    browser, session = open_browser()
    upload(browser, target)
    until(session, lambda picture: picture.document.target is not None)
    browser.wait_for(lambda: NOT_KEPT in browser.notices)
    browser.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    without = encode(replace(session.document, target=None))
    browser.wait_for(lambda: browser.tab["document"] == without)
    assert browser.notices.count(NOT_KEPT) == 1


def test_a_reload_in_the_middle_of_a_run_goes_on_with_it(
    open_browser: Open, target: Motion, app: App
) -> None:
    browser, session = open_browser()
    upload(browser, target)
    browser.set("Method", PUBLISHED)
    browser.set("Iterations", 300)
    browser.set("Trials", 10)
    until(session, lambda picture: picture.document.recognition.trials == 10)
    until(session, lambda picture: picture.document.target is not None)
    browser.press("Start")
    until(
        session, lambda picture: picture.run_status == "running" and picture.document.run.done > 0
    )
    browser.wait_for(lambda: decode(app.facts, browser.tab["document"]).run is not None)
    leave(browser, session)
    _, session = open_browser(browser.tab)
    end = until(session, lambda picture: picture.run_status == "finished" and complete(picture))
    assert end.trace is not None
    assert end.trace.loss.shape == (300, 10)


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
        second.wait_for(lambda: "location.reload()" in second.script)
        assert list(running.sessions.values()) == [session]
        leave(first, session)
        second.leave()
        WireBrowser(running.url).widget("Motion")
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
    kept(browser, session)
    browser.set("μ 2", 0.5)
    has_stopped(browser)
    browser.leave()
    again, session = open_browser(browser.tab)
    until(session, lambda picture: mu(picture)[0] == 0.125)
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


def test_a_document_that_leads_to_a_fault_again_is_given_up(
    app: App, open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It can be shown, but the motion that it asks for ends the page."""
    deliver = Session._deliver

    def failing(session: Session, event: Delivered, screen: Screen) -> None:
        if event.slot[0] == "motion" and session.document.current.latent.mu[0] == 0.125:
            raise ZeroDivisionError("made for a test")
        deliver(session, event, screen)

    browser, session = open_browser()
    opening = session.document.current.latent.mu[0]
    browser.set("μ 1", 0.125)
    until(session, lambda picture: mu(picture)[0] == 0.125)
    tab = kept(browser, session)
    browser.leave()
    monkeypatch.setattr(Session, "_deliver", failing)
    again = WireBrowser(app.url, tab)
    has_stopped(again)
    again.wait_for(lambda: tab["document"] == "")
    again.leave()
    _, session = open_browser(tab)
    assert session.document.current.latent.mu[0] == opening


# --- at rest ---
@pytest.fixture
def resting(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Set whenever a session waits for nothing but a person."""
    rests, drain = threading.Event(), Session._next_events

    def noting(session: Session) -> list[Event]:
        if session._settled:
            rests.set()
        return drain(session)

    monkeypatch.setattr(Session, "_next_events", noting)
    return rests


def rested(session: Session, resting: threading.Event) -> None:
    until(session, complete)
    resting.clear()
    session.send(do.SetPlaying(False))
    assert resting.wait(TIMEOUT)


def test_a_session_at_rest_resets_the_view(open_browser: Open, resting: threading.Event) -> None:
    browser, session = open_browser()
    rested(session, resting)
    front = browser.camera
    browser.look((0.0, 3.0, 2.0), (1280, 720))
    browser.looked(turned=True)
    until(session, lambda picture: picture.document.seen.camera is not None)
    browser.command("Reset the view")
    until(session, lambda picture: picture.document.seen.camera is None)
    browser.wait_for(lambda: browser.camera == front)


def test_where_a_person_looks_outlives_a_reload_and_undo(
    open_browser: Open, resting: threading.Event
) -> None:
    browser, session = open_browser()
    rested(session, resting)
    zoom = {"of": "a PC1 PC2", "left": 0.0, "right": 1.0, "bottom": -1.0, "top": 0.5}
    browser.look((0.5, 3.0, 2.0), (1280, 720))
    browser.looked(map=zoom, tab="View", turned=True)
    until(session, lambda picture: picture.document.seen.tab == "View")
    session.send(do.SetMu(0, 0.25))
    session.send(do.Undo())
    until(session, lambda picture: mu(picture)[0] != 0.25 and picture.document.seen.tab == "View")
    assert "LookShown" not in browser.shown  # the page knows
    tab = kept(browser, session)
    browser.leave()
    again, session = open_browser(tab)
    again.wait_for(lambda: "LookShown" in again.shown)
    nothing = dict.fromkeys(("landscape", "map_2", "landscape_2"))
    assert again.shown["LookShown"] == {"map": zoom, **nothing, "tab": "View"}
    again.wait_for(lambda: again.camera == (0.5, 3.0, 2.0))


@pytest.mark.parametrize("zoom", [(1.0, 1.0, 0.0, 1.0), (2.0, 1.0, 0.0, 1.0), (0.0, 1e9, 0.0, 1.0)])
def test_a_zoom_that_shows_nothing_is_refused(
    open_browser: Open, zoom: tuple[float, float, float, float]
) -> None:
    browser, session = open_browser()
    names = ("left", "right", "bottom", "top")
    browser.looked(map={"of": "", **dict(zip(names, zoom, strict=True))})
    browser.looked(tab="Help")
    until(session, lambda picture: picture.document.seen.tab == "Help")
    assert session.document.seen.map is None


def test_a_session_at_rest_shows_its_code(open_browser: Open, resting: threading.Event) -> None:
    browser, session = open_browser()
    rested(session, resting)
    browser.press("Show the code of this screen")
    browser.wait_for(lambda: str(browser.widget("Code")["value"]).startswith("rnnpb2-"))


def test_a_page_at_rest_shows_other_sliders_at_once(
    checkpoint: Path, tmp_path: Path, open_browser: Open, resting: threading.Event
) -> None:
    wide = save_model(tmp_path / "wide.pt", pb_dim=12)
    running = start(ServerOptions(checkpoints=(str(wide),), port=0))
    try:
        browser, session = open_browser(of=running)
        rested(session, resting)
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
    rested(session, resting)
    browser.set("Iterations", 9999)
    browser.wait_for(lambda: browser.widget("Iterations")["value"] == MAX_ITERATIONS)


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
    for browser, session in pages:
        leave(browser, session)
        session.join(TIMEOUT)
        assert session not in app.sessions.values()
    for thread in new:
        if thread.name.startswith(("page-", "upload")):
            assert not thread.is_alive()


def test_a_browser_that_leaves_at_the_door_leaves_nothing(app: App, open_browser: Open) -> None:
    sessions = set(app.sessions)
    hasty = WireBrowser(app.url, silent=True)
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
        assert [one["copy_of"] for one in browser.shown["RobotsShown"]["robots"]] == [None, 0, 0]
        for name in ("wide", "tiny", "line"):
            before = browser.widget("μ 1")
            browser.set("Model", name)
            until(session, lambda picture, name=name: picture.model.name == name)
            # Another model has sliders of its own.
            browser.wait_for(lambda before=before: browser.widget("μ 1") is not before)
            browser.set("Motion", "wave")
            until(session, lambda picture: shown(picture) == ["wave"] * 3 and complete(picture))
            taken = steps(session)
            index = [one.name for one in both.facts].index(name)
            browser.wait_for(
                lambda index=index: (
                    [browser.shown[kind]["model"] for kind in ("MapShown", "LandscapeShown")]
                    == [index, index]
                )
            )
            at = browser.shown["PuckShown"]["on_map"] + 0.05
            browser.drag("map", at.tolist()[: len(browser.shown["MapShown"]["axes"])])
            near = [float(browser.shown["LandscapeShown"][axis][:4][-1]) for axis in "xy"]
            browser.drag("landscape", near[: len(browser.shown["LandscapeShown"]["axis_labels"])])
            # One hand: it takes a slider when it has let go of the board.
            until(session, lambda _, taken=taken: steps(session) == taken + 2)
            browser.set("μ 1", 0.5)
            until(session, lambda picture: mu(picture)[0] == 0.5 and complete(picture))
            browser.set("Motion", "bow")
            until(session, lambda picture: shown(picture) == ["bow"] * 3 and complete(picture))
    finally:
        both.stop()
