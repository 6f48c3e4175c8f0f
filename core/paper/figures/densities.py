"""Fig. 2: the PB's Gaussians of some motions; the smaller β, the narrower."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...model import RNNPB
from .style import TEXT_WIDTH, component_color, label_outside, panel_title, use_style

CURVE_POINTS = 121
REACH = 4.0  # standard deviations that a curve extends to both sides


def densities_figure(models: Mapping[str, RNNPB], motions: Sequence[str]) -> Figure:
    """A row for each stochastic model, a column for each motion, a curve for each component.

    Args:
        models: by the name to print.
        motions: names that every model knows.
    """
    shown = {name: model for name, model in models.items() if model.stochastic}
    with use_style():
        figure = Figure(figsize=(TEXT_WIDTH, 0.35 + 1.15 * len(shown)), layout="constrained")
        parts = figure.subfigures(len(shown), 1, squeeze=False)[:, 0]
        for letter, (part, (name, model)) in enumerate(zip(parts, shown.items(), strict=True)):
            part.suptitle(panel_title(letter, name, model), fontsize=8, x=0.01, ha="left")
            row = part.subplots(1, len(motions), squeeze=False, sharex=True, sharey=True)[0]
            for axes, motion in zip(row, motions, strict=True):
                index = model.motion_index(motion)
                draw_densities(
                    axes, model.mu[index].detach().numpy(), model.sigma[index].detach().numpy()
                )
                axes.set_title(motion, parse_math=False)
            row[0].set_ylim(bottom=0.0)  # of the whole row, whose highest curve is drawn by now
            label_outside([row], "PB", "density")
    return figure


def draw_densities(axes: Axes, mu: NDArray[np.float32], sigma: NDArray[np.float32]) -> None:
    """The densities of N(mu_d, sigma_d^2), (D,) each, over the values of a PB."""
    for component, (m, s) in enumerate(zip(mu.tolist(), sigma.tolist(), strict=True)):
        if s == 0:  # all of it is in one place
            axes.axvline(m, color=component_color(component), linewidth=0.9)
            continue
        z = np.linspace(-REACH, REACH, CURVE_POINTS)
        density = np.exp(-0.5 * z**2) / (s * np.sqrt(2 * np.pi))
        axes.plot(m + s * z, density, color=component_color(component), linewidth=0.9)
    axes.grid(True)
