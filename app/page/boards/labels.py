"""Names beside points, none over another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .masks import shorten, text_width
from .palette import AXIS, LABEL, PLOT, QUIET, TEXT, Color
from .plot import Area
from .raster import Canvas

LABEL_SIZE = 31.0  # design pixels
WIDEST = 370.0
PUCK_RADIUS = 34.0  # design pixels around the puck, which others draw, that names keep free
# strong: bold, and set in any case; quiet: pale, and only where it covers no mark
Weight = Literal["strong", "plain", "quiet"]
COLORS: dict[Weight, Color] = {"strong": TEXT, "plain": LABEL, "quiet": QUIET}
Box = tuple[float, float, float, float]  # left, top, right, bottom


@dataclass(frozen=True)
class Label:
    """A name wanted for a point, given by its index."""

    point: int
    text: str
    weight: Weight = "plain"

    @property
    def bold(self) -> bool:
        return self.weight == "strong"


@dataclass(frozen=True)
class Placed:
    """A name, the box that it takes, and the (x, y) in pixels that it belongs to."""

    label: Label
    box: Box
    at: tuple[float, float]
    leader: bool  # a line joins the two


def place_labels(
    area: Area,
    labels: Iterable[Label],
    pixels: NDArray[np.float64],
    radius: NDArray[np.float64],
    *,
    puck: NDArray[np.float64] | None = None,
    on_a_line: bool = False,
) -> list[Placed]:
    """Find a place for each name, first come first served; one that finds none is left out.

    Args:
        pixels: (N, 2) all points; names cover as few of them as they can.
        radius: (N,) pixels, of their marks.
        puck: (2,) pixels; hides what is under it, so names stay clear, and the names of points that
            it hides stand beside it.
        on_a_line: all points lie on one horizontal line, so names go below and above it.
    """
    size = area.scaled(LABEL_SIZE)
    reach = PUCK_RADIUS * area.scale
    marks = (pixels[:, 0].copy(), pixels[:, 1].copy())
    taken: list[Box] = []
    if puck is not None:
        (x, y), half = puck.tolist(), 0.85 * reach
        taken.append((x - half, y - half, x + half, y + half))
    placed: list[Placed] = []
    for label in labels:
        at, free = pixels[label.point], float(radius[label.point])
        if label.weight == "strong":
            free *= 1.5  # it has a ring
        if puck is not None and float(np.hypot(*(at - puck))) < reach:
            at, free = puck, reach
        x, y = at.tolist()
        width, height = text_width(_text(area, label), size, bold=label.bold), size * 1.12
        places = (_off_line if on_a_line else _around)(x, y, free + 0.3 * size, width, height)
        box = _free_place(area, places, width, height, taken, marks, label.weight)
        if box is not None:
            taken.append(box)
            placed.append(Placed(label, box, (x, y), on_a_line))
    return placed


def draw_labels(canvas: Canvas, area: Area, placed: Sequence[Placed]) -> None:
    """Set the names where `place_labels` put them."""
    size, half = area.scaled(LABEL_SIZE), area.scaled(3) / 2
    for one in placed:
        (x, y), (_, top, _, bottom) = one.at, one.box
        if one.leader:
            start, end = (y, top) if top > y else (bottom, y)
            canvas.rectangle(x - half, start, x + half, end, AXIS)
    for one in placed:
        label, (left, _, _, bottom) = one.label, one.box
        color, baseline = COLORS[label.weight], bottom - size * 0.26
        text = _text(area, label)
        halo = None if label.weight == "quiet" else PLOT
        canvas.text(left, baseline, text, size, color, bold=label.bold, halo=halo)


def _text(area: Area, label: Label) -> str:
    return shorten(label.text, area.scaled(LABEL_SIZE), area.scaled(WIDEST), bold=label.bold)


def _free_place(
    area: Area,
    places: Sequence[tuple[float, float]],
    width: float,
    height: float,
    taken: Sequence[Box],
    avoid: tuple[NDArray[np.float64], NDArray[np.float64]],
    weight: Weight,
) -> Box | None:
    """The place, given by its left top corner, that covers the fewest marks and nothing taken."""
    edge = area.scaled(6)
    low_x, low_y = area.left + edge, area.top + edge
    high_x, high_y = area.right - edge - width, area.bottom - edge - height
    x, y = avoid
    best, fewest = None, np.inf
    for rank, (left, top) in enumerate(places):
        if not (low_x <= left <= high_x and low_y <= top <= high_y):
            continue
        right, bottom = left + width, top + height
        if any(
            left < x1 + 6 and x0 - 6 < right and top < y1 and y0 < bottom
            for x0, y0, x1, y1 in taken
        ):
            continue
        over = (x > left - 4) & (x < right + 4) & (y > top - 4) & (y < bottom + 4)
        covered = int(np.count_nonzero(over))
        if covered + 0.3 * rank < fewest and not (covered and weight == "quiet"):
            best, fewest = (left, top, right, bottom), covered + 0.3 * rank
        if not covered:  # every later place costs more
            break
    if best is None and weight == "strong":
        left = max(min(places[0][0], high_x), low_x)
        top = max(min(places[0][1], high_y), low_y)
        best = (left, top, left + width, top + height)
    return best


def _around(
    x: float, y: float, gap: float, width: float, height: float
) -> list[tuple[float, float]]:
    """Left top corners around a point, the most readable first."""
    near = 0.6 * gap
    return [
        (x + gap, y - height / 2),
        (x - gap - width, y - height / 2),
        (x - width / 2, y - gap - height),
        (x - width / 2, y + gap),
        (x + near, y - near - height),
        (x + near, y + near),
        (x - near - width, y - near - height),
        (x - near - width, y + near),
    ]


def _off_line(
    x: float, y: float, gap: float, width: float, height: float
) -> list[tuple[float, float]]:
    """Left top corners below the line, row by row, then above it."""
    rows = [(gap + 0.5 * height) + 1.35 * height * row for row in range(6)]
    starts = [x - width / 2, x - 0.15 * width, x - 0.85 * width]
    below = [(start, y + row) for row in rows for start in starts]
    above = [(start, y - row - height) for row in rows for start in starts]
    return below + above
