"""The explorer in a headless browser: what a person does and sees, in a few verbs.

What viser 1.1.1's page offers, as found by looking:

* The 3D canvas is `canvas[data-engine]`; curves have canvases of their own. It keeps its drawing
  buffer, so `toDataURL` gives its pixels without the panels that float above it.
* `window.__viserMutable` has the camera and the scene's objects by node name, posed as this browser
  has them: tests see what arrived, not what was sent.
* A slider is a number field beside a track; typing there sets the value at each keystroke.
* A file input hides before each upload button. Notifications have the role `alert`.
* Rendering is on demand, and in software slow: `?fixedDpr=0.5` draws the scene at half resolution.
* Every tab of a tab group is in the page, only the chosen one is visible.
"""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, FilePayload, Locator, Page

from rnnpb_explorer.app.commands.photograph import CANVAS, LANDSCAPE_COMPLETE, wait_until_ready

TIMEOUT_MS = 60_000  # software rendering on a busy machine; only a failing test waits so long
ARTIFACTS = Path(__file__).parents[2] / "test-artifacts"

T = TypeVar("T")
Point = tuple[float, float]
Poses = dict[str, tuple[float, ...]]  # by node name: rotation (x, y, z, w), position (x, y, z)
Mask = NDArray[np.bool_]  # (height, width)
Pixels = NDArray[np.int16]  # (height, width, 3), signed so that they can be subtracted

# Where a node stands on the page, in CSS pixels: what the browser itself would draw there.
_SCREEN_POSITION = """(name) => {
    const mutable = window.__viserMutable, node = mutable.nodeRefFromName[name];
    if (!node) return null;
    const at = node.getWorldPosition(node.position.clone()).project(mutable.camera);
    const box = mutable.canvas.getBoundingClientRect();
    return [box.x + (at.x + 1) / 2 * box.width, box.y + (1 - at.y) / 2 * box.height];
}"""
_CORNERS = """([name, size]) => {
    const mutable = window.__viserMutable, node = mutable.nodeRefFromName[name];
    const box = mutable.canvas.getBoundingClientRect();
    return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => {
        const corner = node.position.clone().set(x * size[0] / 2, y * size[1] / 2, 0);
        const at = node.localToWorld(corner).project(mutable.camera);
        return [box.x + (at.x + 1) / 2 * box.width, box.y + (1 - at.y) / 2 * box.height];
    });
}"""
_POSES = """(prefix) => Object.fromEntries(
    Object.entries(window.__viserMutable.nodeRefFromName)
        .filter(([name, node]) => node && name.startsWith(prefix))
        .map(([name, { quaternion, position }]) =>
            [name, [...quaternion.toArray(), ...position.toArray()]]))"""
# viser sets every object's visibility anew in each frame, from here.
_SET_VISIBLE = """([name, visible]) => {
    window.__viserSceneTree.getState()[name].overrideVisibility = visible ? undefined : false;
    window.__viserMutable.requestRender();
}"""
_ARROW_VISIBLE = """() => {
    const mutable = window.__viserMutable;
    let root = Object.values(mutable.nodeRefFromName).find((node) => node);
    while (root.parent) root = root.parent;
    mutable.requestRender();
    return root.children.some((child) => child.type === 'ArrowHelper' && child.visible);
}"""
_LABEL = "(name) => window.__viserSceneTree.getState()[name]?.message.props.text"
_TWO_FRAMES = """() => new Promise((done) => {
    window.__viserMutable.requestRender();
    requestAnimationFrame(() => requestAnimationFrame(() => done()));
})"""
# Chromium's word on how viser's page listens to a drag; nothing in it is the app's.
_VISERS_OWN_ERROR = "Unable to preventDefault inside passive event listener invocation."
_LANDSCAPE = re.compile(r"^Landscape ")
_CAMERA = "() => window.__viserMutable.camera.matrixWorld.toArray()"
_TOPMOST = "(points) => points.map(([x, y]) => document.elementFromPoint(x, y)?.tagName)"


def differing(first: Pixels, second: Pixels, by: int = 8) -> Mask:
    """Pixels of which any channel differs by more than rounding does."""
    mask: Mask = (np.abs(first - second) > by).any(axis=2)
    return mask


def grown(mask: Mask, by: int = 3) -> Mask:
    """The mask and all pixels up to `by` beside it: the soft edges of shapes and shadows."""
    image = Image.fromarray(mask.astype(np.uint8) * 255)
    return np.asarray(image.filter(ImageFilter.MaxFilter(2 * by + 1))) > 0


