"""Belief over a codebook: exact Bayes while a motion unfolds, of as many explanations as there are.

Every kept frame adds its squared error, averaged over the observed joints, to a sum for each entry;
exp(-sum / 2 s^2) is the belief. s is the error scale: how far off a right explanation may be. The
joints of a frame err together and count as one observation; the kept frames lie half a second
apart, so that their errors are nearly independent. By default s is 0.1 rad, twice the error that
the models leave on novel motions that they can express (0.05 rad) and well below the one on motions
of another generator (0.27 rad): with a smaller one the belief would rest on one entry after two
frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:  # torch takes seconds to import
    from .codebook import Codebook

ERROR_SCALE = 0.1  # radians
LEAST_SCALE, MOST_SCALE = 0.01, 1.0
MOST_ENTRIES = 1_500  # of a cloud
CLOUD_MASS = 0.995  # of the belief that a cloud shows, where so many entries hold it
# Root mean square, in radians (7°), by which the motions of two explanations differ at least.
DIFFERENT = 0.12
HEAVY = 400  # entries among which explanations are looked for
MODE_MASS = 0.05  # of the belief that an explanation holds at least
MOST_MODES = 3

Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Mode:
    """An explanation of what was observed: a region of the latent space.

    pb: (D,) its best entry. mass: share of the belief round it.
    """

    pb: Array
    mass: float


@dataclass(frozen=True, eq=False)
class Cloud:
    """The belief after each kept frame of an observation.

    frames: (S,) the last frame that is in each. pbs: (M, D) the entries that matter in any of them.
    weights: (S, M) their shares of the belief. entropy: (S,) in bits, log2 of how many entries the
    belief is spread over. modes: the explanations that remain at the end, the likeliest first.
    nearest: (N,) root mean square distance, in radians, of each learned motion from what was seen.
    entries: of the codebook, that were compared.
    """

    frames: NDArray[np.int64]
    pbs: Array
    weights: Array
    entropy: Array
    modes: tuple[Mode, ...]
    nearest: Array
    entries: int


def belief_cloud(
    codebook: Codebook,
    observation: ArrayLike,
    *,
    scale: float = ERROR_SCALE,
    joints: ArrayLike | None = None,
    steps: int = 0,
) -> Cloud:
    """The belief while an observation (T, J) comes in.

    Args:
        scale: s, in radians.
        steps: frames of the whole motion, in which explanations differ; 0: those that are observed.
        joints: indices of those that are observed; None: all.
    """
    steps = max(steps, len(np.asarray(observation)))
    errors = codebook.frame_errors(observation, joints)  # (n, S)
    weights = posterior(errors.cumsum(axis=1, dtype=np.float64), scale)
    last = weights[:, -1]
    shown = _heaviest(weights)
    learned = codebook.model.config.num_motions
    with np.errstate(divide="ignore", invalid="ignore"):
        bits = -np.nansum(weights * np.log2(weights), axis=0)
    pbs: Array = codebook.pbs[: len(errors)].numpy()
    return Cloud(
        frames=np.arange(errors.shape[1]) * codebook.stride,
        pbs=pbs[shown],
        weights=weights[shown].T.astype(np.float32),
        entropy=bits.astype(np.float32),
        modes=_modes(codebook, pbs, last, steps),
        nearest=np.sqrt(errors[:learned].mean(axis=1)),
        entries=len(errors),
    )


def posterior(sums: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    """(n, ...) shares of n entries from the sums of their errors, under a flat prior over them."""
    logarithms = -sums / (2 * scale**2)
    weights = np.exp(logarithms - logarithms.max(axis=0))
    shares: NDArray[np.float64] = weights / weights.sum(axis=0)
    return shares


def _heaviest(weights: NDArray[np.float64]) -> NDArray[np.intp]:
    """The entries that hold CLOUD_MASS of the belief at any time, at most MOST_ENTRIES of them."""
    order = np.argsort(-weights, axis=0)
    ranked = np.take_along_axis(weights, order, axis=0)
    before = ranked.cumsum(axis=0) - ranked
    most = np.zeros(len(weights))
    for step in range(weights.shape[1]):
        inside = order[before[:, step] < CLOUD_MASS, step]
        most[inside] = np.maximum(most[inside], weights[inside, step] / weights[:, step].max())
    chosen: NDArray[np.intp] = np.argsort(-most, kind="stable")[:MOST_ENTRIES]
    return chosen[most[chosen] > 0]


def _modes(
    codebook: Codebook, pbs: Array, weights: NDArray[np.float64], steps: int
) -> tuple[Mode, ...]:
    """Where the mass lies: the heaviest entries whose motions differ, with what is like them."""
    heavy = np.argsort(-weights, kind="stable")[:HEAVY]
    kept = -(-steps // codebook.stride)
    motions = codebook.motions[heavy, :kept].float().flatten(1).numpy()  # (H, K J)
    squares = np.square(motions).mean(axis=1)
    products = motions @ motions.T / motions.shape[1]
    gaps = np.sqrt(np.maximum(squares[:, None] + squares[None] - 2 * products, 0.0))
    centers: list[int] = []
    for index in range(len(heavy)):
        if not centers or gaps[index, centers].min() > DIFFERENT:
            centers.append(index)
    nearest = gaps[:, centers].argmin(axis=1)
    mass = np.bincount(nearest, weights=weights[heavy], minlength=len(centers))
    ranked = [int(i) for i in np.argsort(-mass, kind="stable")[:MOST_MODES]]
    return tuple(
        Mode(pbs[heavy[centers[i]]], float(mass[i]))
        for number, i in enumerate(ranked)
        if mass[i] >= MODE_MASS or number == 0
    )
