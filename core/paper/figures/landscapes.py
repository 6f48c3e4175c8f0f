"""Fig. 4: correlation landscapes; one alone, or models by motions."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ...correlation import landscape
from ...model import RNNPB
from ...motion import Motion
from ...windows import WINDOW_RADIUS, Landscape, Window, window_radius
from .style import TEXT_WIDTH, label_outside, panel_title, use_style

COLORS = "RdBu"  # perceptual and diverging; blue is alike, red opposite, as in the paper's Fig. 4
DOTS_PER_INCH = 150
GRID = 20


def draw_landscape(
    landscape: Landscape, path: str | os.PathLike[str], title: str, axis_names: list[str]
) -> None:
    """One landscape as in Fig. 4, its colours fixed to -1..1, its axes in real values."""
    figure = Figure(figsize=(5.6, 4.8), layout="constrained")
    axes = figure.add_subplot()
    mesh = _draw_cells(axes, landscape)
    axes.set_title(
        f"{title}\nmean {landscape.mean:.3f}, area {landscape.area:.3f}, "
        f"roughness {landscape.roughness:.4f}",
        fontsize=11,
        parse_math=False,
    )
    axes.set_xlabel(axis_names[0])
    flat = len(landscape.y) == 1  # a model of one dimension: a strip without a second axis
    axes.set_ylabel("" if flat else axis_names[1])
    figure.colorbar(mesh, ax=axes, label="Pearson correlation over time, mean of joints")
    figure.savefig(path, dpi=DOTS_PER_INCH, format="png")


def landscapes_figure(
    models: Mapping[str, RNNPB],
    motions: Sequence[Motion],
    window: Window,
    drawn: Callable[[], object] = lambda: None,
) -> Figure:
    """A row for each model, by the name to print, a column for each motion; the first two axes.

    Args:
        motions: training motions that every model knows.
        window: +-1 around the learned mu as in the paper, or +-0.7 standard deviations of the
            model's learned mu, which takes the scale of a model's space out of the comparison.
        drawn: called after each landscape.
    """
    with use_style():
        figure = Figure(figsize=(TEXT_WIDTH, 0.3 + 1.45 * len(models)), layout="constrained")
        parts = figure.subfigures(len(models), 1, squeeze=False)[:, 0]
        rows: list[Sequence[Axes]] = []
        for letter, (part, (name, model)) in enumerate(zip(parts, models.items(), strict=True)):
            radius = window_radius(model.mu.detach().cpu(), window)
            part.suptitle(
                f"{panel_title(letter, name, model)}; window ±{radius:.2g}"
                + (f" = ±{WINDOW_RADIUS['sd']:g} sd of the learned μ" if window == "sd" else "")
                + "; over each landscape: mean / area / roughness",
                fontsize=8,
                x=0.01,
                ha="left",
            )
            row = part.subplots(1, len(motions), squeeze=False)[0]
            for axes, motion in zip(row, motions, strict=True):
                mesh = _draw_one(axes, model, motion, radius)
                drawn()
            label_outside([row], "$μ^{(1)}$", "$μ^{(2)}$" if model.config.pb_dim > 1 else "")
            rows.append(row)
        for part, row in zip(parts, rows, strict=True):
            part.colorbar(mesh, ax=list(row), shrink=0.9, pad=0.01, ticks=[-1, 0, 1])
    return figure


def _draw_one(axes: Axes, model: RNNPB, motion: Motion, radius: float) -> QuadMesh:
    center = model.mu[model.motion_index(motion.name)].detach().numpy()
    result = landscape(model, motion.positions, center, radius=radius, grid=GRID)
    mesh = _draw_cells(axes, result, ticks=3)
    axes.set_title(
        f"{motion.name}\n{result.mean:.2f} / {result.area:.2f} / {result.roughness:.3f}",
        fontsize=6,
        parse_math=False,
    )
    axes.set_box_aspect(1.0)
    return mesh


def _draw_cells(axes: Axes, landscape: Landscape, ticks: int = 5) -> QuadMesh:
    """The cells, their edges along the axes, and where the middle is."""
    mesh = axes.pcolormesh(
        _edges(landscape.x),
        _edges(landscape.y),
        landscape.correlation,
        cmap=COLORS,
        vmin=-1.0,
        vmax=1.0,
        edgecolors="face",  # or viewers show hair lines between the cells of an SVG
        linewidth=0.2,
    )
    axes.xaxis.set_major_locator(MaxNLocator(ticks))
    axes.yaxis.set_major_locator(MaxNLocator(ticks))
    if len(landscape.y) == 1:
        axes.set_yticks([])
    middle = (landscape.x[[0, -1]].mean(), landscape.y[[0, -1]].mean())
    axes.plot(*middle, "o", markersize=3, markerfacecolor="white", markeredgecolor="black", mew=0.7)
    return mesh


def _edges(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(grid,) middles of cells to their (grid + 1,) edges."""
    half = (values[-1] - values[0]) / (len(values) - 1) / 2 if len(values) > 1 else 0.5
    return np.append(values - half, values[-1] + half)
