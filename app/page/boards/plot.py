"""What both boards are made of: where data lies on the picture, axes, title, marks of state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from .masks import shorten, text_width
from .palette import AXIS, BOARD, FRAME, GRID, MUTED, PLOT, TEXT, ZERO_LINE, Color
from .raster import Canvas

Range = tuple[float, float]
DESIGN_SIZE = 1024  # pixels; every length is given for a board of this size
# Sizes of type. A board takes some 320 pixels of a 1280x720 screen, so these become 10 to 14.
SMALL, TICK, AXIS_LABEL = 31.0, 33.0, 38.0


def as_points(values: ArrayLike) -> NDArray[np.float64]:
    """(N, 2) from (N, 2), (N, 1) or (N,); a missing second coordinate is 0."""
    points = np.asarray(values, dtype=np.float64)
    points = points.reshape(len(points), -1) if points.size else points.reshape(0, 2)
    if points.shape[1] == 1:
        points = np.concatenate([points, np.zeros_like(points)], axis=1)
    return points[:, :2]


@dataclass(frozen=True)
class PlotFrame:
    """The affine map between data coordinates and a board's picture, and back.

    x_range, y_range: the data at the plot area's left and right, bottom and top edge (low < high).
    left, top, right, bottom: that area on the picture, in (u, v) from (0, 0) at its left top corner
        to (1, 1) at its right bottom one, whatever its size in pixels or metres.
    """

    x_range: Range
    y_range: Range
    left: float
    top: float
    right: float
    bottom: float

    def to_uv(self, xy: ArrayLike) -> NDArray[np.float64]:
        """(..., 2) data coordinates -> (..., 2) picture coordinates (u, v)."""
        at = np.asarray(xy, dtype=np.float64)
        (x0, x1), (y0, y1) = self.x_range, self.y_range
        u = self.left + (at[..., 0] - x0) / (x1 - x0) * (self.right - self.left)
        v = self.bottom + (at[..., 1] - y0) / (y1 - y0) * (self.top - self.bottom)
        return np.stack([u, v], axis=-1)

    def to_data(self, uv: ArrayLike) -> NDArray[np.float64]:
        """(..., 2) picture coordinates (u, v) -> (..., 2) data coordinates, beyond the area too."""
        at = np.asarray(uv, dtype=np.float64)
        (x0, x1), (y0, y1) = self.x_range, self.y_range
        x = x0 + (at[..., 0] - self.left) / (self.right - self.left) * (x1 - x0)
        y = y0 + (at[..., 1] - self.bottom) / (self.top - self.bottom) * (y1 - y0)
        return np.stack([x, y], axis=-1)

    def to_board(
        self, xy: ArrayLike, width: float = 1.0, height: float = 1.0
    ) -> NDArray[np.float64]:
        """(..., 2) data -> (..., 2) metres right of and above a width x height board's centre."""
        uv = self.to_uv(xy)
        return np.stack([(uv[..., 0] - 0.5) * width, (0.5 - uv[..., 1]) * height], axis=-1)

    def from_board(
        self, at: ArrayLike, width: float = 1.0, height: float = 1.0
    ) -> NDArray[np.float64]:
        """The way back from `to_board`."""
        position = np.asarray(at, dtype=np.float64)
        return self.to_data(
            np.stack([position[..., 0] / width + 0.5, 0.5 - position[..., 1] / height], axis=-1)
        )

    def clamp(self, xy: ArrayLike) -> NDArray[np.float64]:
        """(..., 2) data coordinates moved into the plot area: where a puck may be dragged."""
        low = [self.x_range[0], self.y_range[0]]
        high = [self.x_range[1], self.y_range[1]]
        return np.clip(np.asarray(xy, dtype=np.float64), low, high)

    def contains(self, xy: ArrayLike) -> NDArray[np.bool_]:
        """(...) is it inside the plot area, edges included?"""
        at = np.asarray(xy, dtype=np.float64)
        inside_x = (at[..., 0] >= self.x_range[0]) & (at[..., 0] <= self.x_range[1])
        return inside_x & (at[..., 1] >= self.y_range[0]) & (at[..., 1] <= self.y_range[1])

    def to_pixels(self, xy: ArrayLike, size: int) -> NDArray[np.float64]:
        """(..., 2) data -> (..., 2) pixels of a size x size picture; pixel i covers [i, i + 1)."""
        return self.to_uv(xy) * size


class Board(NamedTuple):
    """A board's picture, (size, size, 3) uint8, and where data lies on it."""

    picture: NDArray[np.uint8]
    frame: PlotFrame


@dataclass(frozen=True)
class Area:
    """A plot area in whole pixels of a size x size picture."""

    left: int
    top: int
    right: int
    bottom: int
    size: int

    def frame(self, x_range: Range, y_range: Range) -> PlotFrame:
        edges = (value / self.size for value in (self.left, self.top, self.right, self.bottom))
        return PlotFrame(x_range, y_range, *edges)

    @property
    def scale(self) -> float:
        """Pixels of this picture that one of the 1024-pixel design takes."""
        return self.size / DESIGN_SIZE

    def scaled(self, length: float) -> int:
        """A length of the 1024-pixel design in this picture's pixels."""
        return max(1, round(length * self.size / DESIGN_SIZE))


def area_of(frame: PlotFrame, size: int) -> Area:
    """The whole pixels that a frame's plot area covers."""
    edges = (frame.left, frame.top, frame.right, frame.bottom)
    left, top, right, bottom = (round(edge * size) for edge in edges)
    return Area(left, top, right, bottom, size)


