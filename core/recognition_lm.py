"""Recognition by Levenberg-Marquardt: a few second-order steps instead of a hundred of Adam.

A PB has few dimensions, so one forward pass with D tangents beside each motion (forward mode) gives
the Jacobian of the whole observed part with respect to the PB; there is no backward pass. From the
learned mu whose motions are closest to the observation, all in one batch, mu goes down the same
loss as in the published procedure (eq. 10), without sampling.

J^T J also says how sharply the observation determines the PB. With independent Gaussian errors of
the variance that is left, and the prior N(0, I) of training, the belief is Gaussian with precision
J^T J / variance + I; its marginal deviations are the sigma of a step. (Errors of neighbouring
frames are not independent, so it is a sharp belief; as in eq. 10 the prior does not move mu.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import torch
from numpy.typing import ArrayLike
from torch import Tensor

from .errors import InputError
from .model import RNNPB
from .recognition import check_target, observed_losses, to_numpy
from .recognition_run import RecognitionStep

DAMPING = 0.1  # at the start, in units of the mean diagonal of J^T J
DAMPING_DOWN, DAMPING_UP = 0.2, 5.0  # after a step that lowered the loss, and one that did not
MAX_DAMPING = 1e4  # steps are too short to matter there
MIN_VARIANCE = 1e-8  # (0.1 mrad)^2: no error of a joint is smaller, whatever the loss says


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
    model: RNNPB, target: ArrayLike, config: LMConfig | None = None
) -> Iterator[RecognitionStep]:
    """Recognise a motion, one iteration at a time, until the best trial is at its minimum.

    In a step `pb` is the PB that was tried (in the first, the start), `early_update` says that its
    loss was the lowest of its trial so far, so that mu is there now.

    Args:
        target: (T, J), of which the first int(observed * T) frames are observed.

    Raises:
        InputError: a target of another number of joints, too short, or not finite.
    """
    config = config or LMConfig()
    return _iterate(model, check_target(model, target, config.observed), config)


def _iterate(model: RNNPB, target: Tensor, config: LMConfig) -> Iterator[RecognitionStep]:
    observed = int(config.observed * len(target))
    distances = observed_losses(model, model.mu, target[:observed])
    descent = _Descent(model.mu.detach()[distances.argsort()[: config.starts]])
    for iteration in range(config.iterations):
        with torch.no_grad():
            mu, sigma, pb = descent.mu, descent.sigma(), descent.pb
            output = model.generate(pb, len(target))
            difference = output - target  # (K, T, J)
            loss = difference[:, :observed].square().mean(dim=(1, 2))
            better = descent.judge(loss, config.tolerance)
            if better.any():
                jacobian = pb_jacobian(model, pb[better], observed)
                descent.linearise(better, jacobian, difference[better, :observed])
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


class _Descent:
    """Where K trials are, and what is known of the loss around there."""

    def __init__(self, starts: Tensor) -> None:
        trials, dimensions = starts.shape
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
        self._damping = self._damping * torch.where(better, DAMPING_DOWN, DAMPING_UP)
        self.done |= better & (self.loss - loss < tolerance * self.loss)
        self.done |= self._damping > MAX_DAMPING
        self.loss = torch.where(better, loss, self.loss)
        self.mu = torch.where(better[:, None], self.pb, self.mu)
        return better

    def linearise(self, rows: Tensor, jacobian: Tensor, residual: Tensor) -> None:
        """Take the Jacobian (k, T, J, D) and the residual (k, T, J) at mu of the chosen rows."""
        flat = jacobian.flatten(1, 2).double()  # (k, T J, D)
        self._normal[rows] = flat.mT @ flat
        self._slope[rows] = (flat.mT @ residual.flatten(1).double()[..., None]).squeeze(-1)

    def propose(self) -> None:
        """Set what to try next: the damped Gauss-Newton step from mu; nothing new when done."""
        scale = self._normal.diagonal(dim1=1, dim2=2).mean(dim=1).clamp(min=1e-12)
        damped = self._normal + torch.diag_embed(
            (self._damping * scale)[:, None].expand_as(self.mu)
        )
        step = torch.linalg.solve(damped, -self._slope).to(self.mu)
        self.pb = torch.where(self.done[:, None], self.mu, self.mu + step)

    def sigma(self) -> Tensor:
        """(K, D) marginal deviations of the belief; 1, the prior's, before anything is known."""
        variance = self.loss.double().clamp(min=MIN_VARIANCE)[:, None, None]
        precision = self._normal / variance + torch.eye(self.mu.shape[1]).to(self._normal)
        covariance: Tensor = torch.linalg.inv(precision)
        return covariance.diagonal(dim1=1, dim2=2).sqrt().to(self.mu)


@torch.no_grad()
def pb_jacobian(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """Derivatives of the motions of PBs (B, D) with respect to them: (B, steps, J, D).

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
    hidden = []
    for _ in range(steps):
        i, f, g, o = gates[:, :1].chunk(4, dim=2)  # (B, 1, H)
        i, f, g, o = i.sigmoid(), f.sigmoid(), g.tanh(), o.sigmoid()
        di, df, dg, do = gates[:, 1:].chunk(4, dim=2)  # (B, D, H), before the nonlinearities
        dc = f * dc + (f * (1 - f) * c) * df + (i * (1 - i) * g) * di + (i * (1 - g * g)) * dg
        c = f * c + i * g
        squashed = c.tanh()
        dh = (o * (1 - o) * squashed) * do + (o * (1 - squashed * squashed)) * dc
        hidden.append(dh)
        gates = constant + torch.cat([o * squashed, dh], dim=1) @ folded
    tangent_frames: Tensor = torch.stack(hidden, dim=1) @ model.weight_out.T  # (B, T, D, J)
    return tangent_frames.mT
