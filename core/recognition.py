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

from collections.abc import Callable, Iterator
from typing import cast

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from .batching import batch_size, chunks
from .errors import Cancelled, InputError
from .model import RNNPB
from .recognition_run import Array, RecognitionConfig, RecognitionStep

RANDOM_SPREAD = 3.0  # standard deviation of the random warm start's candidates


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
    distances: list[Tensor] = []
    if candidates.shape[1] > 1:
        pbs = candidates.flatten(0, 1)
        for chunk in pbs.split(at_once or batch_size(observed)):
            distances.append(observed_losses(model, chunk, target[:observed]))
            yield None
    starts = _closest(candidates, distances).repeat(config.trials // len(candidates), 1)  # (K, D)
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


def _closest(candidates: Tensor, distances: list[Tensor]) -> Tensor:
    """(K, D): of each row of candidates (K, n, D) the one at the smallest distance."""
    if not distances:
        return candidates[:, 0]
    best = torch.cat(distances).view(candidates.shape[:2]).argmin(dim=1)
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
