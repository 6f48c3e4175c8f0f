"""Recognition by prediction-error minimisation, as published (section III.D).

The network stays as it is; what travels is the belief about the PB, N(mu, diag sigma^2). Each
iteration samples a PB, generates the whole motion from it, and compares the observed part with the
target. The loss that is compared and differentiated is the squared error averaged over observed
frames and joints: eq. 10 as a mean, to which the published threshold of 0.1 belongs.

- A loss below the best so far is an early update: mu jumps to the sampled PB, the loss becomes the
  new threshold, and no gradient step is made (sigma and Adam's state stay as they are).
- Otherwise mu and log sigma^2 make one step of Adam.

A deterministic model has no sigma, its PB is mu. Its early update therefore leaves everything as
it was; the next iteration generates the same motion again, whose loss is no longer below the
threshold, and makes the gradient step. Wherever it improves it stands still for one iteration, as
published.

All trials run as one batch, yet each has its own noise, threshold and Adam state: trial k goes the
way that it goes alone.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields
from typing import Literal, cast, get_args

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from .batching import batch_size, chunks
from .errors import Cancelled, InputError
from .model import RNNPB

Array = NDArray[np.float32]
Init = Literal["learned", "baseline", "random"]
RANDOM_SPREAD = 3.0  # standard deviation of the random warm start's candidates


@dataclass(frozen=True)
class RecognitionConfig:
    """The published procedure's settings; the defaults are the published ones but for `trials`.

    init: where mu starts. `baseline` at 0; `learned` at the learned mu whose motion is closest to
        the observed part, `random` at the best of `candidates` draws from N(0, 3^2 I). Both
        searches are at sigma = 0. sigma starts at 1.
    observed: share of the frames that is compared; the rest is predicted.
    first_trial: number of the first trial; trial k of a seed is the same run in any batch.
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


@dataclass(frozen=True)
class RecognitionStep:
    """One iteration of K trials.

    mu, sigma: (K, D) the belief before the update; mu_next, sigma_next: after it.
    pb: (K, D) what was sampled from it, output: (K, T, J) the motion generated from that.
    loss: (K,) squared error averaged over observed frames and joints.
    prediction_error: (K,) the same over the frames not observed; NaN where all are.
    early_update: (K,) mu jumped to pb.
    """

    iteration: int  # from 0
    mu: Array
    sigma: Array
    pb: Array
    loss: Array
    prediction_error: Array
    early_update: NDArray[np.bool_]
    output: Array
    mu_next: Array
    sigma_next: Array


def recognize(
    model: RNNPB,
    target: ArrayLike,
    config: RecognitionConfig | None = None,
    *,
    cancelled: Callable[[], bool] | None = None,
) -> Iterator[RecognitionStep]:
    """Recognise a motion, one iteration at a time; stop iterating to stop.

    Args:
        target: (T, J), of which the first int(observed * T) frames are observed.
        cancelled: asked before each iteration, and between chunks of the warm start's search, which
            comes before the first and can take longer than all of them.

    Raises:
        InputError: a target of another number of joints, too short, or not finite.
        Cancelled: `cancelled` said so.
    """
    config = config or RecognitionConfig()
    pieces = recognition_pieces(model, target, config)
    return _steps(pieces, cancelled or _never)


def _never() -> bool:
    return False


def _steps(
    pieces: Iterator[RecognitionStep | None], cancelled: Callable[[], bool]
) -> Iterator[RecognitionStep]:
    while not cancelled():
        try:
            piece = next(pieces)
        except StopIteration:
            return
        if piece is not None:
            yield piece
    raise Cancelled


def recognition_pieces(
    model: RNNPB, target: ArrayLike, config: RecognitionConfig, *, at_once: int | None = None
) -> Iterator[RecognitionStep | None]:
    """`recognize`, cut finer: each part of the warm start's search is a step, too, a None.

    Args:
        at_once: motions that the search generates in one batch; by default as many as are quick.

    Raises:
        InputError: see `recognize`.
    """
    return _pieces(model, check_target(model, target, config.observed), config, at_once)


def check_target(model: RNNPB, target: ArrayLike, observed: float) -> Tensor:
    """The target as (T, J) tensor on the model's device.

    Raises:
        InputError: see `recognize`.
    """
    motion = torch.as_tensor(np.array(target, dtype=np.float32)).to(model.mu)
    if motion.ndim != 2 or motion.shape[1] != model.config.num_joints:
        raise InputError(
            f"the target has shape {tuple(motion.shape)}, "
            f"the model generates (frames, {model.config.num_joints})"
        )
    if int(observed * len(motion)) < 1:
        raise InputError(f"{observed} of {len(motion)} frames leaves none to observe")
    if not torch.isfinite(motion).all():
        raise InputError("the target holds NaN or infinity")
    return motion


