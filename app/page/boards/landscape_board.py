"""The picture of the correlation landscape, as in the paper's Fig. 4."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ....core.windows import NEAR_MAXIMUM
from .overlay import RecognitionPath, draw_path
from .palette import (
    AXIS,
    BUSY,
    BUSY_FILL,
    CORRELATION,
    DONE,
    DONE_FILL,
    MUTED,
    PLOT,
    SELECTED,
    TEXT,
    correlation_colors,
)
from .plot import (
    DESIGN_SIZE,
    SMALL,
    TICK,
    Area,
    Board,
    PlotFrame,
    Range,
    area_of,
    draw_axes,
    draw_chip,
    draw_header,
    new_board,
)
from .raster import Canvas

if TYPE_CHECKING:
    from ....core.windows import Landscape

SIDE = 660.0  # design pixels of the plot area
NUMBER_COLUMNS = (164.0, 390.0, 676.0)  # where the three numbers stand


def draw_landscape(
    landscape: Landscape,
    *,
    x_label: str = "μ1",
    y_label: str | None = "μ2",
    title: str = "Correlation landscape",
    window: str = "±1",
    note: str = "",
    learned: tuple[float, float] | None = None,
    path: RecognitionPath | None = None,
    size: int = DESIGN_SIZE,
) -> Board:
    """The correlation with their target of motions generated around a PB.

    Args:
        landscape: rows = second axis, drawn upwards. One row (D = 1) is drawn as columns, whose
            height is the correlation; the frame's y is the correlation then.
        x_label, y_label: 'μ1' sets the number as a subscript.
        title: the motion's name, for instance.
        window: what the window spans: '±1', '±0.7 sd'.
        note: a further remark, 'target: own reconstruction'.
        learned: (x, y) of the learned mu, marked by a dot.
        path: a recognition in the landscape's coordinates.
        size: of the picture, pixels.
    """
    values = np.asarray(landscape.correlation, dtype=np.float64)
    flat = len(values) == 1
    frame = landscape_frame(landscape, size)
    y_name = "correlation" if flat else y_label
    static = _static(frame, x_label, y_name, title, window, note, flat, size)
    canvas = Canvas(static.copy())
    area = area_of(frame, size)
    if flat:
        _draw_columns(canvas, area, frame, values[0])
    else:
        _draw_cells(canvas, area, values)
    _draw_numbers(canvas, area, landscape)
    with canvas.clip(area.left, area.top, area.right, area.bottom):
        if learned is not None:
            at = frame.to_pixels([learned], size)
            canvas.markers(at, 9 * area.scale, SELECTED, edge=PLOT, edge_width=4 * area.scale)
        if path is not None:
            draw_path(canvas, area, frame, path)
    return Board(canvas.pixels(), frame)


def landscape_frame(landscape: Landscape, size: int = DESIGN_SIZE) -> PlotFrame:
    """Where the landscape's data lies: its cells' edges are the plot area's edges."""
    rows, columns = landscape.correlation.shape
    scale = size / DESIGN_SIZE
    side = round(SIDE * scale)
    # Whole pixels a cell, where they fit, keep all cells alike.
    width = columns * (side // columns) if columns <= side else side
    height = rows * (side // rows) if rows <= side else side
    left, top = round(164 * scale), round(242 * scale)
    area = Area(left, top, left + width, top + height, size)
    y_range = (-1.0, 1.0) if rows == 1 else _cell_range(landscape.y)
    return area.frame(_cell_range(landscape.x), y_range)


def _cell_range(centers: NDArray[np.floating]) -> Range:
    """From the first cell's outer edge to the last one's."""
    low, high = float(centers[0]), float(centers[-1])
    half = (high - low) / (2 * (len(centers) - 1)) if len(centers) > 1 else 0.5
    half = max(half, 1e-6 * max(1.0, abs(low), abs(high)))  # a window of no width is still drawn
    return low - half, high + half


@lru_cache(maxsize=8)
def _static(
    frame: PlotFrame,
    x_label: str,
    y_label: str | None,
    title: str,
    window: str,
    note: str,
    flat: bool,
    size: int,
) -> Image.Image:
    """Everything but the cells and their numbers. Nobody may draw on it."""
    canvas = new_board(size)
    area = area_of(frame, size)
    k = area.scaled
    draw_axes(canvas, area, frame, x_label=x_label, y_label=y_label, grid=flat)
    subtitle = " · ".join(part for part in (f"window {window}" if window else "", note) if part)
    draw_header(canvas, area, title, subtitle, rooms=(720.0, 930.0))
    _draw_color_bar(canvas, area)
    mean, near, rough = (k(x) for x in NUMBER_COLUMNS)
    canvas.text(mean, k(222), "mean", k(SMALL), MUTED)
    canvas.text(near, k(222), "area > 0.9 max", k(SMALL), MUTED)
    canvas.text(rough, k(222), "roughness", k(SMALL), MUTED)
    return canvas.image


def _draw_color_bar(canvas: Canvas, area: Area) -> None:
    """Correlation from -1 to 1, right of the plot area."""
    k = area.scaled
    left, right, line = area.right + k(36), area.right + k(68), k(2)
    height = area.bottom - area.top
    entries = np.linspace(len(CORRELATION) - 1, 0, height).round().astype(np.intp)
    canvas.rectangle(left - line, area.top - line, right + line, area.bottom + line, AXIS)
    canvas.cells(left, area.top, right, area.bottom, CORRELATION[entries][:, None])
    for value, label in ((1.0, "1"), (0.5, "0.5"), (0.0, "0"), (-0.5, "−0.5"), (-1.0, "−1")):
        y = area.top + (1 - value) / 2 * height
        canvas.rectangle(right + line, y - line / 2, right + k(9), y + line / 2, AXIS)
        canvas.text(right + k(16), y + k(12), label, k(TICK), MUTED)


def _draw_numbers(canvas: Canvas, area: Area, landscape: Landscape) -> None:
    """The three numbers, pale while they are an estimate, and the state of the computation."""
    k = area.scaled
    color = TEXT if landscape.complete else AXIS
    numbers = (
        _number(landscape.mean, ".3f"),
        _number(100 * landscape.area, ".0f", " %"),
        _number(landscape.roughness, ".3f"),
    )
    for x, number in zip(NUMBER_COLUMNS, numbers, strict=True):
        canvas.text(k(x), k(185), number, k(45), color, bold=True)
    _draw_key(canvas, area, k(NUMBER_COLUMNS[1]) - k(44), k(153), k(32))
    state, ink, fill = "complete", DONE, DONE_FILL
    if not landscape.complete:
        state, ink, fill = "coarse …", BUSY, BUSY_FILL
    draw_chip(canvas, area, state, ink, fill, right=area.size - k(44), middle=k(65))


def _draw_key(canvas: Canvas, area: Area, left: int, top: int, side: int) -> None:
    """What the outline on the plot means: a small outlined cell before the area's number."""
    line = area.scaled(4)
    canvas.rectangle(left, top, left + side, top + side, SELECTED)
    blue = CORRELATION[215].tolist()
    inside = (left + line, top + line, left + side - line, top + side - line)
    canvas.rectangle(*inside, (blue[0], blue[1], blue[2]))


def _number(value: float, form: str, unit: str = "") -> str:
    return format(value, form).replace("-", "−") + unit if np.isfinite(value) else "–"


def _draw_cells(canvas: Canvas, area: Area, values: NDArray[np.float64]) -> None:
    """The cells, row 0 at the bottom, and an outline around those close to the maximum."""
    upward = values[::-1]
    colors = correlation_colors(upward)
    canvas.cells(area.left, area.top, area.right, area.bottom, colors)
    rows, columns = values.shape
    high, wide = (area.bottom - area.top) // rows, (area.right - area.left) // columns
    if min(high, wide) >= area.scaled(8):
        _outline_best(canvas, area, upward, wide, high)


def _outline_best(
    canvas: Canvas, area: Area, upward: NDArray[np.float64], wide: int, high: int
) -> None:
    """A line around the cells that `area` counts, each `wide` x `high` pixels."""
    known = np.where(np.isfinite(upward), upward, -np.inf)
    inside = known > NEAR_MAXIMUM * known.max()
    line = area.scaled(5)
    half = line // 2
    for row, column in np.argwhere(inside[:, 1:] != inside[:, :-1]).tolist():
        x, y = area.left + (column + 1) * wide - half, area.top + row * high - half
        canvas.rectangle(x, y, x + line, y + high + line, SELECTED)
    for row, column in np.argwhere(inside[1:] != inside[:-1]).tolist():
        x, y = area.left + column * wide - half, area.top + (row + 1) * high - half
        canvas.rectangle(x, y, x + wide + line, y + line, SELECTED)


def _draw_columns(
    canvas: Canvas, area: Area, frame: PlotFrame, values: NDArray[np.float64]
) -> None:
    """D = 1: a column a cell, as high as its correlation."""
    colors = correlation_colors(values).tolist()
    edges = np.rint(np.linspace(area.left, area.right, len(values) + 1)).astype(int).tolist()
    gap = 1 if edges[1] - edges[0] > 8 else 0
    cap = area.scaled(4)
    zero = float(frame.to_pixels([0.0, 0.0], area.size)[1])
    canvas.rectangle(area.left, zero - 1, area.right, zero + 1, AXIS)
    for i in np.flatnonzero(np.isfinite(values)).tolist():
        y = float(frame.to_pixels([0.0, values[i]], area.size)[1])
        left, right = edges[i] + gap, edges[i + 1] - gap
        r, g, b = colors[i]
        canvas.rectangle(left, min(y, zero), right, max(y, zero), (r, g, b))
        canvas.rectangle(left, y - cap / 2, right, y + cap / 2, MUTED)
