"""What kind of latent space a model has: its scale, its uncertainty, and how smooth it is.

A low error alone does not say whether a model is like the published ones: a deterministic one packs
its PBs closely and has a rugged landscape, a strong prior makes it smooth (section IV.B, Fig. 4).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..correlation import landscape
from ..latent_map import spread
from ..model import RNNPB
from ..motion import Motion
from ..windows import WINDOW_RADIUS, Landscape, Window, window_radius

EVERY = 3  # every third motion by name: 24 of 72


def landscape_count(motions: int) -> int:
    """How many landscapes `structure` takes."""
    return len(range(0, motions, EVERY)) * len(WINDOW_RADIUS)


@dataclass(frozen=True)
class LandscapeMeans:
    """`Landscape`'s three measures, averaged over motions."""

    mean: float
    area: float
    roughness: float


@dataclass(frozen=True)
class Structure:
    """mu_sd: see `spread`; sigma: the mean of all; both in units of the PB."""

    mu_sd: float
    sigma: float
    landscapes: dict[Window, LandscapeMeans]  # along the first two components, at sigma = 0


def structure(
    model: RNNPB, motions: Sequence[Motion], drawn: Callable[[], object] = lambda: None
) -> Structure:
    """Measure a model on its training motions, every third of them.

    Args:
        motions: in the order of the model's PBs.
        drawn: called after each landscape.
    """

    def around(index: int, window: Window) -> Landscape:
        center = model.mu[index].detach().cpu().numpy()
        radius = window_radius(model.mu.detach().cpu(), window)
        result = landscape(model, motions[index].positions, center, radius=radius)
        drawn()
        return result

    chosen = range(0, len(motions), EVERY)
    return Structure(
        mu_sd=spread(model.mu.detach().cpu()),
        sigma=float(model.sigma.mean()) if model.stochastic else 0.0,
        landscapes={
            window: _means([around(index, window) for index in chosen]) for window in WINDOW_RADIUS
        },
    )


def _means(landscapes: Sequence[Landscape]) -> LandscapeMeans:
    return LandscapeMeans(
        *(
            float(np.mean([getattr(each, name) for each in landscapes]))
            for name in ("mean", "area", "roughness")
        )
    )
