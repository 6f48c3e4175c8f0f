"""A small anti-aliased rasteriser on a uint8 array, quick enough to redraw a board while it is dragged on.

Pillow draws whole pictures without anti-aliasing or with a costly supersampling; a board needs a hundred small
marks. Each mark's coverage comes from its signed distance function instead, on its own small patch.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from .palette import Color, Shape, font

Coverage = NDArray[np.float32]  # (h, w), 0 to 1
Anchor = Literal["left", "middle", "right"]
_FAR = 1e6  # pixels; what is further out is off the board all the same
_SQUARE = 0.886  # half the side of a square with a unit circle's area


class Canvas:
    """A picture being drawn: (H, W, 3) uint8, coordinates in pixels from the top left, y down."""

    def __init__(self, pixels: NDArray[np.uint8]) -> None:
        self.pixels = pixels
        self._clip = (0, 0, pixels.shape[1], pixels.shape[0])  # left, top, right, bottom

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

    def blend(
        self, left: int, top: int, coverage: Coverage, color: Color | NDArray[np.uint8]
    ) -> None:
        """Lay a colour over a patch, as far as it is covered."""
        height, width = coverage.shape
        x0, y0 = max(left, self._clip[0]), max(top, self._clip[1])
        x1, y1 = min(left + width, self._clip[2]), min(top + height, self._clip[3])
        if x0 >= x1 or y0 >= y1:
            return
        share = coverage[y0 - top : y1 - top, x0 - left : x1 - left, None]
        patch = self.pixels[y0:y1, x0:x1]
        under = patch.astype(np.float32)
        under += (np.asarray(color, dtype=np.float32) - under) * share
        patch[...] = np.rint(under).astype(np.uint8)

    def rectangle(self, left: float, top: float, right: float, bottom: float, color: Color) -> None:
        """Fill whole pixels, edges rounded to them."""
        x0, y0 = max(round(left), self._clip[0]), max(round(top), self._clip[1])
        x1, y1 = min(round(right), self._clip[2]), min(round(bottom), self._clip[3])
        if x0 < x1 and y0 < y1:
            self.pixels[y0:y1, x0:x1] = color

    def rounded(
        self, left: float, top: float, right: float, bottom: float, radius: float, color: Color
    ) -> None:
        """Fill a rectangle with round corners."""
        center = np.array([(left + right) / 2, (top + bottom) / 2])
        half = np.array([(right - left) / 2, (bottom - top) / 2])
        x0, y0 = int(left) - 1, int(top) - 1
        ys, xs = np.mgrid[y0 : int(bottom) + 2, x0 : int(right) + 2].astype(np.float32) + 0.5
        qx = np.abs(xs - center[0]) - (half[0] - radius)
        qy = np.abs(ys - center[1]) - (half[1] - radius)
        outside = np.hypot(np.maximum(qx, 0), np.maximum(qy, 0))
        distance = outside + np.minimum(np.maximum(qx, qy), 0) - radius
        self.blend(x0, y0, np.clip(0.5 - distance, 0, 1).astype(np.float32), color)

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
        edge_alpha: ArrayLike | None = None,
    ) -> None:
        """N marks, in order; what is not finite or off the clip is left out.

        Args:
            xy: (N, 2) pixels. radius: (N,) or one. colors: (N, 3) or one. alpha: (N,) or one.
            edge: an outline around each mark, `edge_width` pixels outside it.
        """
        at = np.asarray(xy, dtype=np.float64).reshape(-1, 2)
        count = len(at)
        radii = np.broadcast_to(np.asarray(radius, np.float64), (count,))
        rgb = np.broadcast_to(np.asarray(colors, np.uint8), (count, 3))
        alphas = np.broadcast_to(np.asarray(alpha, np.float32), (count,))
        edges = alphas if edge_alpha is None else np.broadcast_to(np.float32(edge_alpha), (count,))
        for i in range(count):
            x, y = at[i]
            reach = radii[i] + edge_width + 1
            if not self._touches(x - reach, y - reach, x + reach, y + reach):
                continue
            shape = shapes if isinstance(shapes, str) else shapes[i]
            left, top = int(np.floor(x - reach)), int(np.floor(y - reach))
            size = int(np.ceil(2 * reach)) + 1
            distance = _distance(shape, left - x, top - y, size, float(radii[i]))
            if edge is not None:
                outline = np.clip(edge_width + 0.5 - distance, 0, 1) * edges[i]
                self.blend(left, top, outline, edge)
            self.blend(left, top, np.clip(0.5 - distance, 0, 1) * alphas[i], rgb[i])

    def line(self, xy: ArrayLike, color: Color, width: float = 2.0, alpha: float = 1.0) -> None:
        """A polyline through (N, 2) pixels, broken where a point is not finite."""
        at = np.clip(np.asarray(xy, dtype=np.float64).reshape(-1, 2), -_FAR, _FAR)
        finite = np.isfinite(at).all(axis=1)
        if finite.sum() < 2:
            return
        margin = width + 2
        x0, y0 = np.floor(at[finite].min(axis=0) - margin).astype(int)
        x1, y1 = np.ceil(at[finite].max(axis=0) + margin).astype(int)
        x0, y0 = max(x0, self._clip[0]), max(y0, self._clip[1])
        x1, y1 = min(x1, self._clip[2]), min(y1, self._clip[3])
        if x0 >= x1 or y0 >= y1:
            return
        over = 3  # supersampling; only a one-channel mask, so it stays cheap
        mask = Image.new("L", ((x1 - x0) * over, (y1 - y0) * over))
        draw = ImageDraw.Draw(mask)
        for run in np.split(np.arange(len(at)), np.flatnonzero(~finite)):
            points = [tuple((at[i] - (x0, y0)) * over - 0.5) for i in run if finite[i]]
            if len(points) > 1:
                draw.line(points, fill=255, width=max(1, round(width * over)), joint="curve")
        coverage = np.asarray(mask.reduce(over), dtype=np.float32) * (alpha / 255)
        self.blend(x0, y0, coverage, color)

    def ellipse(
        self, center: ArrayLike, shape: ArrayLike, color: Color, *, fill: float, width: float
    ) -> None:
        """The ellipse (p - center)^T shape^-1 (p - center) = 1, `shape` (2, 2) in pixels squared."""
        x, y = np.asarray(center, np.float64)
        matrix = np.asarray(shape, np.float64)
        if not np.isfinite([x, y, *matrix.flat]).all():
            return
        reach = np.sqrt(np.diag(matrix)) + width + 1
        if not self._touches(x - reach[0], y - reach[1], x + reach[0], y + reach[1]):
            return
        left, top = max(int(x - reach[0]), self._clip[0]), max(int(y - reach[1]), self._clip[1])
        right = min(int(np.ceil(x + reach[0])) + 1, self._clip[2])
        bottom = min(int(np.ceil(y + reach[1])) + 1, self._clip[3])
        if left >= right or top >= bottom:
            return
        dx = (np.arange(left, right, dtype=np.float32) + np.float32(0.5 - x))[None, :]
        dy = (np.arange(top, bottom, dtype=np.float32) + np.float32(0.5 - y))[:, None]
        a, b, c = (np.float32(v) for v in np.linalg.inv(matrix)[[0, 0, 1], [0, 1, 1]])
        gx, gy = a * dx + b * dy, b * dx + c * dy  # half the gradient of the quadratic form
        form = np.sqrt(np.maximum(gx * dx + gy * dy, 1e-12))
        distance = (form - 1) * form / np.sqrt(gx * gx + gy * gy + 1e-12)  # first order, in pixels
        inside = np.clip(0.5 - distance, 0, 1)
        self.blend(left, top, inside * np.float32(fill), color)
        rim = np.clip(width / 2 + 0.5 - np.abs(distance), 0, 1)
        self.blend(left, top, rim, color)

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
        alpha: float = 1.0,
    ) -> None:
        """One line of text; (x, y) is its anchor on the baseline. `upward` turns it by 90 degrees."""
        if not text:
            return
        sprite = text_sprite(text, size, bold)
        shift = {"left": 0.0, "middle": sprite.advance / 2, "right": sprite.advance}[anchor]
        masks = [(sprite.halo, halo), (sprite.ink, color)]
        for mask, tint in masks:
            if tint is None:
                continue
            if upward:
                left = round(x) - sprite.baseline
                top = round(y + shift) - mask.shape[1] + sprite.pad
                mask = np.rot90(mask)
            else:
                left, top = round(x - shift) - sprite.pad, round(y) - sprite.baseline
            self.blend(left, top, mask * np.float32(alpha) if alpha < 1 else mask, tint)

    def _touches(self, left: float, top: float, right: float, bottom: float) -> bool:
        """Does the box touch the clip? False for NaN and infinity."""
        x0, y0, x1, y1 = self._clip
        return bool(x0 < right < _FAR and -_FAR < left < x1 and y0 < bottom < _FAR and top < y1)


def _distance(shape: Shape, left: float, top: float, size: int, radius: float) -> Coverage:
    """(size, size) signed distance in pixels from the mark's outline, negative inside."""
    x = (np.arange(size, dtype=np.float32) + np.float32(left + 0.5))[None, :]
    y = (np.arange(size, dtype=np.float32) + np.float32(top + 0.5))[:, None]
    if shape == "circle":
        return np.sqrt(x * x + y * y) - np.float32(radius)
    if shape == "square":
        return np.maximum(np.abs(x), np.abs(y)) - np.float32(radius * _SQUARE)
    if shape == "diamond":
        return (np.abs(x) + np.abs(y)) * np.float32(0.7071) - np.float32(radius * _SQUARE)
    if shape == "triangle":
        slope = np.abs(x) * np.float32(0.866) - y * np.float32(0.5)
        return np.maximum(slope, y) - np.float32(radius * 0.68)
    if shape == "cross":
        x, y = (x + y) * np.float32(0.7071), (x - y) * np.float32(0.7071)
    bar = np.float32(max(radius * 0.26, 1.0))
    ax, ay, end = np.abs(x), np.abs(y), np.float32(radius)
    return np.minimum(np.maximum(ax - end, ay - bar), np.maximum(ax - bar, ay - end))


