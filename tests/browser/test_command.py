"""The command a person types, and the first thing that a person sees: Pepper moves."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from explorer_page import Open, agree

from rnnpb_explorer.core import shipped_checkpoints

COMMAND = Path(sys.executable).with_name("rnnpb-explorer")
READY = "rnnpb-explorer is ready at "


@pytest.fixture
def process() -> Iterator[subprocess.Popen[str]]:
    if "strong" not in shipped_checkpoints():
        pytest.skip("checkpoints/strong.pt is not there")
    process = subprocess.Popen(
        [str(COMMAND), "--port", "0"], text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE
    )
    yield process
    process.kill()
    process.wait()


def test_pepper_moves_at_once_and_ctrl_c_ends_it_while_a_browser_looks_on(
    process: subprocess.Popen[str], open_explorer: Open
) -> None:
    assert process.stdout is not None
    line = process.stdout.readline()
    assert line.startswith(READY)
    explorer = open_explorer(line.removeprefix(READY).strip())
    start = explorer.pose()
    explorer.until(lambda: not agree(explorer.pose(), start), "Pepper does not move")
    assert explorer.console_errors == []
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=30) == 0
    explorer.console_errors.clear()  # the browser's own words on the lost connection
