"""How the benchmarks measure and print: always two ways of the same work, in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable

import torch

from rnnpb_explorer.core.model import RNNPB

# What torch and oneDNN may use at most, for a process that starts with it: as most laptops.
AVX2 = {"ONEDNN_MAX_CPU_ISA": "AVX2", "ATEN_CPU_CAPABILITY": "avx2"}


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
    """Rows of work, each done two ways, and the ratio of their times, with what it should be."""

    def __init__(self, title: str, plain: str, quick: str) -> None:
        self._lines = [title, f"  {'':34}{plain:>18}{quick:>18}{'ratio':>8}"]

    def row(self, work: str, plain: float, quick: float, aim: float | None = None) -> None:
        milliseconds = f"{1e3 * plain:15.1f} ms{1e3 * quick:15.1f} ms"
        wanted = "" if aim is None else f"  (aim {aim:g})"
        self._lines.append(f"  {work:34}{milliseconds}{plain / quick:8.1f}{wanted}")

    def limit(self, work: str, quick: float, bare: float) -> None:
        """Beside what the machine needs for the matrix products alone."""
        self._lines.append(
            f"  {work}: its matrix products alone {1e3 * bare:.1f} ms; ratio {quick / bare:.2f}"
        )

    def note(self, text: str) -> None:
        self._lines.append(f"  {text}")

    def __str__(self) -> str:
        return "\n".join(self._lines)


def bare_products(model: RNNPB, motions: int, steps: int) -> Callable[[], None]:
    """What one way through the network cannot do without: a product a frame, and nothing else.

    A gradient takes two more of them a frame.
    """
    hidden = model.config.hidden_size
    states, weight = torch.randn(motions, hidden), torch.randn(hidden, 4 * hidden)
    out = torch.empty(motions, 4 * hidden)

    def products() -> None:
        for _ in range(steps):
            torch.mm(states, weight, out=out)

    return products


def step_by_step(model: RNNPB, motion: int) -> tuple[float, str]:
    """Seconds for a learned motion as eqs. 6 to 8 stand, alone on the machine; and a line on it."""
    steps = model.info.lengths[motion]
    with torch.inference_mode():
        pb = model.mu[motion][None]
        seconds = best_of(lambda: model.generate_stepwise(pb, steps))
    return seconds, f"  one motion of {steps} frames step by step, alone: {1e3 * seconds:.1f} ms"
