"""A page that others follow, on a real server: what they show, and who may move what."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rnnpb_explorer.app.page.presenting import Audience, Presentations, Presented, Word, code_of
from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.app.page.session import Session

from ..wire_browser import TIMEOUT, WireBrowser
from .test_session import save_model

Open = Callable[..., tuple[WireBrowser, Session]]


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[App]:
    running = start(ServerOptions(checkpoints=(model(tmp_path_factory.mktemp("models")),), port=0))
    yield running
    running.stop()


def model(folder: Path) -> str:
    return str(save_model(folder / "tiny.pt"))


@pytest.fixture
def open_page(app: App) -> Iterator[Open]:
    opened: list[WireBrowser] = []

    def open_one(
        follow: str | None = None, tab: dict[str, str] | None = None, of: App = app
    ) -> tuple[WireBrowser, Session]:
        before = set(of.sessions)
        browser = WireBrowser(of.url, tab, follow=follow)
        opened.append(browser)
        browser.wait_for(lambda: "PresenceShown" in browser.shown)
        return browser, of.sessions[max(set(of.sessions) - before)]

    yield open_one
    for browser in opened:
        browser.leave()


def presence(browser: WireBrowser, **wanted: object) -> None:
    """Wait until the page is told so."""
    browser.wait_for(lambda: wanted.items() <= browser.shown.get("PresenceShown", {}).items())


def presenting(open_page: Open) -> tuple[WireBrowser, Session, str]:
    browser, session = open_page()
    browser.press("Present this page")
    presence(browser, role="presents")
    return browser, session, browser.shown["PresenceShown"]["code"]


def selected(browser: WireBrowser) -> int:
    return int(browser.shown["MapShown"]["selected"])


def same(one: Session, other: Session) -> bool:
    """Whether both show the same; each looks from where it likes."""
    return other.wait_for(lambda it: it.document.models == one.document.models, TIMEOUT)


def test_what_is_presented_is_on_all_pages_that_follow(open_page: Open) -> None:
    teacher, shows, code = presenting(open_page)
    pages = [open_page(code) for _ in range(3)]
    presence(teacher, followers=3)
    teacher.ask("SelectMotion", model=0, index=2)
    teacher.wait_for(lambda: selected(teacher) == 2)
    teacher.drag("map", (0.3, 0.2), (0.5, -0.1))
    for browser, session in pages:
        browser.wait_for(lambda browser=browser: selected(browser) == 2)
        assert same(shows, session)
        presence(browser, role="follows", there=True, free=False, secret=None)


def test_a_page_that_comes_late_shows_what_is_presented(open_page: Open) -> None:
    teacher, shows, code = presenting(open_page)
    teacher.ask("SelectMotion", model=0, index=1)
    teacher.wait_for(lambda: selected(teacher) == 1)
    _, session = open_page(code)
    assert same(shows, session)


def test_a_hand_lets_go_and_comes_back(open_page: Open) -> None:
    teacher, shows, code = presenting(open_page)
    browser, session = open_page(code)
    presence(browser, there=True)
    browser.ask("SelectMotion", model=0, index=2)
    presence(browser, free=True)
    browser.wait_for(lambda: selected(browser) == 2)
    assert shows.document.models[0].latent.motion == 0  # nobody but the teacher moves it
    teacher.ask("SelectMotion", model=0, index=1)
    teacher.wait_for(lambda: selected(teacher) == 1)
    assert selected(browser) == 2
    browser.ask("Follow", on=True)
    browser.wait_for(lambda: selected(browser) == 1)
    presence(browser, free=False)
    assert same(shows, session)
    browser.ask("Follow", on=False)
    presence(browser, free=True)


def test_to_look_around_and_to_pause_is_not_to_let_go(open_page: Open) -> None:
    teacher, _, code = presenting(open_page)
    browser, session = open_page(code)
    presence(browser, there=True)
    zoom = {"of": "tiny 0,1", "left": 0.0, "right": 1.0, "bottom": 0.0, "top": 1.0}
    browser.looked(map=zoom)
    browser.ask("SetPlaying", playing=False, frame=3)
    assert session.wait_for(lambda it: it.document.seen.map is not None, TIMEOUT)
    teacher.ask("SelectMotion", model=0, index=2)
    browser.wait_for(lambda: selected(browser) == 2)
    presence(browser, free=False)
    assert session.document.seen.map is not None  # still where this person looks
    teacher.looked(landscape={**zoom, "of": "μ1,μ2"})
    assert session.wait_for(
        lambda it: it.document.seen.landscape is not None and it.document.seen.map is None, TIMEOUT
    )


def test_what_one_did_before_is_there_after_letting_go(open_page: Open) -> None:
    teacher, _, code = presenting(open_page)
    browser, _ = open_page(code)
    presence(browser, there=True)
    browser.ask("SelectMotion", model=0, index=2)
    browser.wait_for(lambda: selected(browser) == 2)
    browser.ask("Follow", on=True)
    browser.wait_for(lambda: selected(browser) == 0)
    browser.ask("Undo")
    presence(browser, free=True)
    assert teacher.shown["MapShown"]["selected"] == 0


def test_both_come_back_after_a_reload(open_page: Open) -> None:
    teacher, _, code = presenting(open_page)
    browser, _ = open_page(code)
    browser.ask("SelectMotion", model=0, index=2)
    presence(browser, free=True)
    teacher.leave()
    presence(browser, there=False)
    again, shows = open_page(tab=teacher.tab)
    presence(again, role="presents", code=code)
    presence(browser, there=True)
    browser.leave()
    late, session = open_page(code, tab=browser.tab)
    presence(late, free=True, there=True)
    late.ask("Follow", on=True)
    assert same(shows, session)


def test_another_server_brings_all_together_again(open_page: Open, tmp_path: Path) -> None:
    teacher, _, code = presenting(open_page)
    browser, _ = open_page(code)
    presence(browser, there=True)
    other = start(ServerOptions(checkpoints=(model(tmp_path),), port=0))
    try:
        follows, session = open_page(code, tab=browser.tab, of=other)
        presence(follows, role="follows", there=False)
        shows, presents = open_page(tab=teacher.tab, of=other)
        presence(follows, there=True)
        shows.ask("SelectMotion", model=0, index=2)
        follows.wait_for(lambda: selected(follows) == 2)
        assert same(presents, session)
    finally:
        other.stop()


def test_the_link_is_not_enough_to_present(open_page: Open) -> None:
    teacher, _, code = presenting(open_page)
    browser, _ = open_page(tab={"secret": code.ljust(32, "x")})
    assert browser.shown["PresenceShown"]["code"] != code
    presence(teacher, role="presents")
    teacher.ask("Present", on=False)
    presence(teacher, role="", secret=None)


def test_who_stops_leaves_the_others_where_they_are(open_page: Open) -> None:
    teacher, _, code = presenting(open_page)
    browser, session = open_page(code)
    teacher.ask("SelectMotion", model=0, index=2)
    browser.wait_for(lambda: selected(browser) == 2)
    teacher.ask("Present", on=False)
    presence(browser, there=False)
    assert session.document.models[0].latent.motion == 2


# --- the registry ---
def test_nothing_is_left_of_those_who_went() -> None:
    presentations, told = Presentations(), []
    words: dict[str, list[Word]] = {"teacher": told, "pupil": []}
    code = code_of("k" * 32)
    teacher, pupil = words["teacher"].append, words["pupil"].append
    presentations.join(code, pupil)
    presentations.open(code, teacher)
    assert words["teacher"] == [Audience(1)]
    presentations.leave(code, pupil)
    presentations.leave(code, pupil)
    assert words["teacher"] == [Audience(1), Audience(0)]
    presentations.close(code, teacher)
    presentations.close(code, teacher)
    assert presentations._by_code == {}


def test_the_later_of_two_tabs_presents() -> None:
    presentations, code = Presentations(), code_of("k" * 32)
    first: list[Word] = []
    second: list[Word] = []
    one, other = first.append, second.append
    presentations.open(code, one)
    presentations.open(code, other)
    assert first[-1] == Audience(None)
    presentations.close(code, one)  # it does not any more
    pupil: list[Word] = []
    presentations.join(code, pupil.append)
    assert isinstance(pupil[-1], Presented)
    assert second[-1] == Audience(1)
