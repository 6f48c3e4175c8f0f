"""From a hand on a board to the new motion in a real browser, one page, rendered in software.

Server and browser share the cores. The plain way beside it is the motion generated step by step as
in eqs. 6 to 8, alone on the machine.
"""

from __future__ import annotations

import os
from typing import Literal

import numpy as np
from playwright.sync_api import Page
from timing import step_by_step

from rnnpb_explorer.app.commands.photograph import chromium, wait_until_ready
from rnnpb_explorer.app.page.server import ServerOptions, start
from rnnpb_explorer.core.model import RNNPB

Board = Literal["map", "landscape"]
MOVES = 60
# A hand on the landscape leaves it as it is; one on the map has it computed anew.
WHERE: dict[Board, str] = {"landscape": "at rest", "map": "following"}
SIZE = {"width": 1280, "height": 720}

# Notes when the pointer moved, and when the motion that followed was there.
_WATCH = """() => {
    const { playback } = window.rnnpb.part;
    const show = playback.showMotion.bind(playback);
    window.hand = { moved: 0, took: [] };
    addEventListener("pointermove", (event) => { window.hand.moved = event.timeStamp; }, true);
    playback.showMotion = (shown) => {
        show(shown);
        if (!window.hand.moved) return;
        window.hand.took.push(performance.now() - window.hand.moved);
        window.hand.moved = 0;
    };
}"""
_PUCK = """(name) => {
    const board = window.rnnpb.part[name], { view, parts, puck } = board;
    const { extent, box } = view, at = parts.plot.getBoundingClientRect();
    return [
        at.x + box.left + (puck[0] - extent.left) / (extent.right - extent.left) * box.width,
        at.y + box.top + (extent.top - puck[1]) / (extent.top - extent.bottom) * box.height,
    ];
}"""
_SEEN = "(count) => window.hand.took.length >= count"


def run(model: RNNPB) -> str:
    app = start(ServerOptions(port=0))
    try:
        plain, line = step_by_step(model, app.opening.models[0].latent.motion)
        lines = [
            f"Hand to motion in a browser, {os.cpu_count()} cores for it and the server together",
            line,
        ]
        with chromium() as browser:
            page = browser.new_page(viewport=SIZE)
            page.goto(app.url)
            wait_until_ready(page)
            page.evaluate(_WATCH)
            for board, words in WHERE.items():
                took = _drag(page, board)
                median, p95 = np.percentile(took, [50, 95])
                lines.append(
                    f"  the landscape {words}: median {median:.0f} ms "
                    f"({median / 1e3 / plain:.1f} x), 95th percentile {p95:.0f} ms"
                )
    finally:
        app.stop()
    return "\n".join(lines)


def _drag(page: Page, board: Board) -> list[float]:
    """Milliseconds of each move, the next one as soon as the last has its motion.

    On the landscape only what the landscape spans moves, which leaves it as it is; on the map all
    else does, and it is computed anew.
    """
    x, y = page.evaluate(_PUCK, board)
    page.evaluate("() => { window.hand.took = []; window.hand.moved = 0; }")
    page.mouse.move(x, y)
    page.mouse.down()
    for move in range(1, MOVES + 1):
        page.mouse.move(x + 10 * np.sin(move / 5), y + 10 * np.cos(move / 5) - 10)
        page.wait_for_function(_SEEN, arg=move, polling=2)
    page.mouse.up()
    took: list[float] = page.evaluate("() => window.hand.took")
    return took
