"""The panels of Fig. 5, live: density of the PB, mu, sigma and loss over the iterations."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from ...state.on_recognition import shown_iteration
from ...state.picture import Picture
from .bound import assign

COLORS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f")
MOST_LINES = 8  # dimensions; the page of sliders decides which
POINTS = 121  # of a density
REACH = 3.0  # sigma, on both sides
LEAST_SIGMA = 1e-3  # a narrower Gaussian would be a line without a height
HEIGHT = 130

Columns = tuple[NDArray[np.float64], ...]


class RunCurves:
    """Four plots of the trial that is drawn, as far as it has come."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._dimensions = 0
        self._drawn: object = None
        self._density: viser.GuiUplotHandle | None = None
        self._mu: viser.GuiUplotHandle | None = None
        self._sigma: viser.GuiUplotHandle | None = None
        flat = np.array([0.0, 1.0])
        self._loss = gui.add_uplot(
            (flat, flat + 1, flat + 1),
            (
                {"label": "iteration"},
                {"label": "loss", "stroke": COLORS[0], "width": 2},
                {"label": "prediction error", "stroke": COLORS[1], "width": 1, "dash": (4, 4)},
            ),
            title="loss",
            scales={"x": {"time": False}, "y": {"distr": 3}},
            height=HEIGHT + 40,
            visible=False,
        )
        self._folder = gui.add_folder("μ, σ, density")

    def show(self, picture: Picture) -> None:
        run, trace = picture.document.run, picture.trace
        assign(self._loss, visible=trace is not None)
        assign(self._folder, visible=trace is not None)
        if run is None or trace is None:
            self._drawn = None
            return
        first = picture.document.first_slider
        dims = slice(first, first + MOST_LINES)
        revealed = picture.document.revealed
        drawn = (run.seed, run.settings, run.model, trace.iterations, run.trial, run.shown, first)
        if (*drawn, revealed) == self._drawn:
            return
        self._drawn = (*drawn, revealed)
        trial = min(run.trial, trace.loss.shape[1] - 1)
        at = shown_iteration(run, trace)
        mu, sigma = trace.mu[:, trial, dims], trace.sigma[:, trial, dims]
        self._build(mu.shape[1])
        numbers = np.arange(1.0, trace.iterations + 2)
        error = np.maximum(trace.prediction_error[:, trial], 1e-9)
        unseen = np.full(trace.iterations, np.nan)  # nobody has seen the truth yet
        self._draw(
            self._loss,
            (numbers[:-1], np.maximum(trace.loss[:, trial], 1e-9), error if revealed else unseen),
        )
        self._draw(self._mu, (numbers, *mu.T))
        self._draw(self._sigma, (numbers, *sigma.T))
        self._draw(self._density, densities(mu[at], sigma[at]))

    def _build(self, dimensions: int) -> None:
        """Plots with a line for each dimension."""
        if dimensions == self._dimensions:
            return
        self._dimensions = dimensions
        for handle in (self._mu, self._sigma, self._density):
            if handle is not None:
                handle.remove()
        with self._folder:
            self._mu = self._plot("μ", "iteration", dimensions)
            self._sigma = self._plot("σ", "iteration", dimensions)
            self._density = self._plot("density", "PB", dimensions)

    def _plot(self, title: str, x: str, lines: int) -> viser.GuiUplotHandle:
        flat = np.array([0.0, 1.0])
        series = [
            {"label": f"{title} {line + 1}", "stroke": COLORS[line % len(COLORS)], "width": 1}
            for line in range(lines)
        ]
        return self._gui.add_uplot(
            (flat, *[flat] * lines),
            ({"label": x}, *series),  # type: ignore[arg-type]
            title=title,
            scales={"x": {"time": False}},
            height=HEIGHT,
        )

    @staticmethod
    def _draw(handle: viser.GuiUplotHandle | None, columns: Columns) -> None:
        if handle is not None and len(columns[0]) > 1:
            handle.data = columns


def densities(mu: NDArray[np.float64], sigma: NDArray[np.float64]) -> Columns:
    """Values of a PB, and the densities there of N(mu_d, sigma_d^2), (D,) each."""
    wide = np.maximum(sigma, LEAST_SIGMA)
    x = np.linspace((mu - REACH * wide).min(), (mu + REACH * wide).max(), POINTS)
    z = (x - mu[:, None]) / wide[:, None]
    return x, *(np.exp(-0.5 * z**2) / (wide[:, None] * np.sqrt(2 * np.pi)))
