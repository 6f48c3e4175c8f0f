"""Recognition by Levenberg-Marquardt: a few second-order steps instead of a hundred of Adam.

A PB has few dimensions, so one forward pass with D tangents beside each motion (forward mode) gives
the Jacobian of the whole observed part with respect to the PB; there is no backward pass. From the
learned mu whose motions are closest to the observation, all in one batch, mu goes down the same
loss as in the published procedure (eq. 10), without sampling.

J^T J also says how sharply the observation determines the PB. With independent Gaussian errors of
the variance that is left, the belief is Gaussian with precision J^T J / variance, and + I where the
model was trained with the prior N(0, I), that is with a KL term (eqs. 3 and 5, beta > 0). With
beta = 0 and in a deterministic model nothing held the PBs anywhere: what the observation leaves
open stays open, and its deviation is infinite. The marginal deviations are the sigma of a step.
(Errors of neighbouring frames are not independent, so it is a sharp belief; as in eq. 10 the prior
does not move mu.)

The tangents of all frames would take 1.5 GB at D_PB = 128 with 600 frames. Only their sums J^T J
and J^T r are kept, part by part: beside the result the work takes some 150 MB at most, whatever the
number of frames and of starts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import torch
from numpy.typing import ArrayLike
from torch import Tensor

from .batching import chunks
from .errors import Cancelled, InputError
from .model import RNNPB
from .recognition import check_target, observed_losses, to_numpy
from .recognition_run import RecognitionStep

DAMPING = 0.1  # of the first step, in units of the mean diagonal of J^T J
DAMPING_DOWN, DAMPING_UP = 0.2, 5.0  # after a step that lowered the loss, and one that did not
MAX_DAMPING = 1e4  # steps are too short to matter there
MIN_VARIANCE = 1e-8  # (0.1 mrad)^2: no error of a joint is smaller, whatever the loss says
ROW_BYTES = 2**23  # of one frame's gates, of the motions whose Jacobians are made at once
PART_BYTES = 2**25  # of their hidden tangents, kept until they are read out
BLIND = (
    torch.finfo(torch.float32).eps ** 2
)  # share of J^T J that a float32 Jacobian cannot tell from 0


@dataclass(frozen=True)
class LMConfig:
    """starts: how many learned mu to start from, the closest first; each is a trial.
    observed: share of the frames that is compared; the rest is predicted.
    iterations: at most. tolerance: a trial is done when a step lowers its loss by a smaller share.
    """

    starts: int = 8
    observed: float = 0.8
    iterations: int = 20
    tolerance: float = 1e-3

    def __post_init__(self) -> None:
        for name in ("starts", "iterations"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} must be at least 1, got {getattr(self, name)}")
        if not 0 < self.observed <= 1:
            raise InputError(f"observed must be a share above 0, at most 1, got {self.observed}")


def recognize_lm(
    model: RNNPB,
    target: ArrayLike,
    config: LMConfig | None = None,
    *,
    cancelled: Callable[[], bool] | None = None,
) -> Iterator[RecognitionStep]:
    """Recognise a motion, one iteration at a time, until the best trial is at its minimum.

    In a step `pb` is the PB that was tried (in the first, the start), `early_update` says that its
    loss was the lowest of its trial so far, so that mu is there now.

    Args:
        target: (T, J), of which the first int(observed * T) frames are observed.
        cancelled: asked before each iteration, and between the parts of its work.

    Raises:
        InputError: a target of another number of joints, too short, or not finite.
        Cancelled: `cancelled` said so.
    """
    config = config or LMConfig()
    motion = check_target(model, target, config.observed)
    return _iterate(model, motion, config, cancelled or (lambda: False))


def _iterate(
    model: RNNPB, target: Tensor, config: LMConfig, cancelled: Callable[[], bool]
) -> Iterator[RecognitionStep]:
    observed = int(config.observed * len(target))
    distances = []
    for chunk in chunks(model.mu.detach(), observed):
        _stop_if(cancelled)
        distances.append(observed_losses(model, chunk, target[:observed]))
    starts = model.mu.detach()[torch.cat(distances).argsort()[: config.starts]]
    descent = _Descent(starts, prior=model.stochastic and bool(model.config.beta))
    for iteration in range(config.iterations):
        with torch.no_grad():
            mu, sigma, pb = descent.mu, descent.sigma(), descent.pb
            output = _generate(model, pb, len(target), cancelled)
            difference = output - target  # (K, T, J)
            loss = difference[:, :observed].square().mean(dim=(1, 2))
            better = descent.judge(loss, config.tolerance)
            if better.any():
                residual = difference[better, :observed]
                sums = _normal_equations(model, pb[better], residual, cancelled)
                descent.linearise(better, *sums)
            descent.propose()
        yield RecognitionStep(
            iteration=iteration,
            mu=to_numpy(mu),
            sigma=to_numpy(sigma),
            pb=to_numpy(pb),
            loss=to_numpy(loss),
            prediction_error=to_numpy(difference[:, observed:].square().mean(dim=(1, 2))),
            early_update=better.cpu().numpy(),
            output=to_numpy(output),
            mu_next=to_numpy(descent.mu),
            sigma_next=to_numpy(descent.sigma()),
        )
        if descent.done[descent.loss.argmin()]:
            return


def _generate(model: RNNPB, pb: Tensor, steps: int, cancelled: Callable[[], bool]) -> Tensor:
    """(B, steps, J): `RNNPB.generate` in parts; `cancelled` is asked before each."""
    parts = []
    for part in chunks(pb, steps):
        _stop_if(cancelled)
        parts.append(model.generate(part, steps))
    return torch.cat(parts)


def _stop_if(cancelled: Callable[[], bool]) -> None:
    if cancelled():
        raise Cancelled


class _Descent:
    """Where K trials are, and what is known of the loss around there."""

    def __init__(self, starts: Tensor, prior: bool) -> None:
        trials, dimensions = starts.shape
        self._prior = 1.0 if prior else 0.0  # its precision
        self.pb = starts  # (K, D) to be tried next
        self.mu = starts  # (K, D) the best so far
        self.loss = starts.new_full((trials,), torch.inf)  # there
        self.done = torch.zeros_like(self.loss, dtype=torch.bool)
        self._damping = torch.full_like(self.loss, DAMPING, dtype=torch.float64)
        # J^T J and J^T residual at mu. Squaring costs half of the digits: float64.
        self._normal = starts.new_zeros((trials, dimensions, dimensions), dtype=torch.float64)
        self._slope = starts.new_zeros((trials, dimensions), dtype=torch.float64)

    def judge(self, loss: Tensor, tolerance: float) -> Tensor:
        """(K,) whether what was tried is better; if so mu goes there."""
        better = loss < self.loss
        factor = torch.where(better, DAMPING_DOWN, DAMPING_UP)
        tried = self.loss.isfinite()  # a step, not only the start
        self._damping = torch.where(tried, self._damping * factor, self._damping)
        self.done |= better & (self.loss - loss < tolerance * self.loss)
        self.done |= self._damping > MAX_DAMPING
        self.loss = torch.where(better, loss, self.loss)
        self.mu = torch.where(better[:, None], self.pb, self.mu)
        return better

    def linearise(self, rows: Tensor, normal: Tensor, slope: Tensor) -> None:
        """Take J^T J (k, D, D) and J^T residual (k, D) at mu of the chosen rows."""
        self._normal[rows], self._slope[rows] = normal, slope

    def propose(self) -> None:
        """Set what to try next: the damped Gauss-Newton step from mu; nothing new when done."""
        scale = self._normal.diagonal(dim1=1, dim2=2).mean(dim=1).clamp(min=1e-12)
        damped = self._normal + torch.diag_embed(
            (self._damping * scale)[:, None].expand_as(self.mu)
        )
        step = torch.linalg.solve(damped, -self._slope).to(self.mu)
        self.pb = torch.where(self.done[:, None], self.mu, self.mu + step)

    def sigma(self) -> Tensor:
        """(K, D) marginal deviations of the belief; before anything is known, those of the prior.

        Infinite in every component that neither the observation nor a prior determines.
        """
        variance = self.loss.double().clamp(min=MIN_VARIANCE)[:, None]
        values, vectors = torch.linalg.eigh(self._normal)  # (K, D), (K, D, D)
        seen = torch.where(values > BLIND * values[:, -1:], values, 0.0)
        spread = 1 / (seen / variance + self._prior)  # (K, D) along the eigenvectors
        shares = vectors.square()  # of a component in an eigenvector
        rounding = spread.isinf()[:, None] & (shares < torch.finfo(torch.float32).eps)
        parts = torch.where(rounding, 0.0, shares * spread[:, None])
        return parts.sum(dim=2).sqrt().to(self.mu)


def _normal_equations(
    model: RNNPB, pb: Tensor, residual: Tensor, cancelled: Callable[[], bool]
) -> tuple[Tensor, Tensor]:
    """J^T J (B, D, D) and J^T residual (B, D) for PBs (B, D) and residuals (B, T, J).

    In float64: squaring costs half of the digits.
    """
    dimensions = pb.shape[1]
    normal = pb.new_zeros((*pb.shape, dimensions), dtype=torch.float64)
    slope = torch.zeros_like(pb, dtype=torch.float64)
    at_once = max(1, ROW_BYTES // ((1 + dimensions) * model.bias.nbytes))
    for rows in torch.arange(len(pb), device=pb.device).split(at_once):
        first = 0
        for jacobian in _jacobian_parts(model, pb[rows], residual.shape[1]):
            _stop_if(cancelled)
            frames = jacobian.shape[1]
            flat = jacobian.flatten(1, 2).double()  # (b, t J, D)
            part = residual[rows, first : first + frames].flatten(1).double()
            normal[rows] += flat.mT @ flat
            slope[rows] += (flat.mT @ part[..., None]).squeeze(-1)
            first += frames
    return normal, slope


@torch.no_grad()
def pb_jacobian(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """Derivatives of the motions of PBs (B, D) with respect to them: (B, steps, J, D)."""
    return torch.cat(list(_jacobian_parts(model, pb, steps)), dim=1)


def _jacobian_parts(model: RNNPB, pb: Tensor, steps: int) -> Iterator[Tensor]:
    """The same as parts (B, t, J, D), one after the other.

    Forward mode: row 0 of the second axis is the folded recurrence itself (see RNNPB.generate),
    rows 1 to D are its derivatives in each component of the PB. One product with the weights
    serves them all.
    """
    folded = (model.weight_hidden + model.weight_frame @ model.weight_out).T.contiguous()
    tangents = model.weight_pb.T.expand(len(pb), -1, -1)  # (B, D, 4H)
    first = torch.cat([(pb @ model.weight_pb.T + model.bias)[:, None], tangents], dim=1)
    constant = first.clone()
    constant[:, 0] += model.weight_frame @ model.bias_out
    c = first.new_zeros(())
    dc = first.new_zeros(())
    gates = first  # (B, 1 + D, 4H); x_0 = h_0 = 0
    hidden: list[Tensor] = []
    for step in range(1, steps + 1):
        i, f, g, o = gates[:, :1].chunk(4, dim=2)  # (B, 1, H)
        i, f, g, o = i.sigmoid(), f.sigmoid(), g.tanh(), o.sigmoid()
        di, df, dg, do = gates[:, 1:].chunk(4, dim=2)  # (B, D, H), before the nonlinearities
        dc = f * dc + (f * (1 - f) * c) * df + (i * (1 - i) * g) * di + (i * (1 - g * g)) * dg
        c = f * c + i * g
        squashed = c.tanh()
        dh = (o * (1 - o) * squashed) * do + (o * (1 - squashed * squashed)) * dc
        hidden.append(dh)
        gates = constant + torch.cat([o * squashed, dh], dim=1) @ folded
        if step == steps or len(hidden) * dh.nbytes >= PART_BYTES:
            yield (torch.stack(hidden, dim=1) @ model.weight_out.T).mT  # (B, t, J, D)
            hidden = []
