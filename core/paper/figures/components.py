"""Fig. 3: samples of every motion's PB on the first two principal components of the learned μ."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from adjustText import adjust_text
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...latent_map import LatentMap
from ...model import RNNPB
from .style import TEXT_WIDTH, panel_title, sequence_colors, use_style

Array = NDArray[np.floating]
SAMPLES = 100  # a motion, as in the paper
MAX_LABELS = 100  # more names than that cannot be read
LABEL_STEPS = 150  # of moving labels apart; counted, so that the picture does not depend on speed


def components_figure(models: Mapping[str, RNNPB], seed: int = 0) -> Figure:
    """A panel for each model, by the name to print; a deterministic one has only its points."""
    columns = min(2, len(models))
    rows = -(-len(models) // columns)
    side = TEXT_WIDTH / columns
    with use_style():
        figure = Figure(figsize=(TEXT_WIDTH, side * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for letter, (axes, (name, model)) in enumerate(zip(panels, models.items(), strict=False)):
            axes.set_title(panel_title(letter, name, model), loc="left", fontsize=8)
            _draw(axes, model, np.random.default_rng(seed))
        for unused in panels[len(models) :]:
            unused.remove()
    return figure


def _draw(axes: Axes, model: RNNPB, random: np.random.Generator) -> None:
    mu, sigma = model.mu.detach().numpy(), model.sigma.detach().numpy()
    latent_map = LatentMap.fit(mu)
    first, second = _plane(latent_map.points)
    colors = sequence_colors(len(mu))
    if model.stochastic:
        pbs = mu[:, None] + sigma[:, None] * random.standard_normal((len(mu), SAMPLES, mu.shape[1]))
        x, y = _plane(latent_map.project(pbs))
        # As pixels in the SVG, too: thousands of circles would make it slow to open.
        axes.scatter(
            x.ravel(),
            y.ravel(),
            s=2.0,
            color=np.repeat(colors, SAMPLES, axis=0),
            alpha=0.35,
            linewidths=0,
            rasterized=True,
        )
    axes.scatter(first, second, s=6.0, color=colors, linewidths=0.3, edgecolors="white", zorder=3)
    share = latent_map.scale**2 / max(float((latent_map.scale**2).sum()), 1e-12)
    axes.set_xlabel(f"PC 1 ({share[0]:.0%} of the variance)")
    axes.set_ylabel(f"PC 2 ({share[1]:.0%})" if len(share) > 1 else "")
    axes.grid(True)
    if len(mu) <= MAX_LABELS:
        _label(axes, model, first, second)


def _label(axes: Axes, model: RNNPB, x: Array, y: Array) -> None:
    texts = [
        axes.text(x[i], y[i], model.motion_name(i), fontsize=4.0, zorder=4, parse_math=False)
        for i in range(len(x))
    ]
    # The labels must be settled where the axes will be; constrained layout moves axes later.
    axes.figure.canvas.draw()
    adjust_text(
        texts,
        x=x,
        y=y,
        ax=axes,
        iter_lim=LABEL_STEPS,
        arrowprops={"arrowstyle": "-", "color": "#777777", "linewidth": 0.25},
    )


def _plane(coordinates: Array) -> tuple[Array, Array]:
    """The first two of (..., D) map coordinates; zeros for the second where there is one."""
    first = coordinates[..., 0]
    return first, coordinates[..., 1] if coordinates.shape[-1] > 1 else np.zeros_like(first)
