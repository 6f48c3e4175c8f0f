"""Pictures of the two boards: the map of learned PBs and the correlation landscape.

Pure functions from values to (size, size, 3) uint8 pictures. What does not change while a puck is dragged
(axes, ticks, titles) is rendered once and kept; a redraw copies it and draws the rest over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .overlay import (
    Label,
    RecognitionPath,
    as_points,
    draw_ellipse,
    draw_labels,
    draw_path,
)
from .palette import (
    BUSY,
    BUSY_FILL,
    CORRELATION,
    DONE,
    DONE_FILL,
    MUTED,
    PLOT,
    SELECTED,
    TEXT,
    WARNING,
    WARNING_FILL,
    Color,
    Legend,
    PointStyle,
    correlation_colors,
    plain_points,
    style_points,
)
from .plot import DESIGN_SIZE, Area, PlotFrame, Range, area_of, draw_axes, new_board
from .raster import Canvas, shorten, text_width

if TYPE_CHECKING:
    from ...core.landscape import Landscape

__all__ = [
    "Board",
    "Legend",
    "PlotFrame",
    "PointStyle",
    "RecognitionPath",
    "axis_names",
    "draw_landscape",
    "draw_map",
    "landscape_frame",
    "map_frame",
    "plain_points",
    "style_points",
]

NEAR_MAXIMUM = 0.9  # the outline and `area` mean the cells above this share of the maximum


class Board(NamedTuple):
    """A board's picture, (size, size, 3) uint8, and where data lies on it."""

    picture: NDArray[np.uint8]
    frame: PlotFrame


def axis_names(points: ArrayLike, axes: Sequence[int] = (0, 1)) -> tuple[str, str | None]:
    """Labels of a map's axes with their share of variance: 'PC1 (41 %)', and None where D = 1.

    Args:
        points: (N, D), all of the learned mu's principal components.
    """
    coords = np.asarray(points, dtype=np.float64)
    variance = coords.var(axis=0)
    total = variance.sum()
    names = [
        f"PC{axis + 1} ({100 * variance[axis] / total:.0f} %)" if total > 0 else f"PC{axis + 1}"
        for axis in axes
        if axis < coords.shape[1]
    ]
    return names[0], names[1] if len(names) > 1 else None


# --- the landscape ----------------------------------------------------------------------------------------


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
    """The correlation of motions around a PB with their target, as in the paper's Fig. 4.

    Args:
        landscape: `core.landscape.Landscape`; rows = second axis, drawn upwards. One row (D = 1) is
            drawn as columns, whose height is the correlation.
        x_label, y_label: 'μ1' sets the number as a subscript.
        title: the motion's name, for instance.
        window: what the window spans: '±1', '±0.7 sd'.
        note: a further remark, 'target: own reconstruction'.
        learned: (x, y) of the learned mu, marked by a ring.
        path: a recognition in the landscape's coordinates.
    """
    values = np.asarray(landscape.correlation, dtype=np.float64)
    flat = len(values) == 1
    frame = landscape_frame(landscape, size)
    y_name = "correlation" if flat else y_label
    static = _landscape_static(frame, x_label, y_name, title, window, note, flat, size)
    canvas = Canvas(static.copy())
    area = area_of(frame, size)
    if flat:
        _draw_columns(canvas, area, frame, values[0])
    else:
        _draw_cells(canvas, area, values)
    _draw_numbers(canvas, area, landscape)
    with canvas.clip(area.left, area.top, area.right, area.bottom):
        if learned is not None:
            _draw_ring(canvas, area, frame, learned)
        if path is not None:
            draw_path(canvas, area, frame, path)
    return Board(canvas.pixels, frame)


