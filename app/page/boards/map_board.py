"""The picture of the PB map: the learned mu on two of their principal components."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from .labels import Label, Placed, draw_labels, place_labels
from .masks import text_width
from .overlay import RecognitionPath, draw_bell, draw_ellipse, draw_path
from .palette import (
    AXIS,
    LABEL,
    MUTED,
    PLOT,
    SELECTED,
    WARNING,
    WARNING_FILL,
    Legend,
    PointStyle,
    plain_points,
)
from .plot import (
    DESIGN_SIZE,
    SMALL,
    Area,
    Board,
    PlotFrame,
    area_of,
    as_points,
    draw_axes,
    draw_border,
    draw_chip,
    draw_header,
    new_board,
)
from .raster import Canvas


def axis_names(points: ArrayLike, axes: Sequence[int] = (0, 1)) -> tuple[str, str | None]:
    """Labels of a map's axes with their share of variance: 'PC1 (41 %)', and None where D = 1.

    Args:
        points: (N, D), the learned mu in all of their principal components.
    """
    coordinates = np.asarray(points, dtype=np.float64)
    variance = coordinates.var(axis=0)
    total = float(variance.sum())
    names = [
        f"PC{axis + 1} ({100 * variance[axis] / total:.0f} %)" if total > 0 else f"PC{axis + 1}"
        for axis in axes
        if axis < coordinates.shape[1]
    ]
    return names[0], names[1] if len(names) > 1 else None


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
    scale = size / DESIGN_SIZE
    left, top, right, bottom = (round(edge * scale) for edge in (132, 158, 984, 888))
    area = Area(left, top, right, bottom, size)
    every = as_points(points)
    if include is not None:
        every = np.concatenate([every, as_points(include)])
    every = every[np.isfinite(every).all(axis=1)]
    if not len(every):
        every = np.zeros((1, 2))
    low, high = every.min(axis=0), every.max(axis=0)
    middle, span = (low + high) / 2, high - low
    width, height = right - left, bottom - top
    unit = 1.16 * float(max(span[0] / width, 0.0 if one_dimensional else span[1] / height))
    if not unit * width > 1e-6 * max(1.0, float(np.abs(middle).max())):
        unit = 4.0 / width  # one point: two sigma of the prior around it
    x, half_x, half_y = float(middle[0]), unit * width / 2, unit * height / 2
    if one_dimensional:
        return area.frame((x - half_x, x + half_x), (-1.0, 1.0))
    y = float(middle[1])
    return area.frame((x - half_x, x + half_x), (y - half_y, y + half_y))


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
    name_others: bool = True,
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
    """The learned mu, and what goes on among them.

    Args:
        points: (N, 2) map coordinates of the learned mu; (N, 1) with `y_label=None` where D = 1.
        frame: from `map_frame`; keep it while things are dragged. By default it shows all points.
        style: from `style_points`.
        names: N names, or none at all.
        selected: the point to mark and name.
        off_plane: (N,) how far each point is from the drawn slice; far ones are small and faint.
        near: (2,) where the puck is: the `max_labels` points nearest to it, off-plane distance
            included, get their names, as far as there is room.
        name_others: name the other points, too, in a quieter tone and only where there is room.
        ellipse: (2, 2) covariance, drawn at 1 and 2 sigma around `ellipse_center`, by default the
            selected point.
        extrapolation: above 1 the board says so.
        path: a recognition in the map's coordinates; the points step back behind it.
        size: of the picture, pixels.
    """
    xy = as_points(points)
    flat = y_label is None
    frame = frame or map_frame(xy, one_dimensional=flat, size=size)
    style = style or plain_points(len(xy))
    far_out = extrapolation is not None and extrapolation > 1
    fades = off_plane is not None and not far_out  # the warning takes the place of that line
    static = _static(frame, x_label, y_label, title, subtitle, style.legend, fades, size)
    canvas = Canvas(static.copy())
    area = area_of(frame, size)
    apart = np.zeros(len(xy)) if off_plane is None else np.asarray(off_plane, dtype=np.float64)
    chosen = selected if selected is not None and 0 <= selected < len(xy) else None
    radius = (8.0 + 8.0 * nearness(apart)) * area.scale
    pixels = frame.to_pixels(xy, size)
    placed: list[Placed] = []
    if len(names) == len(xy):
        puck = None if near is None else frame.to_pixels(as_points(np.atleast_2d(near))[0], size)
        order = [
            i for i in _named_first(xy, chosen, near, apart, max_labels) if frame.contains(xy[i])
        ]
        wanted = [Label(i, names[i], "strong" if i == chosen else "plain") for i in order]
        if name_others and not flat and path is None:
            rest = [i for i in range(len(xy)) if i not in set(order) and frame.contains(xy[i])]
            wanted += [Label(i, names[i], "quiet") for i in rest]
        placed = place_labels(area, wanted, pixels, radius, puck=puck, on_a_line=flat)
    with canvas.clip(area.left, area.top, area.right, area.bottom):
        center = ellipse_center if chosen is None or ellipse_center is not None else xy[chosen]
        if ellipse is not None and center is not None:
            _draw_gaussian(canvas, area, frame, center, ellipse, flat)
        strength = (0.32 + 0.68 * nearness(apart)) * (0.45 if path is not None else 1.0)
        named = [one.label.point for one in placed if one.label.weight != "quiet"]
        _draw_points(canvas, area, pixels, radius, strength, style, named)
        if chosen is not None:
            _draw_selected(canvas, area, pixels[chosen], style, chosen)
        if path is not None:
            draw_path(canvas, area, frame, path)
        draw_labels(canvas, area, placed)
    if extrapolation is not None and far_out:
        _draw_warning(canvas, area, extrapolation)
    return Board(canvas.pixels(), frame)


@lru_cache(maxsize=8)
def _static(
    frame: PlotFrame,
    x_label: str,
    y_label: str | None,
    title: str,
    subtitle: str,
    legend: Legend,
    fades: bool,
    size: int,
) -> Image.Image:
    """Axes, grid, title and legend. Nobody may draw on it."""
    canvas = new_board(size)
    area = area_of(frame, size)
    draw_axes(canvas, area, frame, x_label=x_label, y_label=y_label)
    if y_label is None:
        y, half = float(frame.to_pixels([0.0, 0.0], size)[1]), area.scaled(4) / 2
        canvas.rectangle(area.left, y - half, area.right, y + half, AXIS)
    draw_header(canvas, area, title, subtitle, rooms=(400.0, 500.0))
    _draw_legend(canvas, area, legend, fades)
    return canvas.image


def _draw_legend(canvas: Canvas, area: Area, legend: Legend, fades: bool) -> None:
    """Top right: what colour means, and what faint means."""
    k = area.scaled
    right, text = area.right, k(SMALL)
    if legend.scale is not None:
        width, top, bottom = k(120), k(50), k(78)
        left = right - round(text_width(legend.high, text)) - k(12) - width
        entries = np.linspace(0, len(legend.table) - 1, width).round().astype(np.intp)
        canvas.cells(left, top, left + width, bottom, legend.table[entries][None])
        canvas.text(right, k(76), legend.high, text, MUTED, anchor="right")
        canvas.text(left - k(12), k(76), legend.low, text, MUTED, anchor="right")
        start = left - k(34) - round(text_width(legend.low, text))
        canvas.text(start, k(76), legend.caption, text, MUTED, bold=True, anchor="right")
    else:
        canvas.text(right, k(76), legend.caption, text, MUTED, anchor="right")
    if fades:
        canvas.text(right, k(124), "faint: far from this slice", text, MUTED, anchor="right")


def nearness(off_plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) 1 in the slice, falling to 0 away from it, 0.5 at the median distance."""
    usual = float(np.median(off_plane)) if len(off_plane) else 0.0
    if not usual > 1e-9:
        usual = max(float(off_plane.max(initial=0.0)), 1e-9)
    near: NDArray[np.float64] = 1.0 / (1.0 + np.square(off_plane / usual))
    return near


