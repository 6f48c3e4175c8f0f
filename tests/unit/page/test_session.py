"""The whole app behind its wire: what a browser sends, and what becomes of it; no page is drawn."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.app.engine.worker import Lane
from rnnpb_explorer.app.page import server as server_module
from rnnpb_explorer.app.page import session as session_module
from rnnpb_explorer.app.page.screen import Screen
from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.app.page.session import LOST, STOPPED, Session
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import AppState
from rnnpb_explorer.app.state.transitions import Facts, Update
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.core.checkpoint import load_checkpoint, save_checkpoint
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS

from .wire_browser import TIMEOUT, WireBrowser

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


def until(session: Session, condition: Callable[[AppState], bool]) -> None:
    """Wait until a state that fulfils the condition has been shown."""
    assert session.wait_for(condition, TIMEOUT)


def complete(state: AppState) -> bool:
    """Whether all that this state wants has been computed."""
    return all(
        model.motion is not None
        and model.motion.request == model.motion_request
        and model.landscape is not None
        and model.landscape.request == model.landscape_request
        and model.landscape.values.complete
        for model in state.models
    )


def leave(browser: WireBrowser, session: Session) -> None:
    """Close the window and wait until the server has noticed."""
    noticed, close = threading.Event(), session.close

    def closing() -> None:
        close()
        noticed.set()

    session.close = closing  # type: ignore[method-assign]
    browser.leave()
    assert noticed.wait(TIMEOUT)


def shown(app: App, state: AppState) -> list[str]:
    """The motion that each model shows."""
    pairs = zip(app.facts, state.models, strict=True)
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
    until(session, lambda state: state.playback.phase > 0)
    assert "/boards/map" in browser.nodes
    assert "/boards/landscape" in browser.nodes
    assert any(name.startswith("/robot-0/") for name in browser.nodes)


def test_the_robot_moves_on_the_screen(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.command("Play or pause")
    until(session, lambda state: not state.playback.playing)
    browser.set("Frame", 3)
    until(session, lambda state: state.playback.phase == pytest.approx(3 / 11))
    before = {name: node.get("wxyz") for name, node in browser.nodes.items()}
    browser.set("Frame", 9)
    browser.wait_for(
        lambda: any(node.get("wxyz") != before.get(name) for name, node in browser.nodes.items())
    )
    moved = [n for n, node in browser.nodes.items() if node.get("wxyz") != before.get(n)]
    assert all(name.startswith("/robot-0/") for name in moved)


def test_a_slider_moves_mu_and_the_motion(open_browser: Open) -> None:
    browser, session = open_browser()
    assert session.state.current.motion is not None
    before = session.state.current.motion.positions
    browser.set("μ 2", 0.5)
    until(session, lambda state: state.current.latent.mu[1] == 0.5 and complete(state))
    assert not np.allclose(session.state.current.motion.positions, before)


def test_a_drag_on_the_map_moves_the_puck_to_the_pointer(open_browser: Open, app: App) -> None:
    browser, session = open_browser()
    board = app.facts[0].latent_map
    before = board.project(session.state.current.latent.mu)
    node = browser.nodes["/boards/map"]
    place = node["position"]
    through = [(place[0], place[1] + y, place[2]) for y in (0.0, 0.05, 0.1)]
    browser.drag("/boards/map", *through)
    until(session, lambda state: len(state.undo) == 1 and complete(state))
    after = board.project(session.state.current.latent.mu)
    assert not np.allclose(after[:2], before[:2])
    np.testing.assert_allclose(after[2:], before[2:], atol=1e-9)
    at = np.array(browser.nodes["/boards/map-puck"]["position"])
    eye = np.array([4.0, 0.0, 1.0])
    ray = np.array(through[-1]) - eye
    pointer = eye + (at[0] - eye[0]) / ray[0] * ray
    np.testing.assert_allclose(at[1:], pointer[1:], atol=0.01)
    browser.command("Undo")
    until(session, lambda state: not state.undo)
    np.testing.assert_allclose(board.project(session.state.current.latent.mu), before)


def test_a_motion_is_chosen_from_the_list(open_browser: Open, app: App) -> None:
    browser, session = open_browser()
    browser.set("Motion", "rest")
    until(session, lambda state: state.current.latent.motion == 2 and complete(state))
    assert session.state.current.latent.mu.tolist() == app.facts[0].mu[2].tolist()
    browser.wait_for(lambda: browser.widget("Frame")["max"] == 14)


def test_an_upload_is_recognised(open_browser: Open, target: Motion) -> None:
    browser, session = open_browser()
    upload(browser, target)
    until(session, lambda state: state.recognition.target is not None)
    assert session.state.recognition.target is not None
    np.testing.assert_array_equal(session.state.recognition.target.positions, target.positions)
    browser.set("Iterations", 10)
    until(session, lambda state: state.recognition.iterations == 10)
    browser.press("Start")
    until(session, lambda state: state.recognition.status == "finished" and complete(state))
    trace = session.state.recognition.trace
    assert trace is not None
    assert trace.iterations == 10
    browser.wait_for(lambda: bool(browser.widget("Iteration")["visible"]))


def test_a_failed_upload_leaves_the_target_and_the_session(
    open_browser: Open, target: Motion
) -> None:
    browser, session = open_browser()
    upload(browser, target)
    until(session, lambda state: state.recognition.target is not None)
    kept = session.state.recognition.target
    browser.upload("Upload a motion", "bad.csv", b"HeadYaw,HeadPitch\n1,2\n")
    browser.wait_for(lambda: any("bad.csv" in notice for notice in browser.notices))
    assert session.state.recognition.target is kept
    browser.set("μ 1", 0.25)
    until(session, lambda state: state.current.latent.mu[0] == 0.25)


def test_an_export_arrives_and_can_be_uploaded_again(open_browser: Open) -> None:
    browser, session = open_browser()
    positions = session.state.current.motion.positions
    for label, suffix in (("CSV", ".csv"), ("JSON", ".json"), ("NAOqi script", ".py")):
        browser.set("Format", label)
        browser.press("Export the motion")
        name = f"wave_tiny{suffix}"
        browser.wait_for(lambda name=name: name in browser.files)
        browser.upload("Upload a motion", name, browser.files[name])
        until(session, lambda state: state.recognition.target is not None and complete(state))
        found = session.state.recognition.target.positions
        assert found.shape == positions.shape
        within = session.state.current.checked.report.light == "green"
        assert np.allclose(found, positions, atol=1e-6) == within
        browser.press("Forget the target")
        until(session, lambda state: state.recognition.target is None and complete(state))


def test_the_limited_robot_comes_back_after_a_reload(open_browser: Open) -> None:
    storage: dict[str, str] = {}
    browser, session = open_browser(storage)
    assert not any(name.startswith("/robot-1") for name in browser.nodes)
    browser.set("Side by side", True)
    until(session, lambda state: state.side_by_side and state.current.checked.limited is not None)
    browser.wait_for(lambda: "/robot-1" in browser.nodes)
    browser.leave()
    again, session = open_browser(storage)
    again.wait_for(lambda: "/robot-1" in again.nodes)
    assert session.state.side_by_side
    again.wait_for(lambda: again.widget("Side by side")["value"])


def test_a_code_of_the_screen_restores_it(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.set("μ 3", 0.75)
    until(session, lambda state: state.current.latent.mu[2] == 0.75)
    browser.press("Show the code of this screen")
    browser.wait_for(lambda: str(browser.widget("Code")["value"]).startswith("rnnpb1-"))
    code = browser.widget("Code")["value"]
    other, other_session = open_browser()
    other.set("Code", code)
    other.press("Restore from the code")
    until(other_session, lambda state: state.current.latent.mu[2] == 0.75)


def test_nonsense_for_a_code_is_a_notice(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.set("Code", "nonsense")
    browser.press("Restore from the code")
    browser.wait_for(lambda: any("not a state code" in notice for notice in browser.notices))
    assert session.state.undo == ()


# --- several browsers ---
def test_each_browser_has_a_session_of_its_own(open_browser: Open) -> None:
    (one, first), (_, second) = open_browser(), open_browser()
    before = second.state.current.latent
    one.set("μ 1", 0.125)
    one.set("Motion", "bow")
    until(first, lambda state: state.current.latent.motion == 1 and complete(state))
    assert second.state.current.latent is before
    assert first is not second


def test_a_reload_brings_the_same_screen_back(open_browser: Open) -> None:
    browser, session = open_browser()
    browser.set("μ 1", 0.125)
    until(session, lambda state: state.current.latent.mu[0] == 0.125)
    browser.leave()
    again, session = open_browser(browser.storage)
    assert session.state.current.latent.mu[0] == 0.125
    assert again.widget("μ 1")["value"] == pytest.approx(0.125, abs=0.01)
    _, stranger = open_browser()
    assert stranger.state.current.latent.mu[0] != 0.125


def test_a_reload_in_the_middle_of_a_run_leaves_no_run_behind(
    open_browser: Open, target: Motion
) -> None:
    browser, session = open_browser()
    upload(browser, target)
    browser.set("Iterations", 300)
    until(session, lambda state: state.recognition.iterations == 300)
    browser.press("Start")
    until(session, lambda state: state.recognition.status == "running")
    browser.leave()
    _, session = open_browser(browser.storage)
    assert session.state.recognition.status != "running"
    assert session.state.recognition.target is not None


def test_each_of_two_pages_of_a_browser_gets_its_own_screen_back(open_browser: Open) -> None:
    storage: dict[str, str] = {}
    pages = [open_browser(storage) for _ in range(2)]
    for value, (page, session) in zip((0.125, 0.25), pages, strict=True):
        page.set("μ 1", value)
        until(session, lambda state, value=value: state.current.latent.mu[0] == value)
    for value, (page, session) in zip((0.125, 0.25), pages, strict=True):
        leave(page, session)
        page, again = open_browser(storage)
        assert again.state.current.latent.mu[0] == value
    # A third one finds none that was closed.
    page.set("μ 1", 0.375)
    until(again, lambda state: state.current.latent.mu[0] == 0.375)
    _, third = open_browser(storage)
    assert third.state.current.latent.mu[0] == 0.375


def test_a_second_page_begins_with_what_the_first_one_shows(open_browser: Open) -> None:
    storage: dict[str, str] = {}
    page, session = open_browser(storage)
    page.set("μ 1", 0.125)
    until(session, lambda state: state.current.latent.mu[0] == 0.125)
    _, second = open_browser(storage)
    assert second.state.current.latent.mu[0] == 0.125


def test_a_page_that_is_reloaded_again_before_it_shows_anything_loses_nothing(
    app: App, open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, session = open_browser()
    page.set("μ 1", 0.125)
    until(session, lambda state: state.current.latent.mu[0] == 0.125)
    leave(page, session)
    session.join(TIMEOUT)  # so that it shows nothing any more
    building, go_on = threading.Event(), threading.Event()

    def slow(screen: Screen, state: AppState) -> None:
        if state.current.latent.mu[0] == 0.125:
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
    assert session.state.current.latent.mu[0] == 0.125


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
Break = Callable[[AppState, do.Intent], bool]


@pytest.fixture
def break_when(monkeypatch: pytest.MonkeyPatch) -> Callable[[Break], None]:
    """Have the update of some states and intents fail."""

    def install(breaks: Break) -> None:
        def failing(facts: Facts, state: AppState, intent: do.Intent) -> Update:
            if breaks(state, intent):
                raise ZeroDivisionError("made for a test")
            return update(facts, state, intent)

        monkeypatch.setattr(session_module, "update", failing)

    return install


def has_stopped(browser: WireBrowser) -> None:
    browser.wait_for(lambda: STOPPED in browser.notices)


def stop_and_reload(
    browser: WireBrowser, session: Session, open_browser: Open
) -> tuple[WireBrowser, Session]:
    """Move mu 1, which goes well, then mu 2, which meets the fault; the page is as before it."""
    browser.set("μ 1", 0.125)
    until(session, lambda state: state.current.latent.mu[0] == 0.125)
    browser.set("μ 2", 0.5)
    has_stopped(browser)
    leave(browser, session)
    again, session = open_browser(browser.storage)
    assert session.state.current.latent.mu[0] == 0.125
    return again, session


def test_a_page_that_meets_a_fault_says_so_and_comes_back_as_it_was(
    open_browser: Open, break_when: Callable[[Break], None]
) -> None:
    break_when(lambda state, intent: intent == do.SetMu(1, 0.5))
    browser, session = open_browser()
    again, session = stop_and_reload(browser, session, open_browser)
    again.set("μ 2", 0.25)
    until(session, lambda state: state.current.latent.mu[1] == 0.25)
    assert again.notices == []


def test_a_state_that_cannot_be_shown_is_not_kept(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    show = Screen.show

    def fails(screen: Screen, state: AppState) -> None:
        if state.current.latent.mu[1] == 0.5:
            raise ZeroDivisionError("made for a test")
        show(screen, state)

    monkeypatch.setattr(Screen, "show", fails)
    browser, session = open_browser()
    again, session = stop_and_reload(browser, session, open_browser)
    assert session.state.current.latent.mu[1] != 0.5
    assert again.notices == []


def test_a_kept_screen_that_cannot_be_built_gives_way_to_the_opening_one(
    open_browser: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    reset_camera = Screen._reset_camera
    browser, session = open_browser()
    opening = session.state.current.latent.mu[0]
    browser.set("μ 1", 0.125)
    until(session, lambda state: state.current.latent.mu[0] == 0.125)
    leave(browser, session)
    built: list[Screen] = []

    def fails(screen: Screen) -> None:
        """At the end of building the first one."""
        built.append(screen)
        if len(built) == 1:
            raise ZeroDivisionError("made for a test")
        reset_camera(screen)

    monkeypatch.setattr(Screen, "_reset_camera", fails)
    again, session = open_browser(browser.storage)
    assert session.state.current.latent.mu[0] == opening
    again.wait_for(lambda: again.notices == [LOST])
    labels = [widget.get("label") for widget in again.widgets.values()]
    assert labels.count("Motion") == 1
    again.set("μ 1", 0.25)
    until(session, lambda state: state.current.latent.mu[0] == 0.25)


def test_a_screen_that_leads_to_a_fault_twice_is_given_up(
    app: App, open_browser: Open, break_when: Callable[[Break], None]
) -> None:
    """It can be shown, but the motion that it asks for ends the page."""
    break_when(
        lambda state, intent: (
            isinstance(intent, do.MotionReady) and state.current.latent.mu[0] == 0.125
        )
    )
    browser, session = open_browser()
    opening = session.state.current.latent.mu[0]
    browser.set("μ 1", 0.125)
    has_stopped(browser)
    leave(browser, session)
    again = WireBrowser(app.url, browser.storage)
    has_stopped(again)
    leave(again, app.sessions[max(app.sessions)])
    last, session = open_browser(browser.storage)
    assert session.state.current.latent.mu[0] == opening
    last.wait_for(lambda: last.notices == [LOST])


# --- at rest ---
@pytest.fixture
def resting(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Set whenever a session waits for nothing but an intent."""
    rests, drain = threading.Event(), Session._drain

    def noting(session: Session, wait: float | None) -> list[do.Intent]:
        if wait is None:
            rests.set()
        return drain(session, wait)

    monkeypatch.setattr(Session, "_drain", noting)
    return rests


