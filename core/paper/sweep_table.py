"""Table I of the paper, collected from the finished cells of a sweep."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from .sweep import Cell, Result


@dataclass(frozen=True)
class Entry:
    """One entry of Table I: a condition and a D_PB, over all seeds."""

    condition: str
    pb_dim: int
    mean: float | None  # over seeds, motions and samples; None: nothing is finished
    sd: float | None  # over seeds, motions and samples: for one seed what the paper prints
    sd_over_seeds: float | None  # sample standard deviation of the cells' means
    finished: tuple[int, ...]  # seeds
    failed: tuple[int, ...]
    missing: tuple[int, ...]


def table(
    cells: Sequence[Cell], results: Mapping[Cell, Result], failed: Iterable[Cell] = ()
) -> list[Entry]:
    """Table I over these cells, in the order in which they come."""
    failed = set(failed) - set(results)
    pairs = dict.fromkeys((cell.condition, cell.pb_dim) for cell in cells)
    return [
        _entry([c for c in cells if (c.condition, c.pb_dim) == pair], results, failed)
        for pair in pairs
    ]


def _entry(cells: Sequence[Cell], results: Mapping[Cell, Result], failed: set[Cell]) -> Entry:
    found = [results[cell] for cell in cells if cell in results]
    mean = sd = spread = None
    if found:
        mean = math.fsum(result.mean for result in found) / len(found)
        squares = math.fsum((result.mean - mean) ** 2 for result in found)
        # Every cell has as many samples: the variance of them all is within cells plus between.
        sd = math.sqrt((math.fsum(result.sd**2 for result in found) + squares) / len(found))
        spread = math.sqrt(squares / (len(found) - 1)) if len(found) > 1 else None
    return Entry(
        condition=cells[0].condition,
        pb_dim=cells[0].pb_dim,
        mean=mean,
        sd=sd,
        sd_over_seeds=spread,
        finished=tuple(cell.seed for cell in cells if cell in results),
        failed=tuple(cell.seed for cell in cells if cell in failed),
        missing=tuple(c.seed for c in cells if c not in results and c not in failed),
    )