def _named_first(
    xy: NDArray[np.float64],
    selected: int | None,
    near: ArrayLike | None,
    apart: NDArray[np.float64],
    most: int,
) -> list[int]:
    """The selected point, then those nearest to the puck, nearest first."""
    order = [] if selected is None else [selected]
    if near is not None:
        offset = xy - as_points(np.atleast_2d(np.asarray(near, dtype=np.float64)))[0]
        distance = np.hypot(np.hypot(offset[:, 0], offset[:, 1]), apart)
        nearest = [i for i in np.argsort(distance, kind="stable").tolist() if i != selected]
        order += nearest[:most]
    return order


def _draw_gaussian(
    canvas: Canvas, area: Area, frame: PlotFrame, center: ArrayLike, cov: ArrayLike, flat: bool
) -> None:
    if flat:
        middle, variance = np.ravel(center)[0], np.ravel(cov)[0]
        draw_bell(canvas, area, frame, float(middle), float(variance))
    else:
        draw_ellipse(canvas, area, frame, center, cov)


def _draw_points(
    canvas: Canvas,
    area: Area,
    pixels: NDArray[np.float64],
    radius: NDArray[np.float64],
    strength: NDArray[np.float64],
    style: PointStyle,
    named: Sequence[int],
) -> None:
    """The points, the strongest on top; those with a name beside them have a dark edge."""
    shapes = style.shapes
    order = np.argsort(strength, kind="stable").tolist()
    plain = [i for i in order if i not in set(named)]
    canvas.markers(
        pixels[plain],
        radius[plain],
        style.rgb[plain],
        shapes=[shapes[i] for i in plain],
        alpha=strength[plain],
        edge=PLOT,
        edge_width=2 * area.scale,
        edge_alpha=0.8 * strength[plain],
    )
    for i in (i for i in order if i in set(named)):
        at, shape = pixels[i], shapes[i]
        rim = 3 * area.scale
        canvas.markers(at, radius[i], PLOT, shapes=shape, edge=LABEL, edge_width=rim)
        canvas.markers(at, radius[i], style.rgb[i], shapes=shape, alpha=strength[i])


def _draw_selected(
    canvas: Canvas, area: Area, at: NDArray[np.float64], style: PointStyle, index: int
) -> None:
    scale = area.scale
    canvas.markers(at, 18 * scale, PLOT, edge=SELECTED, edge_width=5.5 * scale)
    canvas.markers(at, 13 * scale, style.rgb[index], shapes=style.shapes[index])


def _draw_warning(canvas: Canvas, area: Area, extrapolation: float) -> None:
    """Nothing learned is near: the plot's edge and a word say so."""
    k = area.scaled
    draw_border(canvas, area, WARNING, k(5))
    times = f" ×{extrapolation:.1f}" if extrapolation < 99.95 else ""
    right, middle = area.right, k(114)
    text = "extrapolating" + times
    draw_chip(canvas, area, text, WARNING, WARNING_FILL, right=right, middle=middle)
