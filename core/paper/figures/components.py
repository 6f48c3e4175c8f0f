"""Fig. 3: samples of every motion's PB on the first two principal components of the learned μ."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...latent_map import LatentMap
from ...model import RNNPB
from .style import TEXT_WIDTH, panel_title, sequence_colors, use_style

Array = NDArray[np.floating]
SAMPLES = 100  # a motion, as in the paper
MAX_LABELS = 100  # more names than that cannot be read


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
        figure.draw_without_rendering()  # settles where the axes are, and how far they reach
        for axes, model in zip(panels, models.values(), strict=False):
            if model.config.num_motions <= MAX_LABELS:
                _label(axes, model)
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


def _label(axes: Axes, model: RNNPB) -> None:
    """Names beside their points: one after the other where it covers least, with a line there."""
    x, y = _plane(LatentMap.fit(model.mu.detach().numpy()).points)
    texts = [
        axes.text(
            x[i],
            y[i],
            model.motion_name(i),
            fontsize=4.0,
            zorder=4,
            parse_math=False,
            in_layout=False,
        )
        for i in range(len(x))
    ]
    axes.autoscale(False)
    sizes = np.array([text.get_window_extent().size for text in texts])  # pixels
    points = axes.transData.transform(np.column_stack([x, y]))
    frame = np.array([axes.bbox.extents])
    dot = 0.3 * sizes[:, 1].max()
    taken = np.column_stack([points - dot, points + dot])  # left, bottom, right, top of each
    for text, point, size in zip(texts, points, sizes, strict=True):
        low = point + _beside(size, dot) - size / 2
        boxes = np.column_stack([low, low + size])
        covered = _overlaps(boxes, taken).sum(axis=1)
        outside = size.prod() - _overlaps(boxes, frame)[:, 0]
        away = np.linalg.norm(low + size / 2 - point, axis=1)
        best = int((covered + outside + 0.02 * size[1] * away).argmin())
        taken = np.concatenate([taken, boxes[best : best + 1]])
        middle = low[best] + size / 2
        text.set(ha="center", va="center", position=axes.transData.inverted().transform(middle))
        if away[best] > size.max():
            ends = axes.transData.inverted().transform([point, middle])
            axes.plot(*ends.T, color="#777777", linewidth=0.25, zorder=2)


def _beside(size: Array, dot: float) -> Array:
    """(C, 2) where a label's middle may be from its point: rings of places, the nearest first."""
    angles = np.arange(0, 2 * np.pi, np.pi / 8)
    way = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [way * (size / 2 + dot + gap * size[1]) for gap in (0.2, 1.0, 2.0, 3.5, 5.0)]
    places: Array = np.concatenate(rings)
    return places


def _overlaps(boxes: Array, others: Array) -> Array:
    """(B, O) the areas that boxes (B, 4) and others (O, 4) share."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    areas: Array = np.clip(high - low, 0, None).prod(axis=2)
    return areas


def _plane(coordinates: Array) -> tuple[Array, Array]:
    """The first two of (..., D) map coordinates; zeros for the second where there is one."""
    first = coordinates[..., 0]
    return first, coordinates[..., 1] if coordinates.shape[-1] > 1 else np.zeros_like(first)
