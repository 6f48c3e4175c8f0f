"""A viser server of the tests' own, for panels without a page."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import viser


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    made = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield made
    made.stop()


@pytest.fixture
def gui(server: viser.ViserServer) -> Iterator[viser.GuiApi]:
    yield server.gui
    server.gui.reset()
