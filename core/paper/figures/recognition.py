"""Fig. 5: a recognition at three of its iterations. Fig. 6: the belief's way in four trials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from ...latent_map import LatentMap
from ...model import RNNPB
from ...motion import Motion
from ...recognition_run import RecognitionResult, RecognitionStep
from .densities import draw_densities
from .style import (
    BLUE,
    GREEN,
    GREY,
    OBSERVED,
    ORANGE,
    RED,
    TEXT_WIDTH,
    component_color,
    panel_title,
    sequence_colors,
    use_style,
)

UNIT_CIRCLE = 60.0  # points^2: the circle of sigma = 1


def iterations_figure(
    name: str,
    model: RNNPB,
    target: Motion,
    steps: Sequence[RecognitionStep],
    shown: Sequence[int] = (0, 45, 90),
    observed: float = 0.8,
    beta: float = 0.0,
) -> Figure:
    """A row for each of the iterations `shown` of one trial.

    The columns: density of the PB, mu and sigma over the iterations, the loss, the motion.

    Args:
        steps: all iterations of one trial, in order.
        beta: weight of the KL term while recognising.
    """
    weight = model.config.beta
    trained = "" if weight is None else f", β = {weight:g}"
    with use_style():
        figure = Figure(figsize=(TEXT_WIDTH, 0.45 + 1.3 * len(shown)), layout="constrained")
        figure.suptitle(f"{name}{trained}: recognising {target.name}", fontsize=8)
        grid = figure.subplots(
            len(shown), 5, squeeze=False, width_ratios=(1, 1, 1, 1, 3), sharex="col"
        )
        for axes, title in zip(grid[0], ("PB", "μ", "σ", "loss"), strict=False):
            axes.set_title(title, fontsize=8)
        for row, iteration in zip(grid, shown, strict=True):
            row[0].set_ylabel(f"s = {iteration}", fontsize=8)
            _draw_iteration(row, steps[: iteration + 1], beta / len(target.joints))
            _draw_motion(row[4], target, steps[iteration], observed)
        _same_range(grid[:, 1:4])
        for axes, label in zip(
            grid[-1], ("PB", "iteration", "iteration", "iteration", "frame"), strict=True
        ):
            axes.set_xlabel(label)
        kl = "KL divergence (no part of the loss here)"
        if beta:
            kl = f"{beta:g}/{len(target.joints)} × KL divergence"
        handles = [
            Line2D([], [], color=BLUE, label="reconstruction loss"),
            Line2D([], [], color=ORANGE, label=kl),
            Line2D([], [], color="black", label="generated"),
            Line2D([], [], color="black", linestyle="--", label="target"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    return figure


def _draw_iteration(row: Sequence[Axes], steps: Sequence[RecognitionStep], weight: float) -> None:
    """The belief as the last of `steps` found it, and how it and the loss came there."""
    now = steps[-1]
    numbers = [step.iteration for step in steps]
    draw_densities(row[0], now.mu[0], now.sigma[0])
    row[0].set_ylim(bottom=0.0)
    for axes, values in (
        (row[1], np.stack([step.mu[0] for step in steps])),
        (row[2], np.stack([step.sigma[0] for step in steps])),
    ):
        for component in range(values.shape[1]):
            axes.plot(numbers, values[:, component], color=component_color(component))
    row[3].plot(numbers, [float(step.loss[0]) for step in steps], color=BLUE)
    kl = [weight * float(step.kl[0]) if weight else 0.0 for step in steps]
    row[3].plot(numbers, kl, color=ORANGE)
    for axes in row[1:4]:
        axes.grid(True)
        for line in axes.lines:
            line.set_marker("." if len(steps) == 1 else "")  # a line of one point cannot be seen


def _same_range(columns: NDArray[np.object_]) -> None:
    """Give all rows of a column the range of its last row, which has all that the others have."""
    for column in columns.T:
        for axes in column:
            axes.set_xlim(column[-1].get_xlim())
            axes.set_ylim(column[-1].get_ylim())


def _draw_motion(axes: Axes, target: Motion, step: RecognitionStep, observed: float) -> None:
    frames = np.arange(len(target))
    boundary = int(observed * len(target))
    axes.axvspan(0, boundary, color=OBSERVED, linewidth=0)
    axes.axvline(boundary, color=GREY, linewidth=0.6, linestyle=":")
    for joint, color in enumerate(sequence_colors(len(target.joints))):
        axes.plot(frames, step.output[0, :, joint], color=color, linewidth=0.8)
        axes.plot(frames, target.positions[:, joint], "--", color=color, linewidth=0.6)
    axes.set_xlim(0, len(target) - 1)
    axes.set_ylabel(f"{len(target.joints)} joints")
    axes.text(
        observed / 2, 1.0, "observed", transform=axes.transAxes, ha="center", va="bottom", size=6
    )
    axes.text(
        (1 + observed) / 2,
        1.0,
        "predicted",
        transform=axes.transAxes,
        ha="center",
        va="bottom",
        size=6,
    )


def paths_figure(recognitions: Mapping[str, tuple[RNNPB, RecognitionResult]]) -> Figure:
    """A row for each model, by the name to print, a column for each trial of its recognition.

    Red: mu, a circle at every iteration whose area is the mean variance; a point where it starts,
    a cross where it ends. Green crosses: the sampled PBs. Grey: the learned mu.
    """
    trials = max(len(result.loss) for _, result in recognitions.values())
    width = TEXT_WIDTH / trials
    height = 0.35 + (width + 0.25) * len(recognitions)
    with use_style():
        figure = Figure(figsize=(TEXT_WIDTH, height), layout="constrained")
        parts = figure.subfigures(len(recognitions), 1, squeeze=False)[:, 0]
        for letter, (part, (name, (model, result))) in enumerate(
            zip(parts, recognitions.items(), strict=True)
        ):
            part.suptitle(panel_title(letter, name, model), fontsize=8, x=0.01, ha="left")
            row = part.subplots(1, trials, squeeze=False, sharex=True, sharey=True)[0]
            for trial, axes in enumerate(row):
                _draw_path(axes, model, result, trial)
                axes.set_title(f"trial {trial + 1}")
                axes.set_xlabel("PC 1")
            row[0].set_ylabel("PC 2")
    return figure


def _draw_path(axes: Axes, model: RNNPB, result: RecognitionResult, trial: int) -> None:
    latent_map = LatentMap.fit(model.mu.detach().numpy())

    def plane(pbs: NDArray[np.floating]) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
        points = latent_map.project(pbs)
        return points[:, 0], points[:, 1] if points.shape[1] > 1 else np.zeros(len(points))

    axes.scatter(*plane(model.mu.detach().numpy()), s=4, color=GREY, linewidths=0, alpha=0.7)
    if model.stochastic:
        x, y = plane(result.pb[trial])
        axes.scatter(x, y, s=7, marker="x", color=GREEN, linewidths=0.5, alpha=0.8)
    x, y = plane(result.mu[trial])
    axes.plot(x, y, color=RED, linewidth=0.7)
    variance = np.square(result.sigma[trial]).mean(axis=1)  # (I + 1,)
    axes.scatter(x, y, s=UNIT_CIRCLE * variance, color=RED, alpha=0.12, linewidths=0)
    axes.scatter(x[:1], y[:1], s=14, color=RED, zorder=3)
    axes.scatter(x[-1:], y[-1:], s=22, marker="x", color=RED, linewidths=1.2, zorder=3)
    axes.grid(True)
