"""Pictures of results for print: what `rnnpb` draws without a browser."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .landscape import Landscape

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

COLORS = "RdBu"  # perceptual and diverging; blue is alike, red opposite, as in the paper's Fig. 4
DOTS_PER_INCH = 150


def draw_landscape(
    landscape: Landscape, path: str | os.PathLike[str], title: str, axis_names: list[str]
) -> None:
    """One landscape as in Fig. 4, its colours fixed to -1..1, its axes in real values."""
    figure = Figure(figsize=(5.6, 4.8), layout="constrained")
    axes = figure.add_subplot()
    flat = len(landscape.y) == 1  # a model of one dimension: a strip without a second axis
    image = axes.imshow(
        landscape.correlation,
        cmap=COLORS,
        vmin=-1.0,
        vmax=1.0,
        origin="lower",
        extent=(*_edges(landscape.x), *_edges(landscape.y)),
        aspect="auto",
    )
    axes.set_title(
        f"{title}\nmean {landscape.mean:.3f}, area {landscape.area:.3f}, "
        f"roughness {landscape.roughness:.4f}",
        fontsize=11,
        parse_math=False,
    )
    axes.set_xlabel(axis_names[0])
    axes.set_ylabel("" if flat else axis_names[1])
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    if flat:
        axes.set_yticks([])
    middle = (landscape.x[[0, -1]].mean(), landscape.y[[0, -1]].mean())
    axes.plot(*middle, "o", markersize=7, markerfacecolor="white", markeredgecolor="black")
    figure.colorbar(image, ax=axes, label="Pearson correlation over time, mean of joints")
    figure.savefig(path, dpi=DOTS_PER_INCH, format="png")


def _edges(values: NDArray[np.float64]) -> tuple[float, float]:
    """From the left edge of the first cell to the right edge of the last."""
    half = (values[-1] - values[0]) / (len(values) - 1) / 2 if len(values) > 1 else 0.5
    return float(values[0] - half), float(values[-1] + half)
