"""Colours and fonts of the boards, chosen to survive colour blindness and a projector.

The correlation scale is ColorBrewer's RdBu, that of the paper's Fig. 4 (red -1, white 0, blue 1).
Classes get one of Paul Tol's muted hues and, where those run out, another marker shape, which does
not depend on seeing colour.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import ImageFont

Color = tuple[int, int, int]
ColorBy = Literal["class", "valence", "arousal"]
Shape = Literal["circle", "diamond", "square", "triangle", "cross", "plus"]

BOARD: Color = (252, 252, 251)
PLOT: Color = (255, 255, 255)
FRAME: Color = (74, 80, 88)
AXIS: Color = (120, 128, 138)
GRID: Color = (233, 236, 240)
ZERO_LINE: Color = (206, 211, 218)
TEXT: Color = (20, 26, 36)
QUIET: Color = (110, 118, 131)
LABEL: Color = (44, 52, 64)
MUTED: Color = (58, 66, 78)
UNKNOWN: Color = (173, 179, 187)  # a motion without a rating, a cell without a correlation

PATH: Color = (204, 51, 85)  # mu over the iterations, as in Figs. 5 and 6
PATH_STRONG: Color = (158, 20, 52)
PATH_ENDS: Color = (232, 28, 40)
SAMPLE: Color = (17, 119, 51)  # the sampled PBs' crosses
SELECTED: Color = (20, 26, 36)
WARNING: Color = (180, 83, 9)
WARNING_FILL: Color = (254, 243, 219)
BUSY: Color = (75, 85, 99)
BUSY_FILL: Color = (236, 239, 243)
DONE: Color = (21, 94, 62)
DONE_FILL: Color = (223, 243, 232)

# Tol's muted qualitative set, less its palest, which vanish on white; sky and vermilion are Okabe
# and Ito's.
CLASS_HUES: tuple[Color, ...] = (
    (51, 34, 136),  # indigo
    (204, 102, 119),  # rose
    (221, 190, 84),  # sand
    (17, 119, 51),  # green
    (86, 180, 233),  # sky
    (170, 68, 153),  # purple
    (153, 153, 51),  # olive
    (136, 34, 85),  # wine
    (68, 170, 153),  # teal
    (213, 94, 0),  # vermilion
    (96, 96, 104),  # slate
)
CLASS_SHAPES: tuple[Shape, ...] = ("circle", "diamond", "triangle", "square")

_RD_BU = "67001f b2182b d6604d f4a582 fddbc7 f7f7f7 d1e5f0 92c5de 4393c3 2166ac 053061"
_BR_BG = "543005 8c510a bf812d d0a75c d0bd8e bcbdb8 93c4bb 5cb0a3 35978f 01665e 003c30"
_VIRIDIS = "eed81f b5de2b 6ece58 35b779 1f9e89 26828e 31688e 3e4989 482878 440154"


def _table(anchors: str, steps: int = 255) -> NDArray[np.uint8]:
    """(steps, 3) uint8: the anchors, evenly spread and linearly blended."""
    colors = np.array([[int(a[i : i + 2], 16) for i in (0, 2, 4)] for a in anchors.split()], float)
    at = np.linspace(0, len(colors) - 1, steps)
    columns = [np.interp(at, np.arange(len(colors)), colors[:, c]) for c in range(3)]
    table: NDArray[np.uint8] = np.rint(np.stack(columns, axis=1)).astype(np.uint8)
    table.flags.writeable = False
    return table


CORRELATION = _table(_RD_BU)  # an odd number of steps: 0 has an entry of its own
VALENCE = _table(_BR_BG)
AROUSAL = _table(_VIRIDIS)


def scale_colors(
    values: ArrayLike, table: NDArray[np.uint8], low: float, high: float
) -> NDArray[np.uint8]:
    """(..., 3) colours of values on a scale; what is outside gets its end, NaN gets `UNKNOWN`."""
    array = np.asarray(values, dtype=np.float64)
    known = np.isfinite(array) | np.isinf(array)
    share = np.clip((np.where(known, array, low) - low) / (high - low), 0.0, 1.0)
    colors = table[np.rint(share * (len(table) - 1)).astype(np.intp)]
    result: NDArray[np.uint8] = np.where(
        known[..., None], colors, np.array(UNKNOWN, dtype=np.uint8)
    )
    return result


def correlation_colors(correlation: ArrayLike) -> NDArray[np.uint8]:
    """(..., 3) colours of correlations in [-1, 1]: red -1, white 0, blue 1, grey for NaN."""
    return scale_colors(correlation, CORRELATION, -1.0, 1.0)


Scale = Literal["valence", "arousal"]
SCALES: dict[Scale, NDArray[np.uint8]] = {"valence": VALENCE, "arousal": AROUSAL}


@dataclass(frozen=True)
class Legend:
    """What the colours of the points mean: a caption, or a scale with a word for either end."""

    caption: str = ""
    scale: Scale | None = None
    low: str = ""
    high: str = ""

    @property
    def table(self) -> NDArray[np.uint8]:
        """(K, 3) the scale's colours from low to high; no rows where there is no scale."""
        return SCALES[self.scale] if self.scale else np.empty((0, 3), dtype=np.uint8)


@dataclass(frozen=True)
class PointStyle:
    """How each of N points looks.

    rgb: (N, 3) uint8. shapes: N marker shapes.
    """

    rgb: NDArray[np.uint8]
    shapes: tuple[Shape, ...]
    legend: Legend


def style_points(
    by: ColorBy,
    *,
    classes: Sequence[str] = (),
    values: Sequence[float | None] | NDArray[np.floating] = (),
) -> PointStyle:
    """Colours and shapes of points.

    Args:
        by: what the colour says.
        classes: N behaviour classes, for `by="class"`; equal ones look equal, in any order.
        values: N ratings from 0 to 1, for valence and arousal; None or NaN where there is none.
    """
    if by == "class":
        hues, shapes = len(CLASS_HUES), len(CLASS_SHAPES)
        rank = {name: i for i, name in enumerate(sorted(set(classes)))}
        ranks = [rank[name] for name in classes]
        rgb = np.array([CLASS_HUES[i % hues] for i in ranks], np.uint8).reshape(-1, 3)
        marks: tuple[Shape, ...] = tuple(CLASS_SHAPES[i // hues % shapes] for i in ranks)
        return PointStyle(rgb, marks, Legend("colour and shape: behaviour class"))
    numbers = np.array([np.nan if v is None else float(v) for v in values], dtype=np.float64)
    rgb = scale_colors(numbers, SCALES[by], 0.0, 1.0)
    ends = ("negative", "positive") if by == "valence" else ("calm", "excited")
    return PointStyle(rgb, _circles(len(rgb)), Legend(by, by, *ends))


def plain_points(count: int, color: Color = CLASS_HUES[0]) -> PointStyle:
    """One look for all of `count` points: nothing is known of them but where they are."""
    rgb = np.tile(np.array(color, dtype=np.uint8), (count, 1))
    return PointStyle(rgb, _circles(count), Legend())


def _circles(count: int) -> tuple[Shape, ...]:
    circle: Shape = "circle"
    return (circle,) * count


@lru_cache(maxsize=64)
def font(size: int, *, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Inter at a size in pixels; it ships because Pillow's own font lacks μ, σ, × and −."""
    name = "Inter-ExtraBold.ttf" if bold else "Inter-SemiBold.ttf"
    file = resources.files("rnnpb_explorer.static").joinpath("fonts", name)
    return ImageFont.truetype(
        io.BytesIO(file.read_bytes()), size, layout_engine=ImageFont.Layout.BASIC
    )
