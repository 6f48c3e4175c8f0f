"""One server and one headless Chromium for all browser tests, one window for each module."""

from __future__ import annotations

import os
import re
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from explorer_page import ExplorerPage, Open, Pose

from rnnpb_explorer.app.commands.photograph import chromium
from rnnpb_explorer.core import InputError, shipped_checkpoints

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from rnnpb_explorer.app.page.server import App

HERE = Path(__file__).parent
MOTION = "Alienated_1"  # its landscape has a slope that changes with every component
FRAME = 40
FAILED = pytest.StashKey[bool]()


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
def open_explorer(browser: Browser, request: pytest.FixtureRequest) -> Iterator[Open]:
    """Open windows of their own; each is closed after the test.

    A page that logged an error at any time fails the test, whatever it was about.
    """
    opened: list[ExplorerPage] = []

    def open_page(url: str, **options: Any) -> ExplorerPage:
        opened.append(ExplorerPage.open(browser, url, **options))
        return opened[-1]

    yield open_page
    for number, explorer in enumerate(opened):
        photograph_failure(explorer, request, f"-{number + 1}")
        explorer.close()
    assert [error for explorer in opened for error in explorer.console_errors] == []


@pytest.fixture(scope="module")
def window(browser: Browser, app: App) -> Iterator[tuple[ExplorerPage, Pose]]:
    """One window of 1280x720 for a module, and how the robot stands in it."""
    explorer = ExplorerPage.open(browser, app.url)
    explorer.until(lambda: explorer.part("part.robots.unsettled") == 0, "the robot does not rest")
    yield explorer, explorer.pose()
    explorer.close()


@pytest.fixture
def explorer(
    window: tuple[ExplorerPage, Pose], request: pytest.FixtureRequest
) -> Iterator[ExplorerPage]:
    """The module's window with the document that it opened with; no test may log an error."""
    explorer, pose = window
    explorer.start_over(pose)
    yield explorer
    photograph_failure(explorer, request)
    errors, explorer.console_errors[:] = explorer.console_errors[:], []
    assert errors == []


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, Any]:
    report = yield
    if report.when == "call":
        item.stash[FAILED] = report.failed
    return report


def photograph_failure(
    explorer: ExplorerPage, request: pytest.FixtureRequest, suffix: str = ""
) -> None:
    """Keep a picture of the page on which a test has failed among the artefacts."""
    if request.node.stash.get(FAILED, False):
        explorer.screenshot(re.sub(r"[^\w-]+", "-", request.node.name).strip("-") + suffix)
