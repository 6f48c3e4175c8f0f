"""What moves over a board: a recognition's path, the sigma ellipse, names of points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .palette import PATH, PATH_STRONG, PLOT, SAMPLE, SELECTED, TEXT, Color
from .plot import Area, PlotFrame
from .raster import Canvas, shorten, text_width

UNIT_RADIUS = 30.0  # design pixels of the circle for sigma = 1, the start of every recognition
LARGEST_RADIUS = 60.0
Box = tuple[float, float, float, float]  # left, top, right, bottom


@dataclass(frozen=True, eq=False)
class RecognitionPath:
    """One trial of a recognition in a board's coordinates (Figs. 5 and 6).

    mu: (I, 2), one more row for the state after the last iteration is welcome; (I, 1) where D = 1.
    sigma: (I, D) of the same iterations; a circle's radius goes with the root mean square over D.
    pb: (up to I, 2), the PB sampled at each iteration.
    current: the iteration to draw up to; None draws all, and marks the end.
    """

    mu: NDArray[np.floating]
    sigma: NDArray[np.floating]
    pb: NDArray[np.floating] | None = None
    current: int | None = None


def as_points(values: ArrayLike) -> NDArray[np.float64]:
    """(N, 2) from (N, 2), (N, 1) or (N,); a missing second coordinate is 0."""
    points = np.asarray(values, dtype=np.float64)
    points = points.reshape(len(points), -1) if points.size else points.reshape(0, 2)
    if points.shape[1] == 1:
        points = np.concatenate([points, np.zeros_like(points)], axis=1)
    return points[:, :2]


def draw_path(canvas: Canvas, area: Area, frame: PlotFrame, path: RecognitionPath) -> None:
    """The path up to its current iteration over whatever the board shows."""
    mu = frame.to_pixels(as_points(path.mu), area.size)
    if not len(mu):
        return
    last = len(mu) - 1
    now = last if path.current is None else int(np.clip(path.current, 0, last))
    scale = area.size / 1024
    sigma = np.asarray(path.sigma, dtype=np.float64).reshape(len(path.sigma), -1)
    radius = np.zeros(len(mu))
    spread = np.sqrt(np.square(sigma).mean(axis=1)) if sigma.size else np.zeros(0)
    known = min(len(spread), len(mu))
    radius[:known] = np.clip(spread[:known] * UNIT_RADIUS, 0, LARGEST_RADIUS) * scale

    line = max(1.5, 3.0 * scale)
    if now < last:  # what is still to come, for the hand on the scrubber
        canvas.line(mu[now:], PATH, line * 0.8, alpha=0.25)
    if path.pb is not None and len(path.pb):
        pb = frame.to_pixels(as_points(path.pb), area.size)[: now + 1]
        _draw_samples(canvas, pb, scale)
    done = mu[: now + 1]
    age = np.linspace(0.16, 0.42, len(done)) if len(done) > 1 else np.array([0.42])
    canvas.markers(done, radius[: now + 1], PATH, alpha=age * min(1.0, 45 / len(done)) ** 0.35)
    canvas.line(done, PLOT, line + 4 * scale, alpha=0.55)
    canvas.line(done, PATH, line, alpha=0.95)
    dots = max(2.0, 3.6 * scale)
    canvas.markers(done, dots, PATH_STRONG)
    _draw_ends(canvas, mu, now, float(radius[now]), scale)


def _draw_samples(canvas: Canvas, pb: NDArray[np.float64], scale: float) -> None:
    canvas.markers(
        pb,
        max(4.0, 9.5 * scale),
        SAMPLE,
        shapes="cross",
        alpha=0.85,
        edge=PLOT,
        edge_width=1.5 * scale,
        edge_alpha=0.6,
    )


def _draw_ends(
    canvas: Canvas, mu: NDArray[np.float64], now: int, radius: float, scale: float
) -> None:
    """Dot at the start; cross at the end, or a ring where the scrubber stands."""
    edge = {"edge": PLOT, "edge_width": 3.0 * scale}
    canvas.markers(mu[:1], 11 * scale, (232, 28, 40), **edge)  # type: ignore[arg-type]
    if now == len(mu) - 1:
        canvas.markers(mu[now:], 19 * scale, (232, 28, 40), shapes="plus", **edge)  # type: ignore[arg-type]
        return
    ring = np.linspace(0, 2 * np.pi, 49)
    reach = max(radius, 13 * scale)
    around = mu[now] + reach * np.stack([np.cos(ring), np.sin(ring)], axis=1)
    canvas.line(around, PLOT, 7 * scale, alpha=0.8)
    canvas.line(around, PATH_STRONG, 4 * scale)
    canvas.markers(mu[now : now + 1], 9 * scale, (232, 28, 40), **edge)  # type: ignore[arg-type]


def draw_ellipse(
    canvas: Canvas, area: Area, frame: PlotFrame, center: ArrayLike, covariance: ArrayLike
) -> None:
    """One and two standard deviations of a Gaussian; nothing where it is a point (sigma = 0)."""
    spread = np.zeros((2, 2))
    given = np.atleast_2d(np.asarray(covariance, dtype=np.float64))
    spread[: len(given), : len(given)] = given
    origin, unit_x, unit_y = frame.to_pixels(
        np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), area.size
    )
    to_pixels = np.stack([unit_x - origin, unit_y - origin], axis=1)
    pixels = to_pixels @ spread @ to_pixels.T
    if not np.isfinite(pixels).all() or np.sqrt(np.trace(pixels)) < 2.0:
        return
    # A line (D = 1, or one sigma of 0) still gets a body of some pixels.
    body = np.eye(2) * (4 * area.size / 1024) ** 2
    middle = frame.to_pixels(as_points(np.atleast_2d(center))[0], area.size)
    width = max(1.2, 2.6 * area.size / 1024)
    for deviations, fill in ((2.0, 0.07), (1.0, 0.12)):
        shape = pixels * deviations**2 + body
        canvas.ellipse(middle, shape, SELECTED, fill=fill, width=width)


@dataclass(frozen=True)
class Label:
    """A name wanted beside a point, at (x, y) in pixels."""

    x: float
    y: float
    text: str
    strong: bool = False
    radius: float = 12.0  # of the point's mark, kept free


def draw_labels(
    canvas: Canvas, area: Area, labels: Iterable[Label], avoid: NDArray[np.float64]
) -> list[Box]:
    """Set names beside their points, first come first served, none over another.

    A name with no free place is left out, except the strong ones. Returns the boxes that were set.

    Args:
        avoid: (N, 2) pixels that names keep clear of where they can.
    """
    size = area.scaled(28)
    taken: list[Box] = []
    for label in labels:
        text = shorten(label.text, size, area.scaled(330), bold=label.strong)
        width = text_width(text, size, bold=label.strong)
        place = _free_place(area, label, width, size, taken, avoid)
        if place is None:
            continue
        taken.append(place)
        color: Color = TEXT if label.strong else (66, 75, 88)
        baseline = place[3] - size * 0.26
        canvas.text(place[0], baseline, text, size, color, bold=label.strong, halo=PLOT)
    return taken


def _free_place(
    area: Area,
    label: Label,
    width: float,
    size: int,
    taken: Sequence[Box],
    avoid: NDArray[np.float64],
) -> Box | None:
    """The place around a point that covers the fewest marks and no other name."""
    gap, height = label.radius + 0.3 * size, size * 1.12
    diagonal = 0.7 * gap
    places = (
        (label.x + gap, label.y - height / 2),
        (label.x - gap - width, label.y - height / 2),
        (label.x - width / 2, label.y - gap - height),
        (label.x - width / 2, label.y + gap),
        (label.x + diagonal, label.y - diagonal - height),
        (label.x + diagonal, label.y + diagonal),
        (label.x - diagonal - width, label.y - diagonal - height),
        (label.x - diagonal - width, label.y + diagonal),
    )
    best: Box | None = None
    fewest = np.inf
    edge = 0.2 * size
    for rank, (left, top) in enumerate(places):
        box = (left, top, left + width, top + height)
        outside = (
            left < area.left + edge
            or top < area.top + edge
            or box[2] > area.right - edge
            or box[3] > area.bottom - edge
        )
        if outside or any(_overlap(box, other) for other in taken):
            continue
        x, y = avoid[:, 0], avoid[:, 1]
        covered = int(((x > left - 4) & (x < box[2] + 4) & (y > top - 4) & (y < box[3] + 4)).sum())
        if covered + 0.1 * rank < fewest:
            best, fewest = box, covered + 0.1 * rank
    if best is None and label.strong:
        left = float(np.clip(label.x + gap, area.left + edge, area.right - edge - width))
        top = float(np.clip(label.y - height / 2, area.top + edge, area.bottom - edge - height))
        best = (left, top, left + width, top + height)
    return best


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] + 6 and b[0] < a[2] + 6 and a[1] < b[3] and b[1] < a[3]
