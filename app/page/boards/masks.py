"""Anti-aliased masks of marks and of lines of text, rendered once and kept.

A mark's coverage comes from its signed distance function: exact edges, and no supersampling.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from .palette import Shape, font

Floats = NDArray[np.float32]
LONGEST = 300  # characters of a line; more than any board has room for
STEPS = 4  # marks are placed and sized to a quarter of a pixel, which keeps few different masks
_SQUARE = 0.886  # half the side of a square with a unit circle's area


def as_mask(coverage: Floats) -> Image.Image:
    """(h, w) coverage from 0 to 1 as a Pillow mask."""
    return Image.fromarray(np.rint(np.clip(coverage, 0, 1) * 255).astype(np.uint8))


@lru_cache(maxsize=8192)
def mark_mask(
    shape: Shape, radius: int, grow: int, x: int, y: int, alpha: int
) -> tuple[Image.Image, int]:
    """A mark's mask and how far its centre's pixel lies from the mask's left and top.

    Lengths in quarters of a pixel: radius, outline moved out by `grow`, centre at (x, y) within its
    pixel; alpha in 32nds. Whole numbers, so that equal marks share one mask.
    """
    offset = int(np.ceil((radius * 1.5 + grow) / STEPS)) + 1
    grid = np.arange(2 * offset + 1, dtype=np.float32) + np.float32(0.5 - offset)
    dx = (grid - np.float32(x / STEPS))[None, :]
    dy = (grid - np.float32(y / STEPS))[:, None]
    distance = _distance(shape, dx, dy, radius / STEPS) - np.float32(grow / STEPS)
    coverage = np.clip(np.float32(0.5) - distance, 0, 1) * np.float32(alpha / 32)
    return as_mask(coverage), offset


def _distance(shape: Shape, x: Floats, y: Floats, radius: float) -> Floats:
    """(h, w) signed distance in pixels from a mark's outline, negative inside.

    x: (1, w), y: (h, 1) pixels from its centre.
    """
    if shape == "circle":
        result = np.hypot(x, y) - radius
    elif shape == "square":
        result = np.maximum(np.abs(x), np.abs(y)) - radius * _SQUARE
    elif shape == "diamond":
        result = (np.abs(x) + np.abs(y)) * np.sqrt(0.5) - radius * _SQUARE
    elif shape == "triangle":
        y = y - np.float32(0.1 * radius)
        result = np.maximum(np.abs(x) * 0.866 - y * 0.5, y) - radius * 0.68
    else:
        if shape == "cross":
            root = np.float32(np.sqrt(0.5))
            x, y = (x + y) * root, (x - y) * root
        bar = max(radius * 0.26, 1.0)
        ax, ay = np.abs(x), np.abs(y)
        result = np.minimum(np.maximum(ax - radius, ay - bar), np.maximum(ax - bar, ay - radius))
    distance: Floats = result.astype(np.float32)
    return distance


@lru_cache(maxsize=64)
def rounded_mask(width: int, height: int, radius: float) -> Image.Image:
    x = np.abs(np.arange(width, dtype=np.float32) + 0.5 - width / 2)[None, :]
    y = np.abs(np.arange(height, dtype=np.float32) + 0.5 - height / 2)[:, None]
    qx, qy = x - (width / 2 - radius), y - (height / 2 - radius)
    outside = np.hypot(np.maximum(qx, 0), np.maximum(qy, 0))
    distance = outside + np.minimum(np.maximum(qx, qy), 0) - radius
    return as_mask((0.5 - distance).astype(np.float32))


@dataclass(frozen=True)
class TextSprite:
    """A rendered line: masks of its ink and of a halo, which start `pad` pixels before the text."""

    ink: Image.Image
    halo: Image.Image
    pad: int
    baseline: int  # rows (columns of upward text) to the baseline
    advance: float


_SUBSCRIPT = re.compile(r"(?<=[μσ])(\d+)")  # μ12 is set with a lowered 12


def _runs(text: str, size: int) -> list[tuple[str, int, int]]:
    """Pieces of a line: text, size, pixels below the baseline."""
    parts = _SUBSCRIPT.split(" ".join(text.split()))
    small, drop = round(size * 0.74), round(size * 0.2)
    return [(p, small, drop) if i % 2 else (p, size, 0) for i, p in enumerate(parts) if p]


@lru_cache(maxsize=512)
def text_sprite(text: str, size: int, bold: bool = False, upward: bool = False) -> TextSprite:
    """Render a line once; boards show the same few again and again."""
    pad = max(4, size // 6)
    ascent, descent = font(size, bold=bold).getmetrics()
    advance = text_width(text, size, bold=bold)
    shape = (int(np.ceil(advance)) + 2 * pad, ascent + descent + 2 * pad)
    masks = []
    for stroke in (0, pad - 1):
        image = Image.new("L", shape)
        draw = ImageDraw.Draw(image)
        x = float(pad)
        for part, run_size, drop in _runs(text, size):
            face = font(run_size, bold=bold)
            at = (x, pad + ascent + drop)
            draw.text(at, part, fill=255, font=face, anchor="ls", stroke_width=stroke)
            x += face.getlength(part)
        masks.append(image.transpose(Image.Transpose.ROTATE_90) if upward else image)
    return TextSprite(masks[0], masks[1], pad, pad + ascent, advance)


@lru_cache(maxsize=4096)
def text_width(text: str, size: int, *, bold: bool = False) -> float:
    """Pixels that a line of text takes."""
    return sum(font(run, bold=bold).getlength(part) for part, run, _ in _runs(text, size))


@lru_cache(maxsize=4096)
def shorten(text: str, size: int, width: float, *, bold: bool = False) -> str:
    """The text, with an ellipsis in place of the end that does not fit."""
    text = " ".join(text.split())[:LONGEST]
    if text_width(text, size, bold=bold) <= width:
        return text
    fits = font(size, bold=bold).getlength
    low, high = 0, len(text) - 1  # characters that fit, and that may
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if fits(text[:middle] + "…") <= width else (low, middle - 1)
    return text[:low].rstrip() + "…"
