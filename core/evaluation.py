"""How well a model reproduces the motions it was trained on (Table I), or a part of a body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from .codebook import Codebook
from .errors import InputError
from .model import RNNPB
from .motion import Motion
from .observation import Observation
from .recognition_lm import LMConfig, recognize_lm
from .recognition_run import RecognitionResult


def reconstruction(
    model: RNNPB, motions: Sequence[Motion], samples: int = 100, seed: int = 0
) -> tuple[float, float]:
    """Mean and standard deviation of the error over N motions x `samples` sampled PBs (Table I).

    The error of a sample is squared and averaged over frames and joints. Of a deterministic model
    every sample would be the same; it is generated once.

    Args:
        motions: the N training motions in the order of the model's PBs.

    Raises:
        InputError: other motions than the model's, or no samples.
    """
    if samples < 1:
        raise InputError(f"samples must be at least 1, got {samples}")
    errors = _errors(model, motions, samples if model.stochastic else 1, seed)
    return float(errors.mean()), float(errors.std())


def reconstruction_at_mean(model: RNNPB, motions: Sequence[Motion]) -> NDArray[np.float64]:
    """(N,) error of each motion, averaged over frames and joints, at its mu and sigma = 0."""
    return _errors(model, motions, 0, 0)[:, 0]


@dataclass(frozen=True)
class HiddenJoints:
    """Errors over N training motions, recognised with all joints and with some: mean, median.

    seen: of the observed joints. hidden: of the others, inferred. hidden_if_seen: of the same where
    all joints are observed. All squared, averaged over all frames.
    """

    seen: tuple[float, float]
    hidden: tuple[float, float]
    hidden_if_seen: tuple[float, float]


def hidden_joints(
    model: RNNPB,
    motions: Sequence[Motion],
    joints: Sequence[int],
    codebook: Codebook,
    done: Callable[[], object] = lambda: None,
) -> HiddenJoints:
    """What a model makes of the rest of the body.

    Args:
        joints: indices of those that are observed.
        done: called after each motion.
    """
    seen = list(joints)
    hidden = [joint for joint in range(model.config.num_joints) if joint not in seen]
    errors = []
    for motion in motions:
        row = []
        for observed in (seen, []):
            config = LMConfig(joints=tuple(observed))
            steps = recognize_lm(model, motion.positions, config, codebook=codebook)
            result = RecognitionResult.from_steps(steps)
            error = np.square(result.best_output[result.best_trial] - motion.positions)
            row += [error[:, seen].mean(), error[:, hidden].mean()]
        errors.append((row[0], row[1], row[3]))
        done()
    values = np.array(errors, dtype=np.float64)
    means, medians = values.mean(axis=0), np.median(values, axis=0)
    return HiddenJoints(*((float(a), float(b)) for a, b in zip(means, medians, strict=True)))


@torch.no_grad()
def _errors(
    model: RNNPB, motions: Sequence[Motion], samples: int, seed: int
) -> NDArray[np.float64]:
    """(N, samples) errors; (N, 1) those at sigma = 0 where there are no samples."""
    if len(motions) != model.config.num_motions:
        raise InputError(
            f"the data has {len(motions)} motions, the model {model.config.num_motions} PBs"
        )
    random = np.random.default_rng(seed)
    rows = []
    for mu, sigma, motion in zip(model.mu, model.sigma, motions, strict=True):
        if len(motion.joints) != model.config.num_joints:
            raise InputError(
                f"motion {motion.name!r} has {len(motion.joints)} joints, "
                f"the model {model.config.num_joints}"
            )
        noise = random.standard_normal((samples, len(mu))) if samples else np.zeros((1, len(mu)))
        pbs = mu + sigma * torch.as_tensor(noise).to(mu)
        losses = Observation.of(model, motion.positions).losses_of(model, pbs)
        rows.append(losses.double().cpu().numpy())
    return np.stack(rows)
