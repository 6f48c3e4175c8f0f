"""The explorer in a headless browser: what a person does and sees, in a few verbs.

What viser 1.1.1's page offers, as found by looking:

* A slider is a number field beside a track; typing there sets the value at each keystroke.
* A file input hides before each upload button. Notifications have the role `alert`.
* Rendering is on demand, and in software slow: `?fixedDpr=0.5` draws the scene at half resolution.
* Every tab of a tab group is in the page, only the chosen one is visible.
"""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Browser, FilePayload, Locator
from web_page import TIMEOUT_MS, Point, Window, new_page

from rnnpb_explorer.app.commands.photograph import wait_until_ready
from rnnpb_explorer.app.page.server import App
from rnnpb_explorer.app.state.statecode import encode

Pose = NDArray[np.float64]  # (K, 4) rotations (x, y, z, w) of a robot's moving nodes
DOCUMENT = "() => sessionStorage.getItem('rnnpb.document')"

_POSE = """(index) => {
    const { isCopy, copies, nodes } = window.rnnpb.part.robots.robots[index];
    return (isCopy ? copies[0].nodes : nodes).map(({ quaternion }) => quaternion.toArray());
}"""
# The page says hello as after a reload, and brings a document.
_BRING = """(text) => {
    const { part } = window.rnnpb;
    sessionStorage.setItem("rnnpb.document", text);
    part.played = false;
    part.hello();
}"""
# Where nodes of the scene stand on the page, in CSS pixels.
_POSITIONS = """(prefix) => {
    const { nodeRefFromName, camera, canvas } = window.__viserMutable;
    const box = canvas.getBoundingClientRect();
    return Object.entries(nodeRefFromName)
        .filter(([name, node]) => node && name.startsWith(prefix))
        .map(([, node]) => {
            const at = node.getWorldPosition(node.position.clone()).project(camera);
            return [box.x + (at.x + 1) / 2 * box.width, box.y + (1 - at.y) / 2 * box.height];
        });
}"""
_LABELS = """() => Object.entries(window.__viserSceneTree.getState())
    .filter(([name, node]) => node && name.startsWith("/names/"))
    .map(([, node]) => node.message.props.text)"""
_CANVAS = """() => new Promise((done) => {
    const { canvas, requestRender } = window.__viserMutable;
    requestRender();
    requestAnimationFrame(() => requestAnimationFrame(() => done(canvas.toDataURL("image/png"))));
})"""


def agree(first: Pose, second: Pose) -> bool:
    """Whether two poses are the same but for rounding."""
    return first.shape == second.shape and np.allclose(first, second, atol=1e-4)


