"""What the figures share: sizes, colours, and how one is written."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.colors import hsv_to_rgb
from matplotlib.figure import Figure

from ...files import replacing

if TYPE_CHECKING:
    from ...model import RNNPB

FORMATS = ("png", "svg")
DOTS_PER_INCH = 200
TEXT_WIDTH = 7.16  # inches: both columns of the paper's page
BASE_STYLE: dict[Any, Any] = {
    "font.size": 7.0,
    "axes.titlesize": 7.0,
    "axes.labelsize": 7.0,
    "xtick.labelsize": 6.0,
    "ytick.labelsize": 6.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlepad": 3.0,
    "axes.labelpad": 2.0,
    "axes.axisbelow": True,
    "xtick.major.pad": 2.0,
    "ytick.major.pad": 2.0,
    "xtick.major.size": 2.0,
    "ytick.major.size": 2.0,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.0,
    "svg.hashsalt": "rnnpb",  # the same figure is the same file
}
# The paper draws the PB's components in red, green, yellow and light blue; these keep their order
# and tell apart in print and for colour-blind readers (Okabe and Ito).
COMPONENT_COLORS = ("#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7", "#0072b2", "#999933")
RED, GREEN, GREY = "#d62728", "#2ca02c", "#9a9a9a"  # of the belief, its samples, what is learned
BLUE, ORANGE, OBSERVED = "#1f77b4", "#ff7f0e", "#e4f0fb"
GOLDEN_ANGLE = 0.381966  # of a turn: neighbours in the list are far apart in hue


def component_color(index: int) -> str:
    return COMPONENT_COLORS[index % len(COMPONENT_COLORS)]


def sequence_colors(count: int) -> list[tuple[float, float, float]]:
    """A colour for each motion, as distinct as 72 of them can be."""
    return [
        tuple(hsv_to_rgb((index * GOLDEN_ANGLE % 1.0, 0.75, (0.9, 0.6, 0.75)[index % 3])))
        for index in range(count)
    ]


def write_figure(figure: Figure, folder: str | os.PathLike[str], name: str) -> list[str]:
    """Write `name` in every format; returns the paths. An existing file is replaced whole."""
    paths = []
    for suffix in FORMATS:
        path = os.path.join(folder, f"{name}.{suffix}")
        with replacing(path) as beside, use_style():
            metadata = {"Date": None} if suffix == "svg" else None
            figure.savefig(beside, dpi=DOTS_PER_INCH, format=suffix, metadata=metadata)
        figure.set_layout_engine("none")  # what is laid out stays where it is
        paths.append(path)
    return paths


def panel_title(letter: int, name: str, model: RNNPB) -> str:
    """`(a) strong, β = 0.001`."""
    beta = "" if model.config.beta is None else f", β = {model.config.beta:g}"
    return f"({chr(ord('a') + letter)}) {name}{beta}"


def use_style() -> AbstractContextManager[None]:
    """The figures' style, for a `with` statement; nothing outside it changes."""
    return matplotlib.rc_context(BASE_STYLE)


def label_outside(rows: Sequence[Sequence[Axes]], x: str, y: str) -> None:
    """Axis labels along the lower and the left edge of a grid of axes only."""
    for axes in rows[-1]:
        axes.set_xlabel(x)
    for row in rows:
        row[0].set_ylabel(y)
