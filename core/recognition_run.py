"""A recognition as plain arrays: its settings, one iteration, and what all of them came to."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from .errors import InputError

Array = NDArray[np.floating[Any]]
Init = Literal["learned", "baseline", "random"]
# global: Levenberg-Marquardt from a codebook; paper: as published; live: while the motion arrives.
Method = Literal["global", "paper", "live"]
LM_ITERATIONS = 20  # at most; it stops at the minimum, mostly after five


@dataclass(frozen=True)
class RecognitionConfig:
    """The published procedure's settings; the defaults are the published ones but for `trials`.

    init: where mu starts. `baseline` at 0; `learned` at the learned mu whose motion is closest to
        the observed part, `random` at the best of `candidates` draws from N(0, 3^2 I). Both
        searches are at sigma = 0. sigma starts at 1.
    observed: share of the frames that is compared; the rest is predicted.
    first_trial: number of the first trial; trial k of a seed is the same run in any batch.
    joints: indices of those that are observed; () means all.
    beta: weight of the KL term, as in training; 0, as published: no part of what is minimised.
    """

    init: Init = "learned"
    candidates: int = 100
    observed: float = 0.8
    iterations: int = 100
    trials: int = 1
    learning_rate: float = 0.1  # for mu and for log sigma^2
    threshold: float = 0.1
    seed: int = 0
    first_trial: int = 0
    joints: tuple[int, ...] = ()
    beta: float = 0.0

    def __post_init__(self) -> None:
        if self.init not in get_args(Init):
            raise InputError(f"init must be one of {', '.join(get_args(Init))}, got {self.init!r}")
        for name in ("candidates", "iterations", "trials"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} must be at least 1, got {getattr(self, name)}")
        for name in ("seed", "first_trial"):
            if getattr(self, name) < 0:
                raise InputError(f"{name} must be at least 0, got {getattr(self, name)}")
        if not 0 < self.observed <= 1:
            raise InputError(f"observed must be a share above 0, at most 1, got {self.observed}")
        if not self.learning_rate > 0:
            raise InputError(f"learning_rate must be above 0, got {self.learning_rate}")
        if not 0 <= self.beta < np.inf:
            raise InputError(f"beta must be a number of at least 0, got {self.beta}")


@dataclass(frozen=True)
class RecognitionStep:
    """One iteration of K trials.

    mu, sigma: (K, D) the belief before the update; mu_next, sigma_next: after it.
    pb: (K, D) what was sampled from it, output: (K, T, J) the motion generated from that.
    loss: (K,) squared error averaged over observed frames and joints, without a KL term.
    kl: (K,) KL divergence of the belief from the prior; NaN where nothing is known of it.
    explained: (K,) share of the observed part's variance; NaN where nothing moves.
    prediction_error: (K,) of the observed joints in the other frames; NaN where there are none.
    early_update: (K,) mu jumped to pb.
    """

    iteration: int  # from 0
    mu: Array
    sigma: Array
    pb: Array
    loss: Array
    kl: Array
    explained: Array
    prediction_error: Array
    early_update: NDArray[np.bool_]
    output: Array
    mu_next: Array
    sigma_next: Array


_KEPT = ("mu", "sigma", "pb", "loss", "kl", "explained", "early_update", "prediction_error")


@dataclass(frozen=True)
class RecognitionResult:
    """What K trials of I iterations came to.

    What the paper reports of a trial is its last sampled motion. `best_...` is of the iteration
    with the lowest loss, which is often much lower.
    """

    mu: Array  # (K, I + 1, D), the first before any update
    sigma: Array  # (K, I + 1, D)
    pb: Array  # (K, I, D)
    loss: Array  # (K, I)
    kl: Array  # (K, I)
    early_update: NDArray[np.bool_]  # (K, I)
    reconstruction_loss: Array  # (K,) of the last iteration: the observed part
    prediction_error: Array  # (K,) of the last iteration: the rest
    output: Array  # (K, T, J) of the last iteration
    best_iteration: NDArray[np.int64]  # (K,)
    best_reconstruction_loss: Array  # (K,)
    best_prediction_error: Array  # (K,)
    best_output: Array  # (K, T, J)
    explained: Array  # (K,) share of the observed part's variance, of the best iteration
    iterations_used: NDArray[np.int64]  # (K,) after which a trial stood still

    @property
    def best_trial(self) -> int:
        """The trial that came closest to the observed part."""
        return int(self.best_reconstruction_loss.argmin())

    @classmethod
    def from_steps(cls, steps: Iterable[RecognitionStep]) -> RecognitionResult:
        """Run the steps to their end and gather them; of the motions two a trial are kept.

        Raises:
            ValueError: there is no step.
        """
        kept: dict[str, list[NDArray[np.generic]]] = {name: [] for name in _KEPT}
        last: RecognitionStep | None = None
        best_output = np.empty(0, dtype=np.float32)
        lowest = np.empty(0, dtype=np.float32)
        for last in steps:
            for name, values in kept.items():
                values.append(getattr(last, name))
            if len(kept["loss"]) == 1:
                best_output, lowest = last.output.copy(), last.loss.copy()
            better = last.loss < lowest
            best_output[better], lowest[better] = last.output[better], last.loss[better]
        if last is None:
            raise ValueError("a recognition has at least one step")
        kept["mu"].append(last.mu_next)
        kept["sigma"].append(last.sigma_next)
        stacked = {name: np.stack(values, axis=1) for name, values in kept.items()}
        prediction_errors, explained = stacked.pop("prediction_error"), stacked.pop("explained")
        best = stacked["loss"].argmin(axis=1)
        rows = np.arange(len(best))
        return cls(
            **stacked,
            reconstruction_loss=last.loss,
            prediction_error=last.prediction_error,
            output=last.output,
            best_iteration=best,
            best_reconstruction_loss=lowest,
            best_prediction_error=prediction_errors[rows, best],
            best_output=best_output,
            explained=explained[rows, best],
            iterations_used=_iterations_used(stacked["pb"]),
        )

    def of_best_trial(self) -> RecognitionResult:
        """The same of that trial alone, which is all that a search from several starts answers.

        Its last iterate is the best one: whatever it tried after that, it went back there.
        """
        rows = [self.best_trial]
        kept = {field.name: getattr(self, field.name)[rows] for field in fields(self)}
        for name in ("reconstruction_loss", "prediction_error", "output"):
            kept[name] = kept[f"best_{name}"]
        return RecognitionResult(**kept)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write every field as an array of a compressed npz file, under exactly this path."""
        with open(path, "wb") as file:
            np.savez_compressed(
                file, **{field.name: getattr(self, field.name) for field in fields(self)}
            )


def _iterations_used(pb: NDArray[np.generic]) -> NDArray[np.int64]:
    """(K,) how many of (K, I, D) iterations tried something new, up to the last that did."""
    moved = (np.diff(pb, axis=1) != 0).any(axis=2)  # (K, I - 1)
    numbers = np.arange(2, pb.shape[1] + 1)
    used: NDArray[np.int64] = np.where(moved, numbers, 1).max(axis=1, initial=1)
    return used


@dataclass(frozen=True, eq=False)
class Posterior:
    """The Gaussian belief at the minimum.

    mu: (D,). covariance: (D, D); very large in a direction that nothing determines. sigma: (D,) its
    marginal deviations. deviation: (T, J) of the motion, in radians, to first order.
    """

    mu: NDArray[np.float64]
    covariance: NDArray[np.float64]
    deviation: NDArray[np.float64]

    @property
    def sigma(self) -> NDArray[np.float64]:
        deviations: NDArray[np.float64] = np.sqrt(self.covariance.diagonal())
        return deviations
