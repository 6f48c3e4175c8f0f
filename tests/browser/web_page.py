"""The browser's part in a headless browser, and the server of `web_demo.py` behind it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, CDPSession, Page

TIMEOUT_MS = 60_000  # software rendering on a busy machine; only a failing test waits so long
ARTIFACTS = Path(__file__).parents[2] / "test-artifacts"
DEMO = Path(__file__).with_name("web_demo.py")
Point = tuple[float, float]

# Where a point of a board's data stands on the page, in CSS pixels.
_PIXEL = """([board, [x, y]]) => {
    const { view, parts, surface } =
        window.rnnpb.part.layout.boards.find(({ name }) => name === board);
    const at = parts.plot.getBoundingClientRect();
    const { extent, box } = view, scale = at.width / surface.width;
    return [
        at.x + scale * (box.left + (x - extent.left) / (extent.right - extent.left) * box.width),
        at.y + scale * (box.top + (extent.top - y) / (extent.top - extent.bottom) * box.height),
    ];
}"""
_POSES = """(prefix) => Object.fromEntries(
    Object.entries(window.__viserMutable.nodeRefFromName)
        .filter(([name, node]) => node && name.startsWith(prefix))
        .map(([name, { quaternion }]) => [name, quaternion.toArray()]))"""


class Server:
    """`web_demo.py` in a process of its own."""

    def __init__(self, *options: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(DEMO), *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self._process.stdout is not None
        first = self._process.stdout.readline()
        if not first:
            raise AssertionError(f"the server does not start: {self._process.wait()}")
        self.port: int = json.loads(first)["port"]
        self.said: list[dict[str, Any]] = []  # every message of every page
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.said.append(json.loads(line))

    def command(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def freeze(self) -> None:
        self._process.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self._process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()


@dataclass
class Window:
    """One window with the browser's part in it, whatever server is behind it."""

    page: Page
    console_errors: list[str] = field(default_factory=list)

    def go(self, url: str, resolution: float) -> None:
        """Open an address and note all errors from then on.

        Args:
            resolution: pixels of the canvas for one of the page.
        """
        self.page.on("console", lambda m: m.type == "error" and self.console_errors.append(m.text))
        self.page.on("pageerror", lambda error: self.console_errors.append(str(error)))
        self.page.goto(f"{url}{'&' if '?' in url else '?'}fixedDpr={resolution}")
        self.page.add_style_tag(content="#webgl-software-rendering { display: none }")

    def close(self) -> None:
        self.page.context.close()

    def screenshot(self, name: str) -> None:
        ARTIFACTS.mkdir(exist_ok=True)
        self.page.screenshot(path=ARTIFACTS / f"{name}.png")

    # --- what one sees ---
    def told(self, board: str, name: str) -> str:
        """A line of a board's text form."""
        line = self.page.locator(f"[data-board={board}] [data-name={name}]")
        return line.text_content() or "" if line.count() else ""

    def part(self, expression: str) -> Any:
        """The value of a JavaScript expression in which `part` is ours."""
        return self.page.evaluate(
            f"() => {{ const {{ part }} = window.rnnpb; return {expression}; }}"
        )

    def pixel(self, board: str, point: Point) -> Point:
        x, y = self.page.evaluate(_PIXEL, [board, list(point)])
        return x, y

    def plot(self, board: str) -> Any:
        return self.page.locator(f"[data-board={board}] .rb-plot")

    def poses(self) -> dict[str, list[float]]:
        """Rotation (x, y, z, w) of each of the robot's nodes."""
        found: dict[str, list[float]] = self.page.evaluate(_POSES, "/robot/")
        return found

    # --- what one does ---
    def drag(self, start: Point, end: Point, steps: int = 6) -> None:
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        mouse.move(*end, steps=steps)
        mouse.up()

    def touch(self) -> CDPSession:
        return self.page.context.new_cdp_session(self.page)

    def fingers(self, session: CDPSession, kind: str, *points: Point) -> None:
        """Put fingers down (touchStart), move them (touchMove) or lift them (touchEnd)."""
        touches = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})

    # --- waiting ---
    def wait_for(self, expression: str) -> None:
        """Until a JavaScript expression holds, in which `part` is ours."""
        self.page.wait_for_function(
            f"() => {{ const {{ part }} = window.rnnpb; return {expression}; }}"
        )

    def wait_heard(self) -> None:
        """Until the server has answered the last move."""
        self.wait_for(
            "part.map.state.heard >= Math.max(part.map.moves.number, part.landscape.moves.number)"
        )


def new_page(
    browser: Browser, size: tuple[int, int], init: str | None = None, **context: Any
) -> Page:
    """A page that shares nothing with others.

    Args:
        init: JavaScript that runs before the page's own.
    """
    opened = browser.new_context(viewport={"width": size[0], "height": size[1]}, **context)
    opened.set_default_timeout(TIMEOUT_MS)
    if init:
        opened.add_init_script(init)
    return opened.new_page()


@dataclass
class WebPage(Window):
    """One window, and what it asked the server of `web_demo.py`."""

    server: Server = field(kw_only=True)
    _since: int = 0

    @classmethod
    def open(
        cls,
        browser: Browser,
        server: Server,
        size: tuple[int, int] = (1280, 720),
        *,
        resolution: float = 0.5,
        ready: bool = True,
        init: str | None = None,
        **context: Any,
    ) -> WebPage:
        """A window of its own, ready unless said otherwise."""
        page = new_page(browser, size, init, **context)
        web = cls(page, server=server, _since=len(server.said))
        web.go(f"http://127.0.0.1:{server.port}", resolution)
        if ready:
            web.wait_ready()
        return web

    def wait_ready(self) -> None:
        self.page.wait_for_function("() => window.rnnpb?.part.landscape.shown?.complete")
        self.wait_for("part.playback.clock.frames > 1 && part.map.puck !== null")

    def asked(self, kind: str) -> list[dict[str, Any]]:
        """What this page has asked since it was opened or `forget` was called."""
        return [one for one in self.server.said[self._since :] if one.get("type") == kind]

    def forget(self) -> None:
        self._since = len(self.server.said)

    def wait_asked(self, kind: str, count: int = 1) -> list[dict[str, Any]]:
        """Until the page has asked this so many times."""
        for _ in range(TIMEOUT_MS // 50):
            if len(found := self.asked(kind)) >= count:
                return found
            self.page.wait_for_timeout(50)
        raise AssertionError(f"the page has not asked {kind} {count} times")

    def wait_moved(self, kind: str) -> dict[str, Any]:
        """The last move of this kind, once the hand has let go and the server has answered it."""
        self.wait_heard()
        for _ in range(TIMEOUT_MS // 50):
            if (found := self.asked(kind)) and found[-1]["done"]:
                return found[-1]
            self.page.wait_for_timeout(50)
        raise AssertionError(f"no {kind} was the last of its gesture")