def paused(browser: WireBrowser, session: Session, resting: threading.Event) -> None:
    browser.command("Play or pause")
    until(session, lambda state: not state.playback.playing)
    assert resting.wait(TIMEOUT)
    resting.clear()


def test_a_session_rests_where_nothing_changes_and_goes_on_from_there(
    open_browser: Open, resting: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser, session = open_browser()
    assert not resting.is_set()  # the motion plays
    paused(browser, session, resting)
    ticks: list[float] = []

    def noting(facts: Facts, state: AppState, intent: do.Intent) -> Update:
        if isinstance(intent, do.Tick):
            ticks.append(intent.seconds)
        return update(facts, state, intent)

    monkeypatch.setattr(session_module, "update", noting)
    browser.command("Play or pause")
    until(session, lambda state: state.playback.playing)
    assert ticks[0] == 0.0
    phase = session.state.playback.phase
    until(session, lambda state: state.playback.phase != phase)


def test_a_session_at_rest_resets_the_view(
    open_browser: Open, resting: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser, session = open_browser()
    paused(browser, session, resting)
    went_home = threading.Event()
    monkeypatch.setattr(Screen, "_reset_camera", lambda screen: went_home.set())
    browser.command("Reset the view")
    assert went_home.wait(TIMEOUT)


def test_a_session_at_rest_shows_its_code(open_browser: Open, resting: threading.Event) -> None:
    browser, session = open_browser()
    paused(browser, session, resting)
    browser.press("Show the code of this screen")
    browser.wait_for(lambda: str(browser.widget("Code")["value"]).startswith("rnnpb1-"))


def test_what_is_written_late_is_written_before_a_rest(
    open_browser: Open, resting: threading.Event
) -> None:
    """A widget that a person holds gets the state's value only when it is let go."""
    browser, session = open_browser()
    paused(browser, session, resting)
    browser.set("Frame", 99)
    browser.wait_for(lambda: browser.widget("Frame")["value"] == 11)


# --- leaving ---
def session_threads() -> set[threading.Thread]:
    return {thread for thread in threading.enumerate() if thread.name.startswith("session-")}


def test_a_browser_that_leaves_takes_its_threads_with_it(app: App, open_browser: Open) -> None:
    before = session_threads()
    browser, session = open_browser()
    mine = session_threads() - before
    assert len(mine) == 5  # the loop, and a lane for each kind of work
    browser.leave()
    for thread in mine:
        thread.join(TIMEOUT)
        assert not thread.is_alive()
    assert session not in app.sessions.values()


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
    before = session_threads()
    running = start(ServerOptions(checkpoints=(str(checkpoint),), port=0))
    browsers = [WireBrowser(running.url) for _ in range(2)]
    for browser in browsers:
        browser.widget("Motion")
    mine = session_threads() - before
    lanes = [lane for session in running.sessions.values() for lane in session._lanes]
    told: list[bool] = []
    join = Lane.join

    def noting(lane: Lane[object, object], timeout: float) -> None:
        told.append(all(each._closed for each in lanes))
        join(lane, timeout)

    monkeypatch.setattr(Lane, "join", noting)
    running.stop()
    assert told == [True] * len(lanes)  # all were told to end before any was waited for
    assert not any(thread.is_alive() for thread in mine)
    port = int(running.url.rpartition(":")[2])
    again = start(ServerOptions(checkpoints=(str(checkpoint),), port=port))
    assert again.url == running.url
    again.stop()


# --- models side by side ---
def test_two_models_of_different_sizes_on_one_screen(
    checkpoint: Path, tmp_path: Path, open_browser: Open
) -> None:
    line = save_model(tmp_path / "line.pt", pb_dim=1, names=("bow", "wave"))
    wide = save_model(tmp_path / "wide.pt", pb_dim=12)
    both = start(ServerOptions(checkpoints=(str(line), str(wide), str(checkpoint)), port=0))
    try:
        browser, session = open_browser(of=both)
        assert shown(both, session.state) == ["bow", "bow", "bow"]
        assert {"/robot-0", "/robot-1", "/robot-2"} <= set(browser.nodes)
        for name in ("wide", "tiny", "line"):
            before = browser.widget("μ 1")
            browser.set("Model", name)
            until(session, lambda state, name=name: both.facts[state.active].name == name)
            # Another model has sliders of its own.
            browser.wait_for(lambda before=before: browser.widget("μ 1") is not before)
            browser.set("Motion", "wave")
            until(session, lambda state: shown(both, state) == ["wave"] * 3 and complete(state))
            steps = len(session.state.undo)
            browser.drag("/boards/map", (0.0, -1.0, 1.1), (0.0, -0.9, 1.1))
            browser.drag("/boards/landscape", (0.0, -1.0, 0.4), (0.0, -0.9, 0.4))
            # One hand: it takes a slider when it has let go of the board.
            until(session, lambda state, steps=steps: len(state.undo) == steps + 2)
            browser.set("μ 1", 0.5)
            until(session, lambda state: state.current.latent.mu[0] == 0.5 and complete(state))
            browser.set("Motion", "bow")
            until(session, lambda state: shown(both, state) == ["bow"] * 3 and complete(state))
    finally:
        both.stop()
