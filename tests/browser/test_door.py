"""A page of another site, in the same browser: what it tries, and what it gets."""

from __future__ import annotations

import http.server
import threading
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import pytest
import viser
from explorer_page import ExplorerPage
from playwright.sync_api import Browser, BrowserContext, Page, expect
from web_page import TIMEOUT_MS

from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.app.page.uploads import TOO_LARGE

TABS = ("Explore", "Recognise", "Robot", "View", "Help")
PROTOCOL = f"viser-v{viser.__version__}"
# Each answers with what the page got: "in", or "kept out".
SOCKET = """([url, protocol]) => new Promise((done) => {
    const socket = new WebSocket(url, [protocol]);
    socket.onopen = () => done("in");
    socket.onerror = () => done("kept out");
})"""
FETCH = """(url) => fetch(url).then(() => "in", () => "kept out")"""
SCRIPT = """(url) => new Promise((done) => {
    const script = document.createElement("script");
    script.src = url;
    script.onload = () => done("in");
    script.onerror = () => done("kept out");
    document.head.append(script);
})"""


class Site(http.server.BaseHTTPRequestHandler):
    """Some other site: an empty page, and one with a frame; `/frame?URL`."""

    def do_GET(self) -> None:
        framed = self.path.partition("?")[2]
        frame = f'<iframe src="{framed}" width="1200" height="700"></iframe>' if framed else ""
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.send_header("Access-Control-Allow-Origin", "*")  # it gives to everybody
        self.end_headers()
        self.wfile.write(f"<!doctype html><title>another site</title>{frame}".encode())

    def log_message(self, *arguments: Any) -> None:
        pass


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    """The address of another site on this machine."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Site) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    opened = browser.new_context(viewport={"width": 1280, "height": 720})
    opened.set_default_timeout(TIMEOUT_MS)
    yield opened
    opened.close()


def socket_of(url: str) -> str:
    return url.replace("http", "ws", 1)


def at(page: Page, url: str) -> Page:
    page.goto(url)
    return page


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost"])
def test_a_page_of_another_site_opens_no_session(
    app: App, site: str, context: BrowserContext, name: str
) -> None:
    page = at(context.new_page(), site.replace("127.0.0.1", name))
    before = set(app.sessions)
    assert page.evaluate(SOCKET, [socket_of(app.url), PROTOCOL]) == "kept out"
    assert page.evaluate(FETCH, app.url) == "kept out"
    assert page.evaluate(SCRIPT, app.url) == "kept out"
    assert set(app.sessions) == before


def test_a_page_without_an_origin_opens_no_session(app: App, context: BrowserContext) -> None:
    page = at(context.new_page(), "data:text/html,<title>nowhere</title>")
    assert page.evaluate("origin") == "null"
    assert page.evaluate(SOCKET, [socket_of(app.url), PROTOCOL]) == "kept out"


def test_our_own_page_opens_the_same_socket(app: App, explorer: ExplorerPage) -> None:
    """What keeps the others out is who they are, not what they ask for."""
    assert explorer.page.evaluate(SOCKET, [socket_of(app.url), PROTOCOL]) == "in"


def test_another_site_cannot_embed_the_page(app: App, site: str, context: BrowserContext) -> None:
    page = context.new_page()
    with page.expect_console_message(lambda message: "frame" in message.text.lower()) as refusal:
        page.goto(f"{site}/frame?{app.url}")
    assert "frame-ancestors" in refusal.value.text or "X-Frame-Options" in refusal.value.text
    assert all("viser" not in frame.content().lower() for frame in page.frames[1:])


def test_a_course_page_that_was_named_embeds_it(site: str, context: BrowserContext) -> None:
    running = start(ServerOptions(port=0, motion="0", frame=1, allow_frames=(site,)))
    try:
        page = at(context.new_page(), f"{site}/frame?{running.url}/?fixedDpr=0.3")
        inside = page.frame_locator("iframe")
        inside.get_by_role("tab", name="Explore", exact=True).wait_for()
        assert page.evaluate(SOCKET, [socket_of(running.url), PROTOCOL]) == "kept out"
    finally:
        running.stop()


def test_the_page_breaks_no_rule_of_its_own(explorer: ExplorerPage) -> None:
    """Every tab, curves and canvases included; a broken rule is an error in the console."""
    for tab in TABS:
        explorer.tab(tab)
    assert explorer.console_errors == []


def test_the_page_runs_no_script_that_gets_into_it(explorer: ExplorerPage) -> None:
    insert = """const image = document.createElement("div");
        image.innerHTML = '<img src="data:," onerror="window.stolen = 1">';
        document.body.append(image);"""
    assert broken_rule(explorer, insert) == "script-src-attr"
    assert explorer.page.evaluate("window.stolen") is None


def test_the_page_connects_to_us_alone(explorer: ExplorerPage, site: str) -> None:
    assert broken_rule(explorer, f"fetch('{site}').catch(() => 0)") == "connect-src"
    assert broken_rule(explorer, f"new WebSocket('{socket_of(site)}')") == "connect-src"


def broken_rule(explorer: ExplorerPage, script: str) -> str | None:
    """The directive of the policy that a script breaks; None where it breaks none at once."""
    rule: str | None = explorer.page.evaluate(
        """(script) => new Promise((done) => {
            document.addEventListener("securitypolicyviolation",
                (event) => done(event.effectiveDirective), { once: true });
            try { new Function(script)(); } catch (error) { console.log(error); }
            setTimeout(() => done(null), 5000);
        })""",
        script,
    )
    explorer.console_errors.clear()  # Chromium tells of it
    return rule


@pytest.mark.parametrize("parameter", ["websocket=ws://127.0.0.1:9", "playbackPath=/x.viser"])
def test_an_address_does_not_lead_the_page_elsewhere(
    app: App, context: BrowserContext, parameter: str
) -> None:
    page = at(context.new_page(), f"{app.url}/?{parameter}&fixedDpr=0.3")
    assert page.url == f"{app.url}/?fixedDpr=0.3"
    page.get_by_role("tab", name="Explore", exact=True).wait_for()


def test_a_class_comes_in_with_its_token(context: BrowserContext) -> None:
    running = start(ServerOptions(port=0, motion="0", frame=1, token="chalk&board"))
    try:
        page = at(context.new_page(), running.url)
        page.get_by_text("needs its token").first.wait_for()
        page.get_by_label("Token").fill("guess")
        page.get_by_role("button", name="Open").click()
        page.get_by_text("not the right one").wait_for()
        assert running.sessions == {}
        page.get_by_label("Token").fill("chalk&board")
        page.get_by_role("button", name="Open").click()
        page.get_by_role("tab", name="Explore", exact=True).wait_for()
        assert "token" not in page.url
        assert "chalk" not in page.evaluate("document.cookie")
        page.reload()  # the cookie alone
        page.get_by_role("tab", name="Explore", exact=True).wait_for()
        (cookie,) = context.cookies(running.url)
        assert cookie["httpOnly"]
        assert str(urlsplit(running.url).port) in cookie["name"]
    finally:
        running.stop()


def test_a_file_that_is_too_large_is_refused_on_the_page(explorer: ExplorerPage) -> None:
    explorer.tab("Recognise")
    explorer.upload("large.csv", b"1" * 9_000_000)
    explorer.alert(TOO_LARGE).wait_for()
    expect(explorer.button("Upload a motion")).to_be_enabled()
    expect(explorer.page.get_by_role("alert").filter(has_text="Uploading")).to_have_count(0)
