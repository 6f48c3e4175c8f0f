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

SECONDS = 10.0
# Pages that drag, play, follow; what the 95th percentile from hand to motion should stay below.
CLASSES = ((1, 0, 0, None), (4, 0, 0, None), (16, 0, 0, 200), (8, 32, 0, 250), (1, 30, 0, None),
           (1, 0, 30, None))  # fmt: skip


def run(model: RNNPB) -> str:
    app = start(ServerOptions(port=0))
    lines = [f"Pages at once, {os.cpu_count()} cores for the server and its pages together"]
    try:
        motion = app.opening.models[0].latent.motion
        plain, line = step_by_step(model, motion)
        lines.append(line)
        _pages(app, 1.0, motion, 0, 1, 0)  # the first page pays for what all share
        for dragging, playing, following, aim in CLASSES:
            lines += _class(app, motion, plain, (dragging, playing, following), aim)
        lines.append(_playing(app, motion))
    finally:
        app.stop()
    return "\n".join(lines)


def _class(
    app: App, motion: int, plain: float, pages: tuple[int, int, int], aim: int | None
) -> list[str]:
    before = _memory()
    found, during, cpu = _pages(app, SECONDS, motion, *pages)
    after = _memory()
    dragging, playing, following = pages
    latencies = np.concatenate([np.array(page) for page in found["latencies"]])
    medians = [float(np.median(page)) for page in found["latencies"]]
    median, p95 = np.percentile(latencies, [50, 95])
    moves = dragging * SECONDS / 0.05
    landscapes = np.array(found["landscapes"]) / SECONDS
    wanted = "" if aim is None else f" (aim: below {aim})"
    beside = f" beside {playing} playing" if playing else ""
    beside += f", followed by {following}" if following else ""
    return [
        f"  {dragging:2} dragging at 20 Hz{beside}: median {median:.0f} ms "
        f"({median / 1e3 / plain:.1f} x), 95th percentile {p95:.0f} ms{wanted} "
        f"({p95 / 1e3 / plain:.1f} x); {len(latencies) / moves:.0%} of the moves seen",
        f"     slowest page {max(medians) / np.median(medians):.2f} of the median one; landscapes "
        f"{np.median(landscapes):.1f} a second a page, fewest {landscapes.min():.1f}; {cpu:.2f} "
        f"cores; memory a page {(during - before) / sum(pages) / 1e6:.1f} MB, after they left "
        f"{(after - before) / 1e6:+.0f} MB",
    ]


def _playing(app: App, motion: int) -> str:
    pages = 32
    found, _, cpu = _pages(app, SECONDS, motion, 0, pages, 0)
    rate = np.mean(found["messages"]) / SECONDS
    each = cpu / pages
    return f"  {pages} playing: {each:.4f} of a core a page, {rate:.2f} messages a second a page"


def _pages(
    app: App, seconds: float, motion: int, dragging: int, playing: int, following: int
) -> tuple[dict[str, list[list[float]]], int, float]:
    """What the pages saw, the server's memory while they were there, and the cores that it used."""
    numbers = (seconds, motion, dragging, playing, following)
    clients = Path(__file__).with_name("page_clients.py")
    with subprocess.Popen(
        [sys.executable, clients, app.url, *map(str, numbers)],
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
