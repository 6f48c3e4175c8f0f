"""The app as a person would see it, photographed in headless Chromium (`rnnpb screenshot`)."""

from __future__ import annotations

import io
import os
import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image, ImageChops

from ...core import InputError
from ...robot.reading import NOTHING_SAID, Said

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
CHROMIUM_FLAGS = (
    "--no-sandbox",  # containers and continuous integration run as root
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-gpu-compositing",  # the page around the canvas is drawn faster without it
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
# viser lowers the resolution on a slow machine; a picture is always taken at full resolution.
URL_QUERY = "?fixedDpr=1"
# Robots with motions and all their nodes, the puck, and a complete landscape.
READY = """() => {
    const part = window.rnnpb?.part, robots = part?.robots.robots ?? [];
    const stands = ({ motion, isCopy, copies, nodes, model }) => motion && (isCopy
        ? copies.length > 0
        : nodes.length === model.nodes.length && nodes.every(Boolean));
    return robots.length > 0 && robots.every(stands) && part.map.puck !== null
        && part.landscape.shown?.complete;
}"""
READY_SECONDS = 120.0  # software rendering on a busy machine is slow
STILL_SECONDS = 5.0  # a moving robot never stands still; then the picture is taken as it is
# viser goes on rendering for 0.25 s after the last change; a canvas of another size is framed anew
# after 0.3 s.
CHECK_SECONDS = 0.6


def take_screenshot(
    *,
    checkpoints: Sequence[str],
    motion: str | None,
    frame: int | None,
    state_code: str | None,
    size: tuple[int, int],
    out: str | os.PathLike[str],
    data: str | None = None,
    said: Said = NOTHING_SAID,
    robot: str = "pepper",
) -> None:
    """Start the app on a free port, wait until everything is drawn, and write a PNG.

    Args:
        checkpoints: paths or shipped names; none for the default.
        motion: name or index of the motion to select.
        frame: the frame to stop at.
        state_code: the state to restore.
        size: (width, height) of the page in pixels.
        out: the PNG file to write.

    Raises:
        InputError: Playwright or a browser is missing, the app refuses its input, or `out` cannot
            be written.
    """
    from ..page.server import (
        ServerOptions,
        start,
    )  # the app is heavy; a missing browser tells at once

    with chromium() as browser:
        options = ServerOptions(
            checkpoints=tuple(checkpoints) or ServerOptions().checkpoints,
            port=0,
            robot=robot,
            data=data,
            said=said,
            motion=motion,
            frame=frame,
            state_code=state_code,
        )
        app = start(options)
        try:
            picture = photograph(browser, app.url, size)
        finally:
            app.stop()
    try:
        Path(out).write_bytes(picture)
    except OSError as error:
        raise InputError(f"cannot write {os.fspath(out)}: {error.strerror}") from error


def photograph(browser: Browser, url: str, size: tuple[int, int]) -> bytes:
    """A PNG of the app at an address, complete and, where the robot is paused, at rest.

    Args:
        size: (width, height) of the page in pixels.

    Raises:
        InputError: the page did not become complete.
    """
    width, height = size
    page = browser.new_page(viewport={"width": width, "height": height})
    try:
        page.goto(url + URL_QUERY)
        wait_until_ready(page)
        return _picture_at_rest(page)
    finally:
        page.close()


@contextmanager
def chromium() -> Iterator[Browser]:
    """A headless Chromium that renders WebGL in software.

    Raises:
        InputError: Playwright or a browser is missing.
    """
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        raise InputError(
            "screenshots need Playwright: pip install 'rnnpb-explorer[browser]'"
        ) from None
    with sync_playwright() as playwright:
        executable = find_chromium() or playwright.chromium.executable_path
        if not Path(executable).is_file():
            raise InputError(
                "no Chromium or Chrome found: install one (Debian: apt-get install chromium; "
                "elsewhere: playwright install chromium), or set RNNPB_CHROMIUM to its path"
            )
        try:
            browser = playwright.chromium.launch(
                executable_path=executable, args=list(CHROMIUM_FLAGS)
            )
        except Error as error:
            reason = error.message.splitlines()[0]
            raise InputError(f"{executable} does not start as a browser: {reason}") from error
        try:
            yield browser
        finally:
            browser.close()


def find_chromium() -> str | None:
    """The browser in RNNPB_CHROMIUM or on the PATH; Playwright's own is not among them."""
    named = os.environ.get("RNNPB_CHROMIUM")
    return named or next(filter(None, map(shutil.which, CHROMIUM_NAMES)), None)


def wait_until_ready(page: Page) -> None:
    """Wait for the robot and the complete landscape; keep viser's notice on software WebGL away.

    Raises:
        InputError: it took too long.
    """
    from playwright.sync_api import TimeoutError as PlaywrightTimeoutError

    page.add_style_tag(content="#webgl-software-rendering { display: none }")
    try:
        page.wait_for_function(READY, timeout=READY_SECONDS * 1000)
    except PlaywrightTimeoutError as error:
        raise InputError(f"the page was not complete after {READY_SECONDS:g} s") from error


def _picture_at_rest(page: Page) -> bytes:
    """A PNG of the page once two pictures in a row are the same, or STILL_SECONDS have passed."""
    deadline = time.monotonic() + STILL_SECONDS
    picture = page.screenshot()
    while time.monotonic() < deadline:
        page.wait_for_timeout(CHECK_SECONDS * 1000)
        previous, picture = picture, page.screenshot()
        if _same(previous, picture):
            break
    return picture


def _same(first: bytes, second: bytes) -> bool:
    images = [Image.open(io.BytesIO(png)).convert("RGB") for png in (first, second)]
    return ImageChops.difference(*images).getbbox() is None