@dataclass(frozen=True)
class TextSprite:
    """A rendered line: ink and halo (h, w) coverage, `pad` pixels left of its start."""

    ink: Coverage
    halo: Coverage
    pad: int
    baseline: int  # rows from the top down to the baseline
    advance: float


_SUBSCRIPT = re.compile(r"(?<=[μσ])(\d+)")  # μ12 is set with a lowered 12


@lru_cache(maxsize=1024)
def text_sprite(text: str, size: int, bold: bool = False) -> TextSprite:
    """Render a line once; boards show the same few strings again and again."""
    pad = max(4, size // 6)
    runs: list[tuple[str, int, int]] = []  # text, size, how far below the baseline
    for i, part in enumerate(_SUBSCRIPT.split(text)):
        if part:
            runs.append((part, round(size * 0.72), round(size * 0.2)) if i % 2 else (part, size, 0))
    ascent, descent = font(size, bold=bold).getmetrics()
    advance = sum(font(s, bold=bold).getlength(part) for part, s, _ in runs)
    shape = (int(np.ceil(advance)) + 2 * pad, ascent + descent + 2 * pad)
    masks = []
    for stroke in (0, pad - 1):
        image = Image.new("L", shape)
        draw = ImageDraw.Draw(image)
        x = float(pad)
        for part, run_size, drop in runs:
            face = font(run_size, bold=bold)
            at = (x, pad + ascent + drop)
            draw.text(at, part, fill=255, font=face, anchor="ls", stroke_width=stroke)
            x += face.getlength(part)
        mask = np.asarray(image, dtype=np.float32) / 255
        mask.flags.writeable = False
        masks.append(mask)
    return TextSprite(masks[0], masks[1], pad, pad + ascent, advance)


def text_width(text: str, size: int, *, bold: bool = False) -> float:
    """Pixels that a line of text takes."""
    return text_sprite(text, size, bold).advance if text else 0.0


def shorten(text: str, size: int, width: float, *, bold: bool = False) -> str:
    """The text, with an ellipsis in place of the end that does not fit."""
    if text_width(text, size, bold=bold) <= width:
        return text
    while text and text_width(text + "…", size, bold=bold) > width:
        text = text[:-1]
    return text.rstrip() + "…"