def agree(first: Poses, second: Poses) -> bool:
    """Whether two sets of poses are the same but for rounding."""
    return first.keys() == second.keys() and all(
        np.allclose(first[name], second[name], atol=1e-4) for name in first
    )


@dataclass
class ExplorerPage:
    """One browser window with the app in it."""

    page: Page
    resolution: float  # pixels of the canvas for one of the page
    console_errors: list[str] = field(default_factory=list)

    @classmethod
    def open(
        cls,
        browser: Browser,
        url: str,
        width: int = 1280,
        height: int = 720,
        resolution: float = 0.5,
    ) -> ExplorerPage:
        """A window of its own (nothing shared with others), ready to be used."""
        context = browser.new_context(viewport={"width": width, "height": height})
        context.set_default_timeout(TIMEOUT_MS)
        return cls._in(context, url, resolution)

    @classmethod
    def _in(cls, context: BrowserContext, url: str, resolution: float) -> ExplorerPage:
        explorer = cls(context.new_page(), resolution)
        explorer.page.on("console", explorer._note_console)
        explorer.page.on("pageerror", lambda error: explorer.console_errors.append(str(error)))
        explorer.page.goto(f"{url}?fixedDpr={resolution}")
        explorer.wait_ready()
        return explorer

    def another(self) -> ExplorerPage:
        """Another window of the same browser, on the same app."""
        return self._in(self.page.context, self.page.url.partition("?")[0], self.resolution)

    def _note_console(self, message: ConsoleMessage) -> None:
        if message.type == "error" and message.text != _VISERS_OWN_ERROR:
            self.console_errors.append(message.text)

    def wait_ready(self) -> None:
        wait_until_ready(self.page)

    def reload(self) -> None:
        self.page.reload()
        self.wait_ready()

    def close(self) -> None:
        self.page.context.close()

    # --- what one sees ---
    def canvas_pixels(self) -> Pixels:
        """(height, width, 3): the 3D canvas without the panels, as last drawn."""
        url: str = self.page.locator(CANVAS).evaluate("(canvas) => canvas.toDataURL('image/png')")
        png = base64.b64decode(url.partition(",")[2])
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(np.int16)

    def still_pixels(self) -> Pixels:
        """The canvas once it has come to rest; the robot must be paused."""
        self.page.evaluate(_TWO_FRAMES)
        return self._at_rest(self.canvas_pixels, np.array_equal, "the canvas")

    def still_poses(self, prefix: str) -> Poses:
        """The poses below a name once they have come to rest; the robot must be paused."""
        return self._at_rest(lambda: self.poses(prefix), agree, prefix)

    def still_camera(self) -> None:
        look: Callable[[], list[float]] = partial(self.page.evaluate, _CAMERA)
        self._at_rest(look, np.allclose, "the camera")

    def _at_rest(self, look: Callable[[], T], same: Callable[[T, T], bool], what: str) -> T:
        """What three looks in a row see: 80 ms apart, where viser's messages are 50."""
        seen = [look()]
        for _ in range(100):
            self.page.wait_for_timeout(80)
            seen = [*seen, look()][-3:]
            if len(seen) == 3 and same(seen[0], seen[1]) and same(seen[1], seen[2]):
                return seen[-1]
        raise AssertionError(f"{what} does not come to rest")

    def screenshot(self, name: str) -> Path:
        """Keep a picture of the page among the artefacts of the run."""
        ARTIFACTS.mkdir(exist_ok=True)
        path = ARTIFACTS / (re.sub(r"[^\w-]+", "-", name).strip("-") + ".png")
        self.page.screenshot(path=path)
        return path

    def canvas_box(self) -> tuple[float, float, float, float]:
        """x, y, width, height of the 3D canvas on the page."""
        box = self.page.locator(CANVAS).bounding_box()
        assert box is not None
        return box["x"], box["y"], box["width"], box["height"]

    def position(self, node: str) -> Point:
        """Where a scene node stands on the page."""
        self.wait_for(lambda: self.page.evaluate(_SCREEN_POSITION, node), f"no node {node}")
        x, y = self.page.evaluate(_SCREEN_POSITION, node)
        return x, y

    def corners(self, node: str, size: Point) -> list[Point]:
        """Where the corners of a flat node of this size (width, height) stand on the page."""
        return [(x, y) for x, y in self.page.evaluate(_CORNERS, [node, list(size)])]

    def region(self, node: str, side: float) -> tuple[slice, slice]:
        """The canvas' pixels that a square board with this side (metres) fills."""
        left, top, _, _ = self.canvas_box()
        corners = np.array(self.corners(node, (side, side))) - (left, top)
        corners *= self.resolution
        low = np.ceil(corners.min(axis=0)).astype(int)
        high = np.floor(corners.max(axis=0)).astype(int)
        return slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))

    def topmost(self, points: list[Point]) -> list[str]:
        """The tags of what lies on top at points of the page; CANVAS where no panel covers it."""
        found: list[str] = self.page.evaluate(_TOPMOST, [list(point) for point in points])
        return found

    def landscape_text(self) -> str:
        """The line that says how far the landscape is, with its numbers."""
        return self.page.get_by_text(_LANDSCAPE).first.text_content() or ""

    def poses(self, prefix: str) -> Poses:
        """Rotation (x, y, z, w) and position of the nodes below a name, in this browser."""
        found: dict[str, list[float]] = self.page.evaluate(_POSES, prefix)
        return {name: tuple(pose) for name, pose in found.items()}

    def set_visible(self, node: str, visible: bool) -> None:
        """Hide or show a node in this browser only; the app does not know of it."""
        self.page.evaluate(_SET_VISIBLE, [node, visible])

    def label(self, node: str) -> str | None:
        """What a label of the scene says."""
        text: str | None = self.page.evaluate(_LABEL, node)
        return text

    def draw_drag_arrow(self) -> None:
        """Have the page draw the arrow that viser shows while one drags, and a frame more."""
        self.wait_for(lambda: self.page.evaluate(_ARROW_VISIBLE), "no arrow is drawn in the drag")
        self.page.evaluate(_TWO_FRAMES)

    def alert(self, text: str) -> Locator:
        """The notification that holds this text."""
        return self.page.get_by_role("alert").filter(has_text=text)

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

    def seek(self, frame: int, robot: str) -> None:
        """Go to a frame and wait until the robot stands as it should there."""
        before = self.still_poses(robot)
        if self.value("Frame") != frame:
            self.set_value("Frame", frame)
            self.wait_for(lambda: not agree(self.poses(robot), before), "the robot does not move")
        self.still_poses(robot)

    def field(self, label: str) -> Locator:
        """The input beside a label; a slider's number field."""
        row = self.page.locator(f'label:text-is("{label}")').locator(
            "xpath=ancestor::div[.//input][1]"
        )
        return row.locator("input:not([type=hidden])").first

    def value(self, label: str) -> float:
        return float(self.field(label).input_value())

    def set_value(self, label: str, value: float) -> None:
        """Type into the number field of a slider."""
        self.field(label).fill(f"{value:g}")

    def drag(
        self,
        start: Point,
        end: Point,
        steps: int = 8,
        held: Callable[[], None] = lambda: None,
    ) -> None:
        """Press, move, release; slowly enough for viser's 50 ms between drag messages.

        Args:
            held: done with the button still down after each move but the first, which viser still
                takes for a click.
        """
        mouse = self.page.mouse
        mouse.move(*start)
        self.page.evaluate(_TWO_FRAMES)  # the canvas learns what is under the pointer
        mouse.down()
        for step in range(1, steps + 1):
            share = step / steps
            mouse.move(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))
            self.page.wait_for_timeout(60)
            if step > 1:
                held()
        mouse.up()

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
    @contextmanager
    def landscape_follows(self) -> Iterator[None]:
        """What is done inside must end in another complete landscape."""
        before = self.landscape_text()
        yield

        def followed() -> bool:
            text = self.landscape_text()
            return text != before and LANDSCAPE_COMPLETE.match(text) is not None

        self.wait_for(followed, "the landscape does not follow")

    def wait_for(self, condition: Callable[[], Any], otherwise: str) -> None:
        """Wait until a condition holds, looking ten times a second."""
        for _ in range(TIMEOUT_MS // 100):
            if condition():
                return
            self.page.wait_for_timeout(100)
        raise AssertionError(f"{otherwise} after {TIMEOUT_MS / 1000:g} s")


Open = Callable[..., ExplorerPage]  # (width=1280, height=720, resolution=0.5)