def landscape_frame(landscape: Landscape, size: int = DESIGN_SIZE) -> PlotFrame:
    """Where the landscape's data lies: its cells' edges are the plot area's edges."""
    rows, columns = landscape.correlation.shape
    k = size / DESIGN_SIZE
    side = round(680 * k)
    # Whole pixels a cell, where they fit, keep all cells alike.
    width = columns * (side // columns) if columns <= side else side
    height = rows * (side // rows) if rows <= side else side
    left, top = round(150 * k), round(236 * k)
    area = Area(left, top, left + width, top + height, size)
    y_range = (-1.0, 1.0) if rows == 1 else _cell_range(landscape.y)
    return area.frame(_cell_range(landscape.x), y_range)


def _cell_range(centers: NDArray[np.floating]) -> Range:
    """From the first cell's outer edge to the last one's."""
    low, high = float(centers[0]), float(centers[-1])
    half = (high - low) / (2 * (len(centers) - 1)) if len(centers) > 1 else 0.5
    if not high + half > low - half:
        half = max(1e-6, abs(low) * 1e-6)
    return low - half, high + half


@lru_cache(maxsize=6)
def _landscape_static(
    frame: PlotFrame,
    x_label: str,
    y_label: str | None,
    title: str,
    window: str,
    note: str,
    flat: bool,
    size: int,
) -> NDArray[np.uint8]:
    """Everything but the cells and their numbers; read-only."""
    canvas = new_board(size)
    area = area_of(frame, size)
    draw_axes(canvas, area, frame, x_label=x_label, y_label=y_label, grid=flat)
    _draw_header(canvas, area, title, " · ".join(t for t in (f"window {window}", note) if t))
    _draw_color_bar(canvas, area)
    captions = ("mean", "area > 0.9 max", "roughness")
    for x, caption in zip(_number_columns(area), captions, strict=True):
        canvas.text(x, area.scaled(212), caption, area.scaled(27), MUTED)
    canvas.pixels.flags.writeable = False
    return canvas.pixels


def _draw_header(
    canvas: Canvas, area: Area, title: str, subtitle: str, room: float = 740.0
) -> None:
    k = area.scaled
    title = shorten(title, k(41), k(room), bold=True)
    canvas.text(k(48), k(72), title, k(41), TEXT, bold=True)
    canvas.text(k(48), k(114), shorten(subtitle, k(28), k(room)), k(28), MUTED)


def _draw_color_bar(canvas: Canvas, area: Area) -> None:
    """Correlation from -1 to 1, right of the plot area."""
    k = area.scaled
    left, width, line = area.right + k(38), k(32), k(2)
    height = area.bottom - area.top
    entries = np.linspace(len(CORRELATION) - 1, 0, height).round().astype(np.intp)
    canvas.pixels[area.top : area.bottom, left : left + width] = CORRELATION[entries][:, None]
    for value, label in ((1.0, "1"), (0.5, "0.5"), (0.0, "0"), (-0.5, "−0.5"), (-1.0, "−1")):
        y = area.top + (1 - value) / 2 * height
        canvas.rectangle(left + width, y - line / 2, left + width + k(7), y + line / 2, MUTED)
        canvas.text(left + width + k(14), y + k(10), label, k(29), MUTED)


def _number_columns(area: Area) -> tuple[int, int, int]:
    k = area.scaled
    return k(150), k(382), k(692)


def _draw_numbers(canvas: Canvas, area: Area, landscape: Landscape) -> None:
    """The three numbers, pale while they are an estimate, and the state of the computation."""
    k = area.scaled
    complete = landscape.complete
    color = TEXT if complete else MUTED
    numbers = (
        _number(landscape.mean, ".3f"),
        _number(100 * landscape.area, ".0f") + " %",
        _number(landscape.roughness, ".3f"),
    )
    for x, number in zip(_number_columns(area), numbers, strict=True):
        canvas.text(x, k(180), number, k(40), color, bold=True)
    state, ink, fill = ("complete", DONE, DONE_FILL) if complete else ("coarse …", BUSY, BUSY_FILL)
    draw_chip(canvas, area, state, ink, fill, right=area.size - k(44), middle=k(62))


def _number(value: float, form: str) -> str:
    return format(value, form).replace("-", "−") if np.isfinite(value) else "–"


def draw_chip(
    canvas: Canvas, area: Area, text: str, ink: Color, fill: Color, *, right: int, middle: int
) -> None:
    """A word on a coloured lozenge: a state or a warning."""
    k = area.scaled
    size, pad = k(27), k(18)
    left = right - text_width(text, size, bold=True) - 2 * pad
    half = k(24)
    canvas.rounded(left, middle - half, right, middle + half, half, fill)
    canvas.text(left + pad, middle + k(10), text, size, ink, bold=True)


def _draw_cells(canvas: Canvas, area: Area, values: NDArray[np.float64]) -> None:
    """The cells, row 0 at the bottom, and an outline around those close to the maximum."""
    rows, columns = values.shape
    height, width = area.bottom - area.top, area.right - area.left
    upward = values[::-1]
    colors = correlation_colors(upward)
    if height % rows == 0 and width % columns == 0:
        strips = np.repeat(colors, width // columns, axis=1)
        cells = np.repeat(strips, height // rows, axis=0)
    else:
        cells = colors[np.arange(height) * rows // height][:, np.arange(width) * columns // width]
    canvas.pixels[area.top : area.bottom, area.left : area.right] = cells
    if min(height // rows, width // columns) >= 8:
        _outline_best(canvas, area, upward)


def _outline_best(canvas: Canvas, area: Area, upward: NDArray[np.float64]) -> None:
    """A line around the cells that `area` counts."""
    best = np.nan_to_num(upward, nan=-np.inf)
    inside = best > NEAR_MAXIMUM * best.max()
    if not inside.any() or inside.all():
        return
    rows, columns = inside.shape
    high, wide = (area.bottom - area.top) // rows, (area.right - area.left) // columns
    half = max(1, area.scaled(3) // 2)
    for row, column in np.argwhere(inside[:, 1:] != inside[:, :-1]):
        x, y = area.left + (column + 1) * wide, area.top + row * high
        canvas.rectangle(x - half, y - half, x + half, y + high + half, SELECTED)
    for row, column in np.argwhere(inside[1:] != inside[:-1]):
        x, y = area.left + column * wide, area.top + (row + 1) * high
        canvas.rectangle(x - half, y - half, x + wide + half, y + half, SELECTED)


def _draw_columns(
    canvas: Canvas, area: Area, frame: PlotFrame, values: NDArray[np.float64]
) -> None:
    """D = 1: a column a cell, as high as its correlation."""
    colors = correlation_colors(values)
    edges = np.rint(np.linspace(area.left, area.right, len(values) + 1)).astype(int)
    gap = 1 if edges[1] - edges[0] > 8 else 0
    zero = frame.to_pixels([0.0, 0.0], area.size)[1]
    for i in np.flatnonzero(np.isfinite(values)):
        y = frame.to_pixels([0.0, values[i]], area.size)[1]
        low, high = min(y, zero), max(y, zero) + 1
        color: Color = (int(colors[i, 0]), int(colors[i, 1]), int(colors[i, 2]))
        canvas.rectangle(edges[i] + gap, low, edges[i + 1] - gap, high, color)
        canvas.rectangle(edges[i] + gap, y - 1, edges[i + 1] - gap, y + 2, MUTED)


def _draw_ring(canvas: Canvas, area: Area, frame: PlotFrame, at: tuple[float, float]) -> None:
    """The learned mu: a dot with a light rim, seen on every colour."""
    center = frame.to_pixels(at, area.size)
    scale = area.size / DESIGN_SIZE
    canvas.markers([center], 9 * scale, SELECTED, edge=PLOT, edge_width=4 * scale)


# --- the map ----------------------------------------------------------------------------------------------


def map_frame(
    points: ArrayLike,
    *,
    include: ArrayLike | None = None,
    one_dimensional: bool = False,
    size: int = DESIGN_SIZE,
) -> PlotFrame:
    """A frame that shows all points with some room around them, one scale for both axes.

    Compute it once a model and pair of axes, not while something is dragged.

    Args:
        points: (N, 2), or (N, 1) where D = 1.
        include: (M, 2) more that must be seen: a recognition's path, say.
        one_dimensional: there is no second axis.
    """
    k = size / DESIGN_SIZE
    area = Area(round(122 * k), round(146 * k), round(984 * k), round(906 * k), size)
    every = as_points(points)
    if include is not None:
        every = np.concatenate([every, as_points(include)])
    every = every[np.isfinite(every).all(axis=1)]
    if not len(every):
        every = np.zeros((1, 2))
    low, high = every.min(axis=0), every.max(axis=0)
    middle, span = (low + high) / 2, high - low
    width, height = area.right - area.left, area.bottom - area.top
    unit = max(span[0] / width, 0.0 if one_dimensional else span[1] / height) * 1.16
    if not unit > 1e-9 * max(1.0, float(np.abs(middle).max())):
        unit = 4.0 / width  # a single point: the prior's two sigma around it
    half_x = unit * width / 2
    half_y = 1.0 if one_dimensional else unit * height / 2
    center_y = 0.0 if one_dimensional else float(middle[1])
    return area.frame(
        (float(middle[0] - half_x), float(middle[0] + half_x)),
        (center_y - half_y, center_y + half_y),
    )


def draw_map(
    points: ArrayLike,
    *,
    frame: PlotFrame | None = None,
    style: PointStyle | None = None,
    names: Sequence[str] = (),
    selected: int | None = None,
    off_plane: ArrayLike | None = None,
    near: ArrayLike | None = None,
    max_labels: int = 6,
    ellipse: ArrayLike | None = None,
    ellipse_center: ArrayLike | None = None,
    extrapolation: float | None = None,
    path: RecognitionPath | None = None,
    x_label: str = "PC1",
    y_label: str | None = "PC2",
    title: str = "PB map",
    subtitle: str = "",
    size: int = DESIGN_SIZE,
) -> Board:
    """The learned mu on two principal components, and what goes on among them.

    Args:
        points: (N, 2) map coordinates of the learned mu; (N, 1) with `y_label=None` where D = 1.
        frame: from `map_frame`; keep it while things are dragged. By default it shows all points.
        style: from `style_points`.
        names: N names, or none at all.
        selected: the point to mark and name.
        off_plane: (N,) how far each point is from the drawn slice; far ones are small and faint.
        near: (2,) where the puck is: the points nearest to it, off-plane distance included, get names.
        max_labels: how many of those.
        ellipse: (2, 2) covariance, drawn at 1 and 2 sigma around `ellipse_center` (the selected point).
        extrapolation: above 1 the board says so.
        path: a recognition in the map's coordinates; the points step back behind it.
    """
    xy = as_points(points)
    flat = y_label is None
    frame = frame or map_frame(xy, one_dimensional=flat, size=size)
    style = style or plain_points(len(xy))
    legend = style.legend
    table = None if legend.table is None else legend.table.tobytes()
    key = (legend.caption, table, legend.low, legend.high, off_plane is not None)
    static = _map_static(frame, x_label, y_label, title, subtitle, key, size)
    canvas = Canvas(static.copy())
    area = area_of(frame, size)
    apart = np.zeros(len(xy)) if off_plane is None else np.asarray(off_plane, dtype=np.float64)
    with canvas.clip(area.left, area.top, area.right, area.bottom):
        chosen = selected if selected is not None and 0 <= selected < len(xy) else None
        if ellipse is not None and (chosen is not None or ellipse_center is not None):
            middle = xy[chosen] if ellipse_center is None and chosen is not None else ellipse_center
            draw_ellipse(canvas, area, frame, middle if middle is not None else (0, 0), ellipse)
        radius = _draw_points(canvas, area, frame, xy, style, apart, chosen, path is not None)
        if path is not None:
            draw_path(canvas, area, frame, path)
        wanted = _wanted_labels(area, frame, xy, names, chosen, near, apart, max_labels, radius)
        draw_labels(canvas, area, wanted, frame.to_pixels(xy, size))
    if extrapolation is not None and extrapolation > 1:
        k = area.scaled
        text = f"extrapolating ×{extrapolation:.1f}" if extrapolation < 99.5 else "extrapolating"
        right, middle_y = area.right - k(14), area.top + k(38)
        draw_chip(canvas, area, text, WARNING, WARNING_FILL, right=right, middle=middle_y)
    return Board(canvas.pixels, frame)


LegendKey = tuple[str, bytes | None, str, str, bool]


@lru_cache(maxsize=6)
def _map_static(
    frame: PlotFrame,
    x_label: str,
    y_label: str | None,
    title: str,
    subtitle: str,
    legend: LegendKey,
    size: int,
) -> NDArray[np.uint8]:
    """Axes, grid, title and legend; read-only."""
    canvas = new_board(size)
    area = area_of(frame, size)
    draw_axes(canvas, area, frame, x_label=x_label, y_label=y_label)
    if y_label is None:
        y = frame.to_pixels([0.0, 0.0], size)[1]
        line = area.scaled(3)
        canvas.rectangle(area.left, y - line / 2, area.right, y + line / 2, MUTED)
    _draw_header(canvas, area, title, subtitle, room=480.0)
    _draw_legend(canvas, area, legend)
    canvas.pixels.flags.writeable = False
    return canvas.pixels


def _draw_legend(canvas: Canvas, area: Area, legend: LegendKey) -> None:
    """Top right: what colour means, and what faint means."""
    caption, table, low, high, fades = legend
    k = area.scaled
    right, size = area.right, k(26)
    if table is not None:
        colors = np.frombuffer(table, dtype=np.uint8).reshape(-1, 3)
        width, height, top = k(150), k(22), k(52)
        end = right - text_width(high, size) - k(12)
        entries = np.linspace(0, len(colors) - 1, width).round().astype(np.intp)
        left = round(end) - width
        canvas.pixels[top : top + height, left : left + width] = colors[entries][None]
        canvas.text(right, top + k(20), high, size, MUTED, anchor="right")
        canvas.text(left - k(12), top + k(20), low, size, MUTED, anchor="right")
    elif caption:
        canvas.text(right, k(72), caption, size, MUTED, anchor="right")
    if fades:
        text = "faint: far from this slice"
        canvas.text(right, k(114), text, size, MUTED, anchor="right")


def nearness(off_plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) 1 in the slice, falling to 0 away from it, 0.5 at the median distance."""
    usual = float(np.median(off_plane)) if len(off_plane) else 0.0
    if not usual > 1e-9:
        usual = max(float(off_plane.max(initial=0.0)), 1e-9)
    near: NDArray[np.float64] = 1.0 / (1.0 + np.square(off_plane / usual))
    return near


def _draw_points(
    canvas: Canvas,
    area: Area,
    frame: PlotFrame,
    xy: NDArray[np.float64],
    style: PointStyle,
    apart: NDArray[np.float64],
    selected: int | None,
    behind: bool,
) -> NDArray[np.float64]:
    """The points, the nearest to the slice on top; returns their radii in pixels, (N,)."""
    scale = area.size / DESIGN_SIZE
    close = nearness(apart)
    radius = (7.0 + 7.0 * close) * scale
    alpha = 0.30 + 0.70 * close
    if behind:  # a path is what is looked at now
        alpha = alpha * 0.45
    order = np.argsort(close, kind="stable")
    canvas.markers(
        frame.to_pixels(xy[order], area.size),
        radius[order],
        style.rgb[order],
        shapes=[style.shapes[i] for i in order],
        alpha=alpha[order],
        edge=PLOT,
        edge_width=2.0 * scale,
        edge_alpha=0.8 * alpha[order],
    )
    if selected is not None:
        at = frame.to_pixels(xy[selected : selected + 1], area.size)
        for reach, color in ((20.0, SELECTED), (15.5, PLOT)):
            canvas.markers(at, reach * scale, color)
        rgb, shape = style.rgb[selected], style.shapes[selected]
        canvas.markers(at, 13.0 * scale, rgb, shapes=shape)
        radius[selected] = 20.0 * scale
    return radius


def _wanted_labels(
    area: Area,
    frame: PlotFrame,
    xy: NDArray[np.float64],
    names: Sequence[str],
    selected: int | None,
    near: ArrayLike | None,
    apart: NDArray[np.float64],
    most: int,
    radius: NDArray[np.float64],
) -> list[Label]:
    """The selected point's name, then those of the nearest to the puck, nearest first."""
    if len(names) != len(xy):
        return []
    order = [] if selected is None else [selected]
    if near is not None:
        offset = xy - as_points(np.atleast_2d(np.asarray(near, dtype=np.float64)))[0]
        distance = np.hypot(np.hypot(offset[:, 0], offset[:, 1]), apart)
        nearest = [int(i) for i in np.argsort(distance, kind="stable") if i != selected]
        order += nearest[:most]
    pixels = frame.to_pixels(xy, area.size)
    return [
        Label(pixels[i, 0], pixels[i, 1], names[i], i == selected, float(radius[i]))
        for i in order
        if frame.contains(xy[i])
    ]
