"""Recognition by Levenberg-Marquardt: a few second-order steps instead of a hundred of Adam.

A PB has few dimensions, so one forward pass with D tangents beside each motion (forward mode) gives
the Jacobian of the whole observed part with respect to the PB; there is no backward pass. From the
closest entries of a codebook, or the closest learned mu, all in one batch, mu goes down the same
loss as in the published procedure (eq. 10), without sampling.

J^T J also says how sharply the observation determines the PB. With independent Gaussian errors of
the variance that is left, the belief is Gaussian with precision J^T J / variance, and + I where the
model was trained with the prior N(0, I), that is with a KL term (eqs. 3 and 5, beta > 0). With
beta = 0 and in a deterministic model nothing held the PBs anywhere: what the observation leaves
open stays open, and its deviation is infinite. The marginal deviations are the sigma of a step.
(Errors of neighbouring frames are not independent, so it is a sharp belief; as in eq. 10 the prior
does not move mu, unless the KL term is switched on, as in recognition.py.)

The tangents of all frames would take 1.5 GB at D_PB = 128 with 600 frames. Only their sums J^T J
and J^T r are kept, part by part: beside the result the work takes some 150 MB at most, whatever the
number of frames and of starts. More dimensions are searched from fewer starts (`starts_for`).
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass

import torch
from numpy.typing import ArrayLike
from torch import Tensor

from .batching import chunks
from .codebook import Codebook
from .errors import InputError
from .model import RNNPB, gaussian_kl
from .observation import Observation
from .recognition import to_numpy, whole_steps
from .recognition_run import LM_ITERATIONS, Posterior, RecognitionStep

DAMPING = 0.1  # of the first step, in units of the mean diagonal of J^T J
DAMPING_DOWN, DAMPING_UP = 0.2, 5.0  # after a step that lowered the loss, and one that did not
MAX_DAMPING = 1e4  # steps are too short to matter there
MIN_VARIANCE = 1e-8  # (0.1 mrad)^2: no error of a joint is smaller, whatever the loss says
EXACT = 1e-9  # (0.03 mrad)^2: rounding decides below
ROW_BYTES = 2**23  # of one frame's gates, of the motions whose Jacobians are made at once
PART_BYTES = 2**25  # of their hidden tangents, kept until they are read out
BLIND = (
    torch.finfo(torch.float32).eps ** 2
)  # share of J^T J that a float32 Jacobian cannot tell from 0
PIECE_FRAMES = 64  # of a Jacobian, at most, between two pieces of its work,
PIECE_ROWS = 64 * 40  # frames times rows: of eight motions with four tangents each
MOST_TANGENTS = 64  # of all starts of a global search together; each costs a row in every frame
OPEN = 1e3  # deviation, of a direction that nothing determines, where it has to be finite


@dataclass(frozen=True)
class LMConfig:
    """starts: how many PBs to start from, the closest first; each is a trial.
    observed: share of the frames that is compared; the rest is predicted.
    iterations: at most. tolerance: a trial is done when a step lowers its loss by a smaller share.
    joints: indices of those that are observed; () means all.
    beta: weight of the KL term; 0: no part of what is minimised.
    """

    starts: int = 8
    observed: float = 0.8
    iterations: int = LM_ITERATIONS
    tolerance: float = 1e-3
    joints: tuple[int, ...] = ()
    beta: float = 0.0

    def __post_init__(self) -> None:
        for name in ("starts", "iterations"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} must be at least 1, got {getattr(self, name)}")
        if not 0 < self.observed <= 1:
            raise InputError(f"observed must be a share above 0, at most 1, got {self.observed}")
        if not 0 <= self.beta < torch.inf:
            raise InputError(f"beta must be a number of at least 0, got {self.beta}")


def starts_for(model: RNNPB, starts: int) -> int:
    """How many of the wanted starts a global search takes: fewer where each has many tangents."""
    return max(1, min(starts, MOST_TANGENTS // model.config.pb_dim))


def recognize_lm(
    model: RNNPB,
    target: ArrayLike,
    config: LMConfig | None = None,
    *,
    codebook: Codebook | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Iterator[RecognitionStep]:
    """Recognise a motion, one iteration at a time, until the best trial is at its minimum.

    In a step `pb` is the PB that was tried (in the first, the start), `early_update` says that its
    loss was the lowest of its trial so far, so that mu is there now.

    Args:
        target: (T, J), of which the first int(observed * T) frames are observed.
        codebook: where starts are looked for; by default among the learned mu.
        cancelled: asked before each iteration, and between the parts of its work.

    Raises:
        InputError: a target of another number of joints, too short, or not finite; a KL term for a
            model without sigma.
        Cancelled: `cancelled` said so.
    """
    return whole_steps(lm_pieces(model, target, config or LMConfig(), codebook=codebook), cancelled)


def lm_pieces(
    model: RNNPB, target: ArrayLike, config: LMConfig, *, codebook: Codebook | None = None
) -> Iterator[RecognitionStep | None]:
    """`recognize_lm`, cut finer: parts of an iteration are steps, too, a None each.

    Raises:
        InputError: see `recognize_lm`.
    """
    if config.beta and not model.stochastic:
        raise InputError("a deterministic model has no sigma, and so no KL term to minimise")
    seen = Observation.of(model, target, config.observed, config.joints)
    return _pieces(model, seen, config, codebook)


def _pieces(
    model: RNNPB, seen: Observation, config: LMConfig, codebook: Codebook | None
) -> Iterator[RecognitionStep | None]:
    starts = yield from _starts(model, seen, config, codebook)
    # The KL term beside a sum of squares: half of it belongs to each frame's beta.
    descent = Descent(
        starts,
        prior=model.stochastic and bool(model.config.beta),
        pull=config.beta * seen.frames / 2,
        weight=config.beta / len(seen.joints),
    )
    for iteration in range(config.iterations):
        mu, sigma, pb = descent.mu, descent.sigma(), descent.pb
        output = yield from _generate(model, pb, len(seen.target))
        loss = seen.losses(output)
        better = descent.judge(loss, config.tolerance)
        if better.any():
            residual = seen.seen(output - seen.target)[better]
            sums = yield from normal_equations(model, pb[better], residual, seen.joints)
            descent.linearise(better, *sums)
        descent.propose()
        yield RecognitionStep(
            iteration=iteration,
            mu=to_numpy(mu),
            sigma=to_numpy(sigma),
            pb=to_numpy(pb),
            loss=to_numpy(loss),
            kl=to_numpy(gaussian_kl(mu, sigma)),
            explained=to_numpy(seen.explained(loss)),
            prediction_error=to_numpy(seen.prediction_errors(output)),
            early_update=better.cpu().numpy(),
            output=to_numpy(output),
            mu_next=to_numpy(descent.mu),
            sigma_next=to_numpy(descent.sigma()),
        )
        if descent.done[descent.objective.argmin()]:
            return


def _starts(
    model: RNNPB, seen: Observation, config: LMConfig, codebook: Codebook | None
) -> Generator[None, None, Tensor]:
    """(K, D): the closest entries of the codebook that lie apart, or the closest learned mu."""
    if codebook is not None and codebook.entries:
        observation = to_numpy(seen.target[: seen.frames])
        count = starts_for(model, config.starts)
        yield
        return codebook.starts(observation, count, to_numpy(seen.joints)).to(model.mu)
    learned = model.mu.detach()
    distances = []
    for part in chunks(learned, seen.frames):
        distances.append(seen.losses_of(model, part))
        yield
    return learned[torch.cat(distances).argsort()[: config.starts]]


def _generate(model: RNNPB, pb: Tensor, steps: int) -> Generator[None, None, Tensor]:
    """(B, steps, J): `RNNPB.generate` in parts."""
    parts = []
    for part in chunks(pb, steps):
        parts.append(model.generate(part, steps))
        yield
    return torch.cat(parts)


class Descent:
    """Where K trials are, and what is known of the loss around there."""

    def __init__(self, starts: Tensor, prior: bool, pull: float = 0.0, weight: float = 0.0) -> None:
        """
        Args:
            prior: whether the belief has the prior's precision, too.
            pull, weight: of the KL term: to mu in the normal equations, beside a loss.
        """
        trials, dimensions = starts.shape
        self._pull, self._weight = pull, weight
        self._prior = 1.0 if prior else 0.0  # its precision
        self.pb = starts  # (K, D) to be tried next
        self.mu = starts  # (K, D) the best so far
        self.loss = starts.new_full((trials,), torch.inf)  # there
        self.objective = self.loss  # the same and the KL term of mu
        self.done = torch.zeros_like(self.loss, dtype=torch.bool)
        self._damping = torch.full_like(self.loss, DAMPING, dtype=torch.float64)
        # J^T J and J^T residual at mu. Squaring costs half of the digits: float64.
        self._normal = starts.new_zeros((trials, dimensions, dimensions), dtype=torch.float64)
        self._slope = starts.new_zeros((trials, dimensions), dtype=torch.float64)

    def judge(self, loss: Tensor, tolerance: float) -> Tensor:
        """(K,) whether what was tried is better; if so mu goes there."""
        objective = loss + self._weight / 2 * self.pb.square().sum(dim=1)
        better = objective < self.objective
        factor = torch.where(better, DAMPING_DOWN, DAMPING_UP)
        tried = self.objective.isfinite()  # a step, not only the start
        self._damping = torch.where(tried, self._damping * factor, self._damping)
        self.done |= better & (self.objective - objective < tolerance * self.objective)
        self.done |= objective < EXACT
        self.done |= self._damping > MAX_DAMPING
        self.loss = torch.where(better, loss, self.loss)
        self.objective = torch.where(better, objective, self.objective)
        self.mu = torch.where(better[:, None], self.pb, self.mu)
        return better

    def linearise(self, rows: Tensor, normal: Tensor, slope: Tensor) -> None:
        """Take J^T J (k, D, D) and J^T residual (k, D) at mu of the chosen rows."""
        self._normal[rows], self._slope[rows] = normal, slope

    def propose(self) -> None:
        """Set what to try next: the damped Gauss-Newton step from mu; nothing new when done."""
        scale = self._normal.diagonal(dim1=1, dim2=2).mean(dim=1).clamp(min=1e-12)
        damped = self._normal + torch.diag_embed(
            (self._damping * scale + self._pull)[:, None].expand_as(self.mu)
        )
        slope = self._slope + self._pull * self.mu
        step = torch.linalg.solve(damped, -slope).to(self.mu)
        self.pb = torch.where(self.done[:, None], self.mu, self.mu + step)

    def sigma(self) -> Tensor:
        """(K, D) marginal deviations of the belief; before anything is known, those of the prior.

        Infinite in every component that neither the observation nor a prior determines.
        """
        spread, vectors = principal_spread(self._normal, self.loss, self._prior)
        shares = vectors.square()  # of a component in an eigenvector
        rounding = spread.isinf()[:, None] & (shares < torch.finfo(torch.float32).eps)
        parts = torch.where(rounding, 0.0, shares * spread[:, None])
        return parts.sum(dim=2).sqrt().to(self.mu)


def principal_spread(normal: Tensor, loss: Tensor, prior: float) -> tuple[Tensor, Tensor]:
    """Variances (K, D) of Gaussian beliefs along their own axes, and these, (K, D, D) columns.

    Args:
        normal: (K, D, D) J^T J. loss: (K,) the variance that is left. prior: its precision.
    """
    variance = loss.double().clamp(min=MIN_VARIANCE)[:, None]
    values, vectors = torch.linalg.eigh(normal)
    seen = torch.where(values > BLIND * values[:, -1:], values, 0.0)
    return 1 / (seen / variance + prior), vectors


def posterior_pieces(model: RNNPB, pb: Tensor, seen: Observation) -> Iterator[Posterior | None]:
    """The belief at a PB (D,) where the loss is at a minimum, in pieces; the last one is it."""
    jacobians = []
    for part in jacobian_parts(model, pb[None], len(seen.target)):
        jacobians.append(part[0])
        yield None
    jacobian = torch.cat(jacobians).double()  # (T, J, D)
    with torch.no_grad():
        loss = seen.losses_of(model, pb[None])
    flat = jacobian[: seen.frames].index_select(1, seen.joints).flatten(0, 1)
    prior = 1.0 if model.stochastic and model.config.beta else 0.0
    spread, vectors = principal_spread((flat.mT @ flat)[None], loss, prior)
    axes = vectors[0] * spread[0].clamp(max=OPEN**2).sqrt()  # (D, D) columns
    yield Posterior(
        mu=pb.double().cpu().numpy(),
        covariance=(axes @ axes.mT).cpu().numpy(),
        deviation=(jacobian @ axes).norm(dim=2).cpu().numpy(),
    )


def normal_equations(
    model: RNNPB, pb: Tensor, residual: Tensor, joints: Tensor
) -> Generator[None, None, tuple[Tensor, Tensor]]:
    """J^T J (B, D, D), J^T r (B, D) at PBs (B, D), for residuals r (B, T, O) of joints (O,).

    In float64: squaring costs half of the digits. In pieces; the two are what it returns.
    """
    dimensions = pb.shape[1]
    normal = pb.new_zeros((*pb.shape, dimensions), dtype=torch.float64)
    slope = torch.zeros_like(pb, dtype=torch.float64)
    at_once = max(1, ROW_BYTES // ((1 + dimensions) * model.bias.nbytes))
    for rows in torch.arange(len(pb), device=pb.device).split(at_once):
        first = 0
        for jacobian in jacobian_parts(model, pb[rows], residual.shape[1]):
            frames = jacobian.shape[1]
            flat = jacobian.index_select(2, joints).flatten(1, 2).double()  # (b, t O, D)
            part = residual[rows, first : first + frames].flatten(1).double()
            normal[rows] += flat.mT @ flat
            slope[rows] += (flat.mT @ part[..., None]).squeeze(-1)
            first += frames
            yield
    return normal, slope


@torch.no_grad()
def pb_jacobian(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """Derivatives of the motions of PBs (B, D) with respect to them: (B, steps, J, D)."""
    return torch.cat(list(jacobian_parts(model, pb, steps)), dim=1)


def jacobian_parts(model: RNNPB, pb: Tensor, steps: int) -> Iterator[Tensor]:
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
    rows = len(pb) * (1 + pb.shape[1])
    at_once = max(1, min(PIECE_FRAMES, PIECE_ROWS // rows, PART_BYTES // (tangents.nbytes // 4)))
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
        if step == steps or len(hidden) >= at_once:
            yield (torch.stack(hidden, dim=1) @ model.weight_out.T).mT  # (B, t, J, D)
            hidden = []
