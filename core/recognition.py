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

The KL term of training (eqs. 3 and 5) is no part of this loss. It can be switched on (`beta`): what
is minimised is then the squared error summed over joints and averaged over frames, plus beta times
KL(N(mu, sigma^2) || N(0, I)), as in training, divided by the number of observed joints.

All trials run as one batch, yet each has its own noise, threshold and Adam state: trial k goes the
way that it goes alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar, cast

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from .batching import batch_size
from .errors import Cancelled, InputError
from .model import RNNPB, gaussian_kl
from .observation import Observation
from .recognition_run import Array, RecognitionConfig, RecognitionStep

StepT = TypeVar("StepT")
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
        InputError: a target of another number of joints, too short, or not finite; a KL term for a
            model without sigma.
        Cancelled: `cancelled` said so.
    """
    return whole_steps(recognition_pieces(model, target, config or RecognitionConfig()), cancelled)


def whole_steps(
    pieces: Iterator[StepT | None], cancelled: Callable[[], bool] | None
) -> Iterator[StepT]:
    """The steps alone of pieces between which `cancelled` is asked; nothing learns from them.

    Raises:
        Cancelled: it said so.
    """
    while cancelled is None or not cancelled():
        try:
            with torch.no_grad():
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
    if config.beta and not model.stochastic:
        raise InputError("a deterministic model has no sigma, and so no KL term to minimise")
    observation = Observation.of(model, target, config.observed, config.joints)
    return _pieces(model, observation, config, at_once)


def _pieces(
    model: RNNPB, seen: Observation, config: RecognitionConfig, at_once: int | None
) -> Iterator[RecognitionStep | None]:
    trials = range(config.first_trial, config.first_trial + config.trials)
    streams = [np.random.default_rng([config.seed, trial]) for trial in trials]
    candidates = _candidates(model, config, streams)  # (1 or K, n, D)
    distances: list[Tensor] = []
    if candidates.shape[1] > 1:
        pbs = candidates.flatten(0, 1)
        for chunk in pbs.split(at_once or batch_size(seen.frames)):
            distances.append(seen.losses_of(model, chunk))
            yield None
    starts = _closest(candidates, distances).repeat(config.trials // len(candidates), 1)  # (K, D)
    draws = [stream.standard_normal((config.iterations, starts.shape[1])) for stream in streams]
    noise = torch.as_tensor(np.stack(draws, axis=1)).to(starts)  # (iterations, K, D)
    pb_dim = starts.shape[1]
    belief = torch.cat([starts, torch.zeros_like(starts)], dim=1)  # (K, 2 D): mu, log sigma^2
    adam = _TrialAdam(belief, config.learning_rate)
    best = torch.full_like(starts[:, 0], config.threshold)  # (K,)
    weight = config.beta / len(seen.joints)  # of the KL term beside an average over joints
    for iteration in range(config.iterations):
        mu, sigma = _mu_sigma(model, belief)
        pb = mu + sigma * noise[iteration]  # eq. 1
        output, losses, gradient = _compare(model, pb, seen)
        kl = gaussian_kl(mu, sigma) if model.stochastic else torch.zeros_like(losses)
        early = losses + weight * kl < best
        best = torch.where(early, losses + weight * kl, best)
        # The chain rule of eq. 1, with sigma = exp(log sigma^2 / 2), and the gradient of eq. 5.
        for_mu = gradient + weight * mu
        for_log_var = gradient * noise[iteration] * sigma / 2 + weight * (sigma**2 - 1) / 2
        belief = adam.step(belief, torch.cat([for_mu, for_log_var], dim=1), ~early)
        belief[early, :pb_dim] = pb[early]
        mu_next, sigma_next = _mu_sigma(model, belief)
        yield RecognitionStep(
            iteration=iteration,
            mu=to_numpy(mu),
            sigma=to_numpy(sigma),
            pb=to_numpy(pb),
            loss=to_numpy(losses),
            kl=to_numpy(kl),
            explained=to_numpy(seen.explained(losses)),
            prediction_error=to_numpy(seen.prediction_errors(output)),
            early_update=early.cpu().numpy(),
            output=to_numpy(output),
            mu_next=to_numpy(mu_next),
            sigma_next=to_numpy(sigma_next),
        )


def _mu_sigma(model: RNNPB, belief: Tensor) -> tuple[Tensor, Tensor]:
    mu, log_var = belief.chunk(2, dim=1)
    sigma = torch.exp(0.5 * log_var) if model.stochastic else torch.zeros_like(mu)
    return mu, sigma


def _compare(model: RNNPB, pb: Tensor, seen: Observation) -> tuple[Tensor, Tensor, Tensor]:
    """Motions (K, T, J) of PBs (K, D), their losses (K,), and the losses' gradients (K, D)."""
    with torch.inference_mode(False), torch.enable_grad():
        leaf = pb.clone().requires_grad_()
        output = model.generate(leaf, len(seen.target))
        losses = seen.losses(output)
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


def to_numpy(values: Tensor) -> Array:
    return cast(Array, values.cpu().numpy())