def nice_ticks(low: float, high: float, most: int = 6) -> list[tuple[float, str]]:
    """Round values inside [low, high] with their labels, at most about `most` of them."""
    if not (math.isfinite(low) and math.isfinite(high) and high > low):
        return []
    raw = (high - low) / most
    magnitude = 10.0 ** math.floor(math.log10(raw))
    step = next(m for m in (1, 2, 5, 10) if m * magnitude >= raw * 0.999) * magnitude
    slack = step * 1e-6
    first, last = math.ceil((low - slack) / step), math.floor((high + slack) / step)
    if last - first > 50:  # a window so far from 0 that floats cannot tell its ticks apart
        return []
    largest = max(abs(low), abs(high))
    last_place = math.floor(math.log10(step) + 1e-9)
    decimals = max(0, -last_place)
    digits = max(1, math.floor(math.log10(largest) + 1e-9) - last_place + 1)
    form = f".{decimals}f" if 1e-3 <= largest < 1e5 else f".{digits}g"
    return [(i * step, tick_label(i * step, form)) for i in range(first, last + 1)]


def tick_label(value: float, form: str) -> str:
    """A number as it stands on an axis, with a true minus sign and no negative zero."""
    text = format(value, form)
    return text.lstrip("-") if float(text) == 0 else text.replace("-", "−")


def new_board(size: int) -> Canvas:
    """An empty board: light, in a thin dark frame whose inner corners are round."""
    canvas = Canvas(Image.new("RGB", (size, size), FRAME))
    rim = max(2, round(size * 7 / DESIGN_SIZE))
    canvas.rounded(rim, rim, size - rim, size - rim, size * 12 / DESIGN_SIZE, BOARD)
    return canvas


def draw_header(
    canvas: Canvas, area: Area, title: str, subtitle: str, rooms: tuple[float, float]
) -> None:
    """Title and a line below it, each in at most its room, in design pixels."""
    k = area.scaled
    title = shorten(title, k(46), k(rooms[0]), bold=True)
    canvas.text(k(44), k(76), title, k(46), TEXT, bold=True)
    canvas.text(k(44), k(124), shorten(subtitle, k(SMALL), k(rooms[1])), k(SMALL), MUTED)


def draw_chip(
    canvas: Canvas, area: Area, text: str, ink: Color, fill: Color, *, right: int, middle: int
) -> None:
    """A word on a coloured lozenge: a state or a warning."""
    k = area.scaled
    size, pad, half = k(SMALL), k(20), k(27)
    left = right - text_width(text, size, bold=True) - 2 * pad
    canvas.rounded(left, middle - half, right, middle + half, half, fill)
    canvas.text(left + pad, middle + k(11), text, size, ink, bold=True)


def draw_axes(
    canvas: Canvas,
    area: Area,
    frame: PlotFrame,
    *,
    x_label: str,
    y_label: str | None,
    grid: bool = True,
) -> None:
    """Ticks with their values, labels, grid lines; `y_label` None: there is no second axis."""
    k = area.scaled
    if grid:
        canvas.rectangle(area.left, area.top, area.right, area.bottom, PLOT)
    text, gap, tick = k(TICK), k(11), k(8)
    baseline = area.bottom + tick + gap + k(25)
    line = k(2)
    for value, label in nice_ticks(*frame.x_range, most=6):
        x = frame.to_pixels([value, 0.0], area.size)[0] - line / 2
        if grid:
            color = ZERO_LINE if value == 0 else GRID
            canvas.rectangle(x, area.top, x + line, area.bottom, color)
        canvas.rectangle(x, area.bottom, x + line, area.bottom + tick, AXIS)
        canvas.text(x, baseline, label, text, MUTED, anchor="middle")
    label = shorten(x_label, k(AXIS_LABEL), area.right - area.left, bold=True)
    middle = (area.left + area.right) / 2
    canvas.text(middle, baseline + k(45), label, k(AXIS_LABEL), TEXT, bold=True, anchor="middle")
    if y_label is not None:
        _draw_y_axis(canvas, area, frame, y_label, grid=grid)
    draw_border(canvas, area, AXIS, -line)


def _draw_y_axis(canvas: Canvas, area: Area, frame: PlotFrame, y_label: str, *, grid: bool) -> None:
    k = area.scaled
    text, tick, line = k(TICK), k(8), k(2)
    widest = 0.0
    for value, label in nice_ticks(*frame.y_range, most=6):
        y = frame.to_pixels([0.0, value], area.size)[1] - line / 2
        if grid:
            color = ZERO_LINE if value == 0 else GRID
            canvas.rectangle(area.left, y, area.right, y + line, color)
        canvas.rectangle(area.left - tick, y, area.left, y + line, AXIS)
        canvas.text(area.left - tick - k(8), y + k(12), label, text, MUTED, anchor="right")
        widest = max(widest, text_width(label, text))
    name = shorten(y_label, k(AXIS_LABEL), area.bottom - area.top, bold=True)
    middle = (area.top + area.bottom) / 2
    x = max(k(44), area.left - tick - k(8) - widest - k(18))
    canvas.text(x, middle, name, k(AXIS_LABEL), TEXT, bold=True, anchor="middle", upward=True)


def draw_border(canvas: Canvas, area: Area, color: Color, width: int) -> None:
    """A line along the plot area's edge, `width` pixels inwards (negative: outwards)."""
    outer, inner = max(-width, 0), max(width, 0)
    left, top = area.left - outer, area.top - outer
    right, bottom = area.right + outer, area.bottom + outer
    line = inner + outer
    canvas.rectangle(left, top, right, top + line, color)
    canvas.rectangle(left, bottom - line, right, bottom, color)
    canvas.rectangle(left, top, left + line, bottom, color)
    canvas.rectangle(right - line, top, right, bottom, color)
