"""What moves over a board: a recognition's path and the sigma ellipse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .palette import PATH, PATH_ENDS, PATH_STRONG, PLOT, SAMPLE, SELECTED
from .plot import Area, PlotFrame, as_points
from .raster import Canvas

UNIT_RADIUS = 30.0  # design pixels of the circle for sigma = 1, the start of every recognition
LARGEST_RADIUS = 60.0
SMALLEST_SPREAD = 2.0  # pixels; a narrower Gaussian is a point


@dataclass(frozen=True, eq=False)
class RecognitionPath:
    """One trial of a recognition in a board's coordinates (Figs. 5 and 6).

    mu: (I, 2), one row more for the state after the last iteration is welcome; (I, 1) where D = 1.
    sigma: (I, D) of the same rows; a circle's radius goes with the root mean square over D.
    pb: (up to I, 2), the PB sampled at each iteration.
    current: the row of mu to draw up to; None draws all of it, and marks the end.
    """

    mu: NDArray[np.floating]
    sigma: NDArray[np.floating]
    pb: NDArray[np.floating] | None = None
    current: int | None = None


def draw_path(canvas: Canvas, area: Area, frame: PlotFrame, path: RecognitionPath) -> None:
    """The path up to its current iteration, over whatever the board shows."""
    mu = frame.to_pixels(as_points(path.mu), area.size)
    if not len(mu):
        return
    last = len(mu) - 1
    now = last if path.current is None else min(max(path.current, 0), last)
    scale = area.scale
    width = max(1.5, 4.0 * scale)
    if now < last:  # what is still to come, for the hand on the scrubber
        canvas.line(mu[now:], PATH, width * 0.8, alpha=0.25)
    done = mu[: now + 1]
    radius = _circle_radii(path.sigma, len(mu)) * scale
    # Many circles on one spot would add up to a solid blot; in a crowd each is paler.
    crowd = min(1.0, 40 / len(done)) ** 0.4
    fading = np.linspace(0.18, 0.42, len(done)) * crowd
    canvas.markers(done, radius[: now + 1], PATH, alpha=fading)
    if path.pb is not None and len(path.pb):
        pb = frame.to_pixels(as_points(path.pb), area.size)[: now + 1]
        reach = max(4.0, 11 * scale)
        canvas.markers(
            pb,
            reach,
            SAMPLE,
            shapes="cross",
            alpha=0.9,
            edge=PLOT,
            edge_width=2 * scale,
            edge_alpha=0.6,
        )
    dot = max(2.0, 4.5 * scale)
    canvas.line(done, PLOT, width + 5 * scale, alpha=0.55)
    canvas.line(done, PATH_STRONG, width, dots=dot)
    _draw_ends(canvas, mu, now, float(radius[now]), scale)


def _circle_radii(sigma: NDArray[np.floating], count: int) -> NDArray[np.float64]:
    """(count,) design pixels; 0 where no sigma is known."""
    values = np.asarray(sigma, dtype=np.float64)
    radii = np.zeros(count)
    if values.size:
        spread = np.sqrt(np.square(values.reshape(len(values), -1)).mean(axis=1))[:count]
        reach = LARGEST_RADIUS / UNIT_RADIUS
        radii[: len(spread)] = UNIT_RADIUS * np.clip(np.nan_to_num(spread), 0, reach)
    return radii


def _draw_ends(
    canvas: Canvas, mu: NDArray[np.float64], now: int, radius: float, scale: float
) -> None:
    """Dot at the start; cross at the end, or a ring where the scrubber stands."""
    rim = 3 * scale
    canvas.markers(mu[:1], 11 * scale, PATH_ENDS, edge=PLOT, edge_width=rim)
    here = mu[now : now + 1]
    if now == len(mu) - 1:
        canvas.markers(here, 19 * scale, PATH_ENDS, shapes="plus", edge=PLOT, edge_width=rim)
        return
    if not np.isfinite(here).all():
        return
    turn = np.linspace(0, 2 * np.pi, 49)
    reach = max(radius, 15 * scale)
    ring = here + reach * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    canvas.line(ring, PLOT, 7 * scale, alpha=0.8)
    canvas.line(ring, PATH_STRONG, 4 * scale)
    canvas.markers(here, 8 * scale, PATH_ENDS, edge=PLOT, edge_width=rim)


def draw_ellipse(
    canvas: Canvas, area: Area, frame: PlotFrame, center: ArrayLike, covariance: ArrayLike
) -> None:
    """One and two standard deviations of a Gaussian; nothing where it is a point (sigma = 0).

    Args:
        center: (2,) or (1,). covariance: (2, 2), or (1, 1) where D = 1.
    """
    spread = np.zeros((2, 2))
    given = np.atleast_2d(np.asarray(covariance, dtype=np.float64))
    spread[: len(given), : len(given)] = given
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    origin, unit_x, unit_y = frame.to_pixels(corners, area.size)
    to_pixels = np.stack([unit_x - origin, unit_y - origin], axis=1)
    pixels = to_pixels @ spread @ to_pixels.T
    middle = frame.to_pixels(as_points(np.atleast_2d(np.asarray(center)))[0], area.size)
    if not (np.isfinite(pixels).all() and np.isfinite(middle).all()):
        return
    if np.sqrt(np.trace(pixels)) < SMALLEST_SPREAD:
        return
    body = np.eye(2) * (5 * area.scale) ** 2  # a line (D = 1, or one sigma of 0) still gets some
    canvas.ellipses(
        middle,
        pixels + body,
        SELECTED,
        scales=(1.0, 2.0),
        fill=0.06,
        width=max(1.2, 3.2 * area.scale),
    )


def draw_bell(canvas: Canvas, area: Area, frame: PlotFrame, center: float, variance: float) -> None:
    """D = 1: the Gaussian's density above the line, as in the first column of Fig. 5."""
    sigma = float(np.sqrt(max(variance, 0.0)))
    unit = (area.right - area.left) / (frame.x_range[1] - frame.x_range[0])
    if not (np.isfinite(center) and SMALLEST_SPREAD < sigma * unit < np.inf):
        return
    steps = np.linspace(-4, 4, 129)
    curve = np.stack([center + sigma * steps, 0.55 * np.exp(-0.5 * steps**2)], axis=1)
    pixels = frame.to_pixels(curve, area.size)
    canvas.polygon(pixels, SELECTED, alpha=0.10)
    canvas.line(pixels, SELECTED, max(1.2, 3.2 * area.scale))
