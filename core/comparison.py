"""Models side by side: how smooth each latent space is, over the same pairs of motions.

Absolute and per standard deviation of each model's own learned mu, so that one sees how much of a
difference is scale. The definitions are in smoothness.py, those of the landscape in windows.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from .correlation import landscape
from .errors import InputError
from .latent_map import spread
from .model import RNNPB
from .smoothness import FRAMES, jerk, shortest, straight, stretch, walk
from .windows import WINDOW_RADIUS, Window, window_radius

PAIRS = 24


@dataclass(frozen=True)
class Values:
    """Of all pairs, or of all motions in them: mean, standard deviation, median."""

    mean: float
    sd: float
    median: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Values:
        """NaN (of a pair whose ends are one motion, say) is left out."""
        known = np.array([value for value in values if np.isfinite(value)], dtype=np.float64)
        if not len(known):
            return cls(float("nan"), float("nan"), float("nan"))
        return cls(float(known.mean()), float(known.std()), float(np.median(known)))


@dataclass(frozen=True)
class WindowMeasures:
    """A window's landscapes: the three measures of `Landscape`."""

    mean: Values
    area: Values
    roughness: Values


@dataclass(frozen=True)
class Smoothness:
    """One model's.

    mu_sd: standard deviation of its learned mu. stretch, stretch_between: in degrees of mean joint
    angle a unit of mu, at the learned mu and half-way between two; .._per_sd: the same times mu_sd.
    condition: of the Jacobian at the learned mu. jerk: see smoothness.py.
    """

    mu_sd: float
    landscapes: dict[Window, WindowMeasures]
    stretch: Values
    stretch_per_sd: Values
    stretch_between: Values
    stretch_between_per_sd: Values
    condition: Values
    wander: Values
    cliff: Values
    detour: Values
    jerk: Values


Pairs = Sequence[tuple[str, str]]


def shared_pairs(
    models: Sequence[RNNPB],
    motion: str | None = None,
    to: str | None = None,
    count: int = PAIRS,
    seed: int = 0,
) -> list[tuple[str, str]]:
    """Pairs of motions that all models have learnt, by name: of one motion with another, of one
    with `count` others, or `count` random ones.

    Raises:
        InputError: a model has other joints, or does not know a motion; too few are known to all.
    """
    joints = models[0].info.joints
    for model in models[1:]:
        if model.info.joints != joints:
            raise InputError("these models have other joints: their motions cannot be compared")
    names = [_name(models[0], index) for index in range(models[0].config.num_motions)]
    known = [name for name in names if all(_knows(model, name) for model in models)]
    for name in (motion, to):
        if name is not None:
            for model in models:
                model.motion_index(name)
    others = [name for name in known if name != motion]
    if motion is not None and to is not None:
        return [(motion, to)]
    if len(known) < 2 or not others:
        raise InputError("these models have fewer than two motions in common")
    random = np.random.default_rng(seed)
    if motion is not None:
        chosen = random.permutation(len(others))[:count]
        return [(motion, others[index]) for index in chosen]
    pairs: list[tuple[str, str]] = []
    for _ in range(count):
        first, second = random.choice(len(known), 2, replace=False)
        pairs.append((known[first], known[second]))
    return pairs


def _name(model: RNNPB, index: int) -> str:
    return model.info.motions[index] if model.info.motions else str(index)


def _knows(model: RNNPB, name: str) -> bool:
    try:
        model.motion_index(name)
    except InputError:
        return False
    return True


def smoothness(model: RNNPB, pairs: Pairs, done: Callable[[], object] = lambda: None) -> Smoothness:
    """Measure a model on pairs of its motions.

    Args:
        done: called after each pair.
    """
    mu = model.mu.detach()
    scale = spread(mu.cpu())
    ends = {name: model.motion_index(name) for pair in pairs for name in pair}
    at = {name: stretch(model, mu[index]) for name, index in ends.items()}
    walks, between, detours, jerks = [], [], [], []
    for first, second in pairs:
        start, end = mu[ends[first]], mu[ends[second]]
        way = walk(model, straight(start, end))
        walks.append(way)
        between.append(np.rad2deg(stretch(model, (start + end) / 2).largest))
        best = shortest(model, start, end)
        detours.append(way.length / best.length if best.length > 0 else float("nan"))
        three = model.generate(torch.stack([(start + end) / 2, start, end]), FRAMES)
        middle, *tips = (jerk(motion.detach().cpu().numpy()) for motion in three)
        jerks.append(middle - float(np.mean(tips)))
        done()
    largest = [float(np.rad2deg(each.largest)) for each in at.values()]
    return Smoothness(
        mu_sd=scale,
        landscapes={window: _landscapes(model, ends, window) for window in WINDOW_RADIUS},
        stretch=Values.of(largest),
        stretch_per_sd=Values.of([value * scale for value in largest]),
        stretch_between=Values.of(between),
        stretch_between_per_sd=Values.of([value * scale for value in between]),
        condition=Values.of([each.condition for each in at.values()]),
        wander=Values.of([way.wander for way in walks]),
        cliff=Values.of([way.cliff for way in walks]),
        detour=Values.of(detours),
        jerk=Values.of(jerks),
    )


def _landscapes(model: RNNPB, ends: dict[str, int], window: Window) -> WindowMeasures:
    """Around each motion's learned mu, compared with its own reconstruction at sigma = 0."""
    radius = window_radius(model.mu.detach().cpu(), window)
    found = [
        landscape(
            model,
            model.reconstruct(index).cpu().numpy(),
            model.mu[index].detach().cpu().numpy(),
            radius=radius,
        )
        for index in ends.values()
    ]
    return WindowMeasures(
        *(
            Values.of([getattr(one, name) for one in found])
            for name in ("mean", "area", "roughness")
        )
    )
