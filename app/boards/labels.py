"""Names beside points, none over another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .palette import LABEL, PLOT, TEXT
from .plot import Area
from .raster import Canvas, shorten, text_width

LABEL_SIZE = 28.0  # design pixels
WIDEST = 340.0
Box = tuple[float, float, float, float]  # left, top, right, bottom


@dataclass(frozen=True)
class Label:
    """A name wanted beside the point at (x, y) in pixels."""

    index: int  # of the point
    x: float
    y: float
    text: str
    strong: bool = False  # bold, and set in any case
    radius: float = 12.0  # of the point's mark, kept free


def place_labels(
    area: Area, labels: Iterable[Label], avoid: NDArray[np.float64]
) -> list[tuple[Label, Box]]:
    """Find a place for each name, first come first served; one that finds none is left out.

    Args:
        avoid: (N, 2) pixels of marks that names keep clear of where they can.
    """
    size = area.scaled(LABEL_SIZE)
    placed: list[tuple[Label, Box]] = []
    for label in labels:
        width = text_width(_text(area, label), size, bold=label.strong)
        box = _free_place(area, label, width, size, [box for _, box in placed], avoid)
        if box is not None:
            placed.append((label, box))
    return placed


def draw_labels(canvas: Canvas, area: Area, placed: Sequence[tuple[Label, Box]]) -> None:
    """Set the names where `place_labels` put them."""
    size = area.scaled(LABEL_SIZE)
    for label, (left, _, _, bottom) in placed:
        color, baseline = (TEXT if label.strong else LABEL), bottom - size * 0.26
        text = _text(area, label)
        canvas.text(left, baseline, text, size, color, bold=label.strong, halo=PLOT)


def _text(area: Area, label: Label) -> str:
    return shorten(label.text, area.scaled(LABEL_SIZE), area.scaled(WIDEST), bold=label.strong)


def _free_place(
    area: Area,
    label: Label,
    width: float,
    size: int,
    taken: Sequence[Box],
    avoid: NDArray[np.float64],
) -> Box | None:
    """The place around a point that covers the fewest marks and no other name."""
    gap, height, edge = label.radius + 0.3 * size, size * 1.12, 0.2 * size
    inside = (area.left + edge, area.top + edge, area.right - edge, area.bottom - edge)
    best: Box | None = None
    fewest = np.inf
    for rank, (left, top) in enumerate(_places(label, gap, width, height)):
        box = (left, top, left + width, top + height)
        if left < inside[0] or top < inside[1] or box[2] > inside[2] or box[3] > inside[3]:
            continue
        if any(_overlap(box, other) for other in taken):
            continue
        x, y = avoid[:, 0], avoid[:, 1]
        covered = (x > left - 4) & (x < box[2] + 4) & (y > top - 4) & (y < box[3] + 4)
        cost = covered.sum() + 0.3 * rank
        if cost < fewest:
            best, fewest = box, cost
    if best is None and label.strong:
        left = min(max(label.x + gap, inside[0]), inside[2] - width)
        top = min(max(label.y - height / 2, inside[1]), inside[3] - height)
        best = (left, top, left + width, top + height)
    return best


def _places(label: Label, gap: float, width: float, height: float) -> list[tuple[float, float]]:
    """Left top corners around a point, the most readable first."""
    x, y, near = label.x, label.y, 0.6 * gap
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


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] + 6 and b[0] < a[2] + 6 and a[1] < b[3] and b[1] < a[3]
