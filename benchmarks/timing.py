"""How the benchmarks measure and print: always two ways of the same work, in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable

import torch

from rnnpb_explorer.core.model import RNNPB


def best_of(work: Callable[[], object], budget: float = 2.0, at_least: int = 3) -> float:
    """Seconds of the fastest run after a first one that does not count; others only add noise."""
    work()
    times: list[float] = []
    while len(times) < at_least or sum(times) < budget:
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


class Table:
    """Rows of work, each done two ways, and the ratio of their times."""

    def __init__(self, title: str, plain: str, quick: str) -> None:
        self._lines = [title, f"  {'':34}{plain:>18}{quick:>18}{'ratio':>8}"]

    def row(self, work: str, plain: float, quick: float) -> None:
        milliseconds = f"{1e3 * plain:15.1f} ms{1e3 * quick:15.1f} ms"
        self._lines.append(f"  {work:34}{milliseconds}{plain / quick:8.1f}")

    def note(self, text: str) -> None:
        self._lines.append(f"  {text}")

    def __str__(self) -> str:
        return "\n".join(self._lines)


def step_by_step(model: RNNPB, motion: int) -> tuple[float, str]:
    """Seconds for a learned motion as eqs. 6 to 8 stand, alone on the machine; and a line on it."""
    steps = model.info.lengths[motion]
    with torch.inference_mode():
        pb = model.mu[motion][None]
        seconds = best_of(lambda: model.generate_stepwise(pb, steps))
    return seconds, f"  one motion of {steps} frames step by step, alone: {1e3 * seconds:.1f} ms"
