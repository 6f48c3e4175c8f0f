"""A small anti-aliased rasteriser, quick enough to redraw a board while it is dragged on.

Pillow's shapes have hard edges, and supersampling a whole board costs too much. So marks and names
are masks that are kept for the next redraw, which pastes them; only lines are supersampled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from .masks import STEPS, as_mask, mark_mask, rounded_mask, text_sprite
from .palette import Color, Shape

Anchor = Literal["left", "middle", "right"]
_FAR = 1e6  # pixels; what is further out is off the board all the same
_OVER = 3  # supersampling of lines


class Canvas:
    """A picture being drawn: RGB, coordinates in pixels from the top left, y down.

    Pixel i covers [i, i + 1), so its centre is at i + 0.5.
    """

    def __init__(self, image: Image.Image) -> None:
        self.image = image
        self._clip = (0, 0, *image.size)  # left, top, right, bottom

    def pixels(self) -> NDArray[np.uint8]:
        """(H, W, 3) uint8, a copy."""
        return np.array(self.image)

    @contextmanager
    def clip(self, left: int, top: int, right: int, bottom: int) -> Iterator[None]:
        """Draw only inside this rectangle."""
        before = self._clip
        self._clip = (
            max(left, before[0]),
            max(top, before[1]),
            min(right, before[2]),
            min(bottom, before[3]),
        )
        try:
            yield
        finally:
            self._clip = before

    def paste(self, left: int, top: int, mask: Image.Image, color: Color) -> None:
        """Lay a colour over the picture as far as the mask, at (left, top), covers it."""
        x0, y0 = max(left, self._clip[0]), max(top, self._clip[1])
        x1 = min(left + mask.width, self._clip[2])
        y1 = min(top + mask.height, self._clip[3])
        if x0 >= x1 or y0 >= y1:
            return
        if (x1 - x0, y1 - y0) != mask.size:
            mask = mask.crop((x0 - left, y0 - top, x1 - left, y1 - top))
        self.image.paste(color, (x0, y0, x1, y1), mask)

    def rectangle(self, left: float, top: float, right: float, bottom: float, color: Color) -> None:
        """Fill whole pixels, edges rounded to them."""
        x0, y0 = max(round(left), self._clip[0]), max(round(top), self._clip[1])
        x1, y1 = min(round(right), self._clip[2]), min(round(bottom), self._clip[3])
        if x0 < x1 and y0 < y1:
            self.image.paste(color, (x0, y0, x1, y1))

    def cells(self, left: int, top: int, right: int, bottom: int, rgb: NDArray[np.uint8]) -> None:
        """Stretch (rows, columns, 3) colours over a rectangle, each cell one flat colour."""
        cells = Image.fromarray(np.ascontiguousarray(rgb))
        size = (right - left, bottom - top)
        self.image.paste(cells.resize(size, Image.Resampling.NEAREST), (left, top))

    def rounded(
        self, left: float, top: float, right: float, bottom: float, radius: float, color: Color
    ) -> None:
        """Fill a rectangle of whole pixels with round corners."""
        x0, y0, x1, y1 = round(left), round(top), round(right), round(bottom)
        self.paste(x0, y0, rounded_mask(x1 - x0, y1 - y0, radius), color)

    def markers(
        self,
        xy: ArrayLike,
        radius: ArrayLike,
        colors: ArrayLike,
        *,
        shapes: Shape | Sequence[Shape] = "circle",
        alpha: ArrayLike = 1.0,
        edge: Color | None = None,
        edge_width: float = 0.0,
        edge_alpha: ArrayLike = 1.0,
    ) -> None:
        """N marks, in order; what is not finite or off the clip is left out.

        Args:
            xy: (N, 2) pixels. radius: (N,) or one. colors: (N, 3) or one. alpha: (N,) or one.
            edge: colour of an outline, `edge_width` pixels outside the mark; its alpha (N,) or one.
        """
        at = np.asarray(xy, dtype=np.float64).reshape(-1, 2)
        count = len(at)
        radii = _each(radius, count)
        opacity, edge_opacity = _each(alpha, count), _each(edge_alpha, count)
        rgb = np.asarray(colors, dtype=np.uint8).reshape(-1, 3).tolist()
        for i, (x, y) in enumerate(at.tolist()):
            reach = 1.5 * radii[i] + edge_width + 1
            if not self._touches(x - reach, y - reach, x + reach, y + reach):
                continue
            shape = shapes if isinstance(shapes, str) else shapes[i]
            if edge is not None:
                self._mark(shape, x, y, radii[i], edge_width, edge_opacity[i], edge)
            red, green, blue = rgb[i if len(rgb) > 1 else 0]
            self._mark(shape, x, y, radii[i], 0.0, opacity[i], (red, green, blue))

    def _mark(
        self,
        shape: Shape,
        x: float,
        y: float,
        radius: float,
        grow: float,
        alpha: float,
        color: Color,
    ) -> None:
        qx, qy, quarters = round(x * STEPS), round(y * STEPS), round(radius * STEPS)
        share = round(min(1.0, max(0.0, alpha)) * 32)
        if quarters <= 0 or share <= 0:
            return
        mask, offset = mark_mask(
            shape, quarters, round(grow * STEPS), qx % STEPS, qy % STEPS, share
        )
        self.paste(qx // STEPS - offset, qy // STEPS - offset, mask, color)

    def line(
        self,
        xy: ArrayLike,
        color: Color,
        width: float = 2.0,
        alpha: float = 1.0,
        dots: float = 0.0,
    ) -> None:
        """A polyline through (N, 2) pixels, broken where a point is not finite.

        dots: radius of a dot on every point.
        """
        self._supersampled(xy, color, max(width, 2 * dots), alpha, _line_drawer(width, dots))

    def polygon(self, xy: ArrayLike, color: Color, alpha: float = 1.0) -> None:
        """Fill the polygon with the corners (N, 2) pixels; finite ones only."""
        self._supersampled(xy, color, 0.0, alpha, _fill)

    def _supersampled(
        self,
        xy: ArrayLike,
        color: Color,
        width: float,
        alpha: float,
        draw: Callable[[ImageDraw.ImageDraw, NDArray[np.float64], int], None],
    ) -> None:
        at = np.clip(np.asarray(xy, dtype=np.float64).reshape(-1, 2), -_FAR, _FAR)
        finite = np.asarray(np.isfinite(at).all(axis=1))
        if finite.sum() < 2:
            return
        margin = width + 2
        low = np.floor(at[finite].min(axis=0) - margin).astype(int).tolist()
        high = np.ceil(at[finite].max(axis=0) + margin).astype(int).tolist()
        x0, y0 = max(low[0], self._clip[0]), max(low[1], self._clip[1])
        x1, y1 = min(high[0], self._clip[2]), min(high[1], self._clip[3])
        if x0 >= x1 or y0 >= y1:
            return
        mask = Image.new("L", ((x1 - x0) * _OVER, (y1 - y0) * _OVER))
        draw(ImageDraw.Draw(mask), (at - (x0, y0)) * _OVER - 0.5, round(255 * alpha))
        self.paste(x0, y0, mask.reduce(_OVER), color)

    def ellipses(
        self,
        center: ArrayLike,
        shape: ArrayLike,
        color: Color,
        *,
        scales: Sequence[float],
        fill: float,
        width: float,
    ) -> None:
        """Concentric ellipses (p - center)^T shape^-1 (p - center) = scale^2.

        Args:
            center: (2,) pixels. shape: (2, 2) pixels squared, positive definite.
            fill: opacity of each one's inside. width: of the outlines, pixels.
        """
        x, y = np.asarray(center, dtype=np.float64).tolist()
        matrix = np.asarray(shape, dtype=np.float64)
        rx, ry = (np.sqrt(np.diag(matrix)) * max(scales) + width + 1).tolist()
        if not self._touches(x - rx, y - ry, x + rx, y + ry):
            return
        left, right = max(int(x - rx), self._clip[0]), min(int(x + rx) + 2, self._clip[2])
        top, bottom = max(int(y - ry), self._clip[1]), min(int(y + ry) + 2, self._clip[3])
        dx = (np.arange(left, right) + np.float32(0.5 - x)).astype(np.float32)[None, :]
        dy = (np.arange(top, bottom) + np.float32(0.5 - y)).astype(np.float32)[:, None]
        inverse = np.linalg.inv(matrix).astype(np.float32)
        gx = inverse[0, 0] * dx + inverse[0, 1] * dy  # half the gradient of the quadratic form
        gy = inverse[0, 1] * dx + inverse[1, 1] * dy
        form = np.sqrt(np.maximum(gx * dx + gy * dy, np.float32(1e-12)))
        slope = np.sqrt(gx * gx + gy * gy + np.float32(1e-20)) / form  # of `form`, per pixel
        clear = np.ones_like(form)
        for scale in scales:
            distance = (form - np.float32(scale)) / slope
            clear *= 1 - np.float32(fill) * np.clip(0.5 - distance, 0, 1)
            clear *= 1 - np.clip(np.float32(width / 2 + 0.5) - np.abs(distance), 0, 1)
        self.paste(left, top, as_mask(1 - clear), color)

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: int,
        color: Color,
        *,
        bold: bool = False,
        anchor: Anchor = "left",
        halo: Color | None = None,
        upward: bool = False,
    ) -> None:
        """One line of text; (x, y) is its anchor on the baseline. `upward` turns it left."""
        if not text:
            return
        sprite = text_sprite(text, size, bold, upward)
        shift = {"left": 0.0, "middle": sprite.advance / 2, "right": sprite.advance}[anchor]
        if upward:
            left, top = round(x) - sprite.baseline, round(y + shift) - sprite.ink.height
            top += sprite.pad
        else:
            left, top = round(x - shift) - sprite.pad, round(y) - sprite.baseline
        if halo is not None:
            self.paste(left, top, sprite.halo, halo)
        self.paste(left, top, sprite.ink, color)

    def _touches(self, left: float, top: float, right: float, bottom: float) -> bool:
        """Does the box touch the clip? False for NaN and infinity."""
        x0, y0, x1, y1 = self._clip
        return x0 < right < _FAR and -_FAR < left < x1 and y0 < bottom < _FAR and -_FAR < top < y1


def _line_drawer(
    width: float, dots: float
) -> Callable[[ImageDraw.ImageDraw, NDArray[np.float64], int], None]:
    thick, reach = max(1, round(width * _OVER)), dots * _OVER

    def draw(target: ImageDraw.ImageDraw, at: NDArray[np.float64], ink: int) -> None:
        finite = np.asarray(np.isfinite(at).all(axis=1))
        for run in np.split(np.arange(len(at)), np.flatnonzero(~finite)):
            points = [(x, y) for x, y in at[run].tolist() if math.isfinite(x + y)]
            if len(points) > 1:
                target.line(points, fill=ink, width=thick)
            for x, y in points if reach else ():
                target.ellipse((x - reach, y - reach, x + reach, y + reach), fill=ink)

    return draw


def _fill(target: ImageDraw.ImageDraw, at: NDArray[np.float64], ink: int) -> None:
    target.polygon([(x, y) for x, y in at.tolist() if math.isfinite(x + y)], fill=ink)


def _each(value: ArrayLike, count: int) -> list[float]:
    """One number for each of `count` marks, from as many or from one."""
    numbers: list[float] = np.asarray(value, dtype=np.float64).reshape(-1).tolist()
    return numbers * count if len(numbers) == 1 else numbers