@dataclass
class ExplorerPage(Window):
    """One browser window with the app in it."""

    opening: str = ""  # the document that it began with

    @classmethod
    def open(
        cls,
        browser: Browser,
        url: str,
        size: tuple[int, int] = (1280, 720),
        resolution: float = 0.5,
        **context: Any,
    ) -> ExplorerPage:
        """A window of its own (nothing shared with others), ready to be used."""
        explorer = cls(new_page(browser, size, **context))
        explorer.go(url, resolution)
        explorer.wait_ready()
        return explorer

    def another(self) -> ExplorerPage:
        """Another tab of the same browser, on the same app."""
        explorer = ExplorerPage(self.page.context.new_page())
        explorer.go(self.page.url.partition("?")[0], 0.5)
        explorer.wait_ready()
        return explorer

    def wait_ready(self) -> None:
        wait_until_ready(self.page)
        self.opening = self.page.wait_for_function(DOCUMENT).json_value()

    def reload(self, app: App) -> None:
        """Reload once the tab keeps what is on the screen."""

        def kept() -> bool:
            document = self.page.evaluate(DOCUMENT)
            return any(encode(one.document) == document for one in app.sessions.values())

        self.until(kept, "the tab keeps another document")
        self.page.reload()
        wait_until_ready(self.page)

    def start_over(self, pose: Pose) -> None:
        """Back to the document that the window opened with, and to its pose."""
        self.page.evaluate(_BRING, self.opening)
        self.until(lambda: agree(self.pose(), pose), "the page does not start over")
        self.wait_landscape()
        self.tab("Explore")

    # --- what one sees ---
    def pose(self, robot: int = 0) -> Pose:
        """A robot's pose as this window shows it."""
        return np.array(self.page.evaluate(_POSE, robot))

    def puck(self, board: str) -> Point:
        """Where a board's puck stands on the page."""
        x, y = self.part(f"[...part.{board}.puck]")
        return self.pixel(board, (x, y))

    def positions(self, prefix: str) -> NDArray[np.float64]:
        """(N, 2) pixels where the scene's nodes below a name stand on the page."""
        return np.array(self.page.evaluate(_POSITIONS, prefix))

    def names(self) -> list[str]:
        """What stands above the robots."""
        found: list[str] = self.page.evaluate(_LABELS)
        return found

    def canvas(self) -> bytes:
        """The 3D canvas as a PNG, freshly drawn."""
        url: str = self.page.evaluate(_CANVAS)
        return base64.b64decode(url.partition(",")[2])

    def alert(self, text: str) -> Locator:
        """The notification that holds this text."""
        return self.page.get_by_role("alert").filter(has_text=text).first

    def text(self, text: str) -> Locator:
        return self.page.get_by_text(text).first

    # --- what one does ---
    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name, exact=True).click()

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def click(self, button: str) -> None:
        self.button(button).click()

    def press(self, key: str) -> None:
        """Press a hotkey, with no widget in focus."""
        self.page.evaluate("() => document.activeElement?.blur()")
        self.page.keyboard.press(key)

    def field(self, label: str) -> Locator:
        """The input beside a label; a slider's number field."""
        row = self.page.locator(f'label:text-is("{label}")').locator(
            "xpath=ancestor::div[.//input][1]"
        )
        return row.locator("input:not([type=hidden])").first

    def value(self, label: str) -> float:
        return float(self.field(label).input_value())

    def mu(self) -> list[float]:
        return [self.value(f"μ {dim}") for dim in (1, 2, 3, 4)]

    def set_value(self, label: str, value: float) -> None:
        """Type into the number field of a slider."""
        self.field(label).fill(f"{value:g}")

    def upload(self, name: str, content: bytes) -> None:
        """Choose a file behind the first upload button of the page."""
        self.page.locator('input[type="file"]').first.set_input_files(
            FilePayload(name=name, mimeType="text/csv", buffer=content)
        )

    def download(self, button: str) -> tuple[str, bytes]:
        """Name and content of the file that a button has the browser save."""
        with self.page.expect_download() as download:
            self.click(button)
        return download.value.suggested_filename, Path(download.value.path()).read_bytes()

    def choose(self, label: str, option: str) -> None:
        """Choose from a drop-down list."""
        self.field(label).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def tick(self, label: str, on: bool) -> None:
        """Set a checkbox, whose own box is drawn beside it."""
        self.page.get_by_label(label).set_checked(on)

    # --- waiting ---
    def wait_landscape(self) -> None:
        self.wait_for("part.landscape.shown.complete")

    @contextmanager
    def landscape_follows(self) -> Iterator[None]:
        """What is done inside must end in another complete landscape."""
        before = self.told("landscape", "numbers")
        yield
        self.until(
            lambda: (
                self.told("landscape", "landscape").endswith("complete")
                and self.told("landscape", "numbers") != before
            ),
            "the landscape does not follow",
        )

    def until(self, condition: Callable[[], Any], otherwise: str) -> None:
        """Wait until a condition holds, looking ten times a second."""
        for _ in range(TIMEOUT_MS // 100):
            if condition():
                return
            self.page.wait_for_timeout(100)
        raise AssertionError(f"{otherwise} after {TIMEOUT_MS / 1000:g} s")


Open = Callable[..., ExplorerPage]  # url, size=(1280, 720), resolution=0.5
