"""One server and one headless Chromium for all browser tests, and a fresh window for each."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from explorer_page import ExplorerPage, Open

from rnnpb_explorer.app.commands.photograph import chromium
from rnnpb_explorer.core import InputError, shipped_checkpoints

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from rnnpb_explorer.app.page.server import App

HERE = Path(__file__).parent
MOTION = "Alienated_1"  # its landscape has a slope that changes with every component
FRAME = 40


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.browser)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    try:
        with chromium() as launched:
            yield launched
    except InputError as error:
        if os.environ.get("RNNPB_REQUIRE_BROWSER") == "1":
            pytest.fail(str(error))
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def app() -> Iterator[App]:
    """The app on the shipped checkpoint, without any data set.

    It opens paused: a robot that plays keeps a software renderer busy all the time.
    """
    if "strong" not in shipped_checkpoints():
        pytest.skip("checkpoints/strong.pt is not there")
    from rnnpb_explorer.app.page.server import ServerOptions, start

    running = start(ServerOptions(port=0, motion=MOTION, frame=FRAME))
    yield running
    running.stop()


@pytest.fixture
def open_explorer(browser: Browser, app: App, request: pytest.FixtureRequest) -> Iterator[Open]:
    """Open windows with the app; each is photographed and closed after the test.

    A page that logged an error at any time fails the test, whatever it was about.
    """
    opened: list[ExplorerPage] = []

    def open_page(
        width: int = 1280, height: int = 720, resolution: float = 0.5, url: str = app.url
    ) -> ExplorerPage:
        opened.append(ExplorerPage.open(browser, url, width, height, resolution))
        return opened[-1]

    yield open_page
    for number, explorer in enumerate(opened):
        suffix = f"-{number + 1}" if len(opened) > 1 else ""
        explorer.screenshot(request.node.name + suffix)
        explorer.close()
    assert [error for explorer in opened for error in explorer.console_errors] == []


@pytest.fixture
def explorer(open_explorer: Open) -> ExplorerPage:
    """A window of 1280x720 with the app in it, ready."""
    return open_explorer()
