"""Pages that drag or play at once: from the hand's move to its motion, memory, the server's work.

The server runs here, the pages in a process of their own (page_clients.py), all on the same cores.
The plain way beside it is one page whose motion is generated step by step as in eqs. 6 to 8, alone
on the machine: what a move cannot cost less than without the folded form.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from timing import step_by_step

from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.core.model import RNNPB

DRAGGING = (1, 4, 16)
PLAYING = 16
SECONDS = 10.0


def run(model: RNNPB) -> str:
    app = start(ServerOptions(port=0))
    lines = [f"Pages at once, {os.cpu_count()} cores for the server and its pages together"]
    try:
        motion = app.opening.models[0].latent.motion
        plain, line = step_by_step(model, motion)
        lines.append(line)
        _pages(app, 1, 1.0, "play")  # the first page pays for what all share
        for pages in DRAGGING:
            lines.append(_dragging(app, pages, motion, plain))
        lines.append(_playing(app))
    finally:
        app.stop()
    return "\n".join(lines)


def _dragging(app: App, pages: int, motion: int, plain: float) -> str:
    before = _memory()
    found, during, _ = _pages(app, pages, SECONDS, str(motion))
    after = _memory()
    latencies = np.concatenate([np.array(page) for page in found["latencies"]])
    medians = [float(np.median(page)) for page in found["latencies"]]
    median, p95 = np.percentile(latencies, [50, 95])
    moves = pages * SECONDS / 0.05
    return (
        f"  {pages:2} dragging at 20 Hz: median {median:.0f} ms ({median / 1e3 / plain:.1f} x), "
        f"95th percentile {p95:.0f} ms ({p95 / 1e3 / plain:.1f} x); slowest page's median "
        f"{max(medians):.0f} ms; {len(latencies) / moves:.0%} of the moves seen; "
        f"memory a page {(during - before) / pages / 1e6:.1f} MB, "
        f"after they left {(after - before) / 1e6:+.0f} MB"
    )


def _playing(app: App) -> str:
    found, _, cpu = _pages(app, PLAYING, SECONDS, "play")
    rate = np.mean(found["messages"]) / SECONDS
    return (
        f"  {PLAYING} playing: {cpu / PLAYING:.4f} of a core a page, "
        f"{rate:.2f} messages a second a page"
    )


def _pages(
    app: App, pages: int, seconds: float, motion: str
) -> tuple[dict[str, list[list[float]]], int, float]:
    """What the pages saw, the server's memory while they were there, and the cores that it used."""
    clients = Path(__file__).with_name("page_clients.py")
    with subprocess.Popen(
        [sys.executable, clients, app.url, str(pages), str(seconds), motion],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as running:
        assert running.stdin is not None
        assert running.stdout is not None
        assert running.stdout.readline() == "ready\n"
        used, began = time.process_time(), time.perf_counter()
        running.stdin.write("go\n")
        running.stdin.flush()
        time.sleep(seconds / 2)
        memory = _memory()
        found = json.loads(running.stdout.readline())
        cpu = (time.process_time() - used) / (time.perf_counter() - began)
    deadline = time.monotonic() + 10
    while app.sessions and time.monotonic() < deadline:
        time.sleep(0.05)
    return found, memory, cpu


def _memory() -> int:
    """Bytes of this process that are in memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE")
