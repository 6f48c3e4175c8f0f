"""Pages that drag at the same time: how long a motion takes to come."""

from __future__ import annotations

import time

import numpy as np
import torch
from pages import FRAMES, Drag, Pages
from timing import best_of

from rnnpb_explorer.app.state.document import target_of_motion
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion

RATE = 20.0  # wishes a second of each page: a motion and a landscape
SECONDS = 5.0


def run(model: RNNPB) -> str:
    alone = best_of(lambda: model.generate(model.mu[:1], FRAMES))
    lines = [
        f"Pages that drag, {RATE:g} motions of {FRAMES} frames and landscapes a second each",
        f"  {'pages':>7}{'median':>11}{'95 %':>11}{'motions of one alone':>24}"
        f"{'motions/s':>12}{'coarse/s':>11}",
    ]
    for count in (1, 4, 16):
        drags = drag(model, count)
        median, late = np.percentile([lag for one in drags for lag in one.lags], (50, 95))
        motions = sum(len(one.arrived) for one in drags) / SECONDS / count
        coarse = sum(one.coarse for one in drags) / SECONDS / count
        lines.append(
            f"  {count:7}{1e3 * median:8.1f} ms{1e3 * late:8.1f} ms"
            f"{median / alone:14.1f}{late / alone:10.1f}{motions:12.1f}{coarse:11.1f}"
        )
    lines.append(
        f"  one motion alone, {torch.get_num_threads()} threads: {1e3 * alone:.1f} ms; "
        "rates are of one page"
    )
    return "\n".join(lines)


def drag(model: RNNPB, count: int) -> list[Drag]:
    """So many pages that want something new at every tick, one after the other within it."""
    pages = Pages(model, rest_seconds=0.15)
    target = model.generate(model.mu[:1], FRAMES)[0].numpy()
    given = target_of_motion(Motion("given", model.info.joints, target))
    drags = [Drag() for _ in range(count)]
    handles = [pages.engine.open(one.take) for one in drags]
    start = time.perf_counter()
    for tick in range(int(SECONDS * RATE * count)):
        number, page = divmod(tick, count)
        time.sleep(max(0.0, start + tick / (RATE * count) - time.perf_counter()))
        motion = pages.motion(number, page)
        drags[page].numbers[motion] = number
        drags[page].asked.append(time.perf_counter())
        landscape = pages.landscape(number, given, page)
        handles[page].want({("motion", 0): motion, ("landscape", 0): landscape})
    time.sleep(1.0)
    pages.close()
    return drags