def _pieces(
    model: RNNPB, target: Tensor, config: RecognitionConfig, at_once: int | None
) -> Iterator[RecognitionStep | None]:
    observed = int(config.observed * len(target))
    trials = range(config.first_trial, config.first_trial + config.trials)
    streams = [np.random.default_rng([config.seed, trial]) for trial in trials]
    candidates = _candidates(model, config, streams)  # (1 or K, n, D)
    losses = []
    if candidates.shape[1] > 1:
        pbs = candidates.flatten(0, 1)
        for chunk in pbs.split(at_once or batch_size(observed)):
            losses.append(observed_losses(model, chunk, target[:observed]))
            yield None
    starts = _closest(candidates, losses).repeat(config.trials // len(candidates), 1)  # (K, D)
    draws = [stream.standard_normal((config.iterations, starts.shape[1])) for stream in streams]
    noise = torch.as_tensor(np.stack(draws, axis=1)).to(starts)  # (iterations, K, D)
    pb_dim = starts.shape[1]
    belief = torch.cat([starts, torch.zeros_like(starts)], dim=1)  # (K, 2 D): mu, log sigma^2
    adam = _TrialAdam(belief, config.learning_rate)
    best = torch.full_like(starts[:, 0], config.threshold)  # (K,)
    for iteration in range(config.iterations):
        mu, sigma = _mu_sigma(model, belief)
        pb = mu + sigma * noise[iteration]  # eq. 1
        output, losses, gradient = _compare(model, pb, target, observed)
        early = losses < best
        best = torch.where(early, losses, best)
        # The chain rule of eq. 1, with sigma = exp(log sigma^2 / 2).
        gradient = torch.cat([gradient, gradient * noise[iteration] * sigma / 2], dim=1)
        belief = adam.step(belief, gradient, ~early)
        belief[early, :pb_dim] = pb[early]
        mu_next, sigma_next = _mu_sigma(model, belief)
        yield RecognitionStep(
            iteration=iteration,
            mu=to_numpy(mu),
            sigma=to_numpy(sigma),
            pb=to_numpy(pb),
            loss=to_numpy(losses),
            prediction_error=to_numpy((output - target)[:, observed:].square().mean(dim=(1, 2))),
            early_update=early.cpu().numpy(),
            output=to_numpy(output),
            mu_next=to_numpy(mu_next),
            sigma_next=to_numpy(sigma_next),
        )


def _mu_sigma(model: RNNPB, belief: Tensor) -> tuple[Tensor, Tensor]:
    mu, log_var = belief.chunk(2, dim=1)
    sigma = torch.exp(0.5 * log_var) if model.stochastic else torch.zeros_like(mu)
    return mu, sigma


def _compare(
    model: RNNPB, pb: Tensor, target: Tensor, observed: int
) -> tuple[Tensor, Tensor, Tensor]:
    """Motions (K, T, J) of PBs (K, D), their losses (K,), and the losses' gradients (K, D)."""
    with torch.inference_mode(False), torch.enable_grad():
        leaf = pb.clone().requires_grad_()
        output = model.generate(leaf, len(target))
        losses = (output[:, :observed] - target[:observed]).square().mean(dim=(1, 2))
        (gradient,) = torch.autograd.grad(losses.sum(), leaf)
    return output.detach(), losses.detach(), gradient


class _TrialAdam:
    """torch.optim.Adam with its defaults, but each row (trial) with a step count of its own."""

    def __init__(self, parameters: Tensor, learning_rate: float) -> None:
        self._rate = learning_rate
        self._mean = torch.zeros_like(parameters)
        self._square = torch.zeros_like(parameters)
        self._count = torch.zeros_like(parameters[:, :1], dtype=torch.float64)

    def step(self, parameters: Tensor, gradient: Tensor, rows: Tensor) -> Tensor:
        """The parameters after one step of the chosen rows; the other rows' state stays, too."""
        self._mean[rows] = torch.lerp(self._mean, gradient, 1 - 0.9)[rows]
        self._square[rows] = (0.999 * self._square + (1 - 0.999) * gradient.square())[rows]
        self._count[rows] += 1
        rate = (self._rate / (1 - 0.9**self._count)).to(parameters)
        scale = (1 - 0.999**self._count).sqrt().to(parameters)
        moved = parameters - rate * self._mean / (self._square.sqrt() / scale + 1e-8)
        return torch.where(rows[:, None], moved, parameters)


def _candidates(
    model: RNNPB, config: RecognitionConfig, streams: list[np.random.Generator]
) -> Tensor:
    """Where mu may start, (1, n, D), or (K, n, D) where every trial draws its own."""
    if config.init == "random":
        shape = (config.candidates, model.config.pb_dim)
        draws = [RANDOM_SPREAD * stream.standard_normal(shape) for stream in streams]
        return torch.as_tensor(np.stack(draws)).to(model.mu)
    mu = model.mu.detach()
    return mu[None] if config.init == "learned" else torch.zeros_like(mu[None, :1])


def _closest(candidates: Tensor, losses: list[Tensor]) -> Tensor:
    """(K, D): of each row of candidates (K, n, D) the one with the lowest loss."""
    if not losses:
        return candidates[:, 0]
    best = torch.cat(losses).view(candidates.shape[:2]).argmin(dim=1)
    return candidates[torch.arange(len(candidates)), best]


@torch.no_grad()
def observed_losses(model: RNNPB, pbs: Tensor, observation: Tensor) -> Tensor:
    """(B,) squared error of the motions of PBs (B, D) against an observation (T, J), as a mean."""
    frames = len(observation)
    losses = []
    for chunk in chunks(pbs, frames):
        losses.append((model.generate(chunk, frames) - observation).square().mean(dim=(1, 2)))
    return torch.cat(losses)


def to_numpy(values: Tensor) -> Array:
    return cast(Array, values.cpu().numpy())


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
    early_update: NDArray[np.bool_]  # (K, I)
    reconstruction_loss: Array  # (K,) of the last iteration: the observed part
    prediction_error: Array  # (K,) of the last iteration: the rest
    output: Array  # (K, T, J) of the last iteration
    best_iteration: NDArray[np.int64]  # (K,)
    best_reconstruction_loss: Array  # (K,)
    best_prediction_error: Array  # (K,)
    best_output: Array  # (K, T, J)

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
        kept: dict[str, list[NDArray[np.generic]]] = {
            name: [] for name in ("mu", "sigma", "pb", "loss", "early_update", "prediction_error")
        }
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
        prediction_errors = stacked.pop("prediction_error")
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
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write every field as an array of a compressed npz file, under exactly this path."""
        with open(path, "wb") as file:
            np.savez_compressed(
                file, **{field.name: getattr(self, field.name) for field in fields(self)}
            )
