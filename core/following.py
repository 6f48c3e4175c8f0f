"""Recognition of a motion while it arrives, frame by frame.

`Follower.update` takes a frame and returns the belief and what it foretells, in a few milliseconds.
At a fixed linearisation every new frame adds its J^T J and J^T r to sums of D x D and D numbers,
which is Bayes' rule for a Gaussian: recursive least squares. The motion is not linear in the PB, so
that once mu has moved one linearises anew. That takes longer than a frame (one pass over all frames
with D tangents, and the same for the best entry of a codebook, where the motion may have turned out
to be something else), so it goes on beside the updates; its result counts from the next one on.

What is minimised is the squared error over s^2, s the error scale of belief.py, plus the squared
Mahalanobis distance from the learned mu: in the first frames nothing else holds mu. Sigma is of the
same Gaussian, with the error that is left in place of s^2, as in recognition_lm.py.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from .belief import ERROR_SCALE, posterior
from .codebook import FRAMES, STRIDE, Codebook
from .errors import InputError
from .model import RNNPB
from .recognition_lm import MIN_VARIANCE, jacobian_parts, normal_equations
from .verdict import STILL

HORIZON = 300  # frames that are foretold, and more where a motion is longer
LONGER = 100  # frames by which the horizon grows then
BENT = 0.02  # radians, root mean square: how far the linear motion may be off the real one
STEPS = 2  # of Gauss-Newton, where one linearises anew
SPREAD = 1.5  # sd of the learned mu: deviation of the prior

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Followed:
    """The belief after a frame.

    frame: its number, from 0. mu, sigma: (D,). covariance: (D, D). loss: squared error of the
    foretold motion in all frames so far, averaged over observed joints. explained: share of their
    variance; None as long as nothing moves. foretold: (H, J) the whole motion, from the first
    frame on. milliseconds: that the update took.
    """

    frame: int
    mu: Array
    sigma: Array
    covariance: Array
    loss: float
    explained: float | None
    foretold: NDArray[np.float32]
    milliseconds: float


@dataclass(frozen=True, eq=False)
class _Line:
    """A linearisation: the motion (H, J) at mu (D,) and its Jacobian (H, J, D)."""

    mu: Tensor
    output: Tensor
    jacobian: Tensor


class Follower:
    """Follows one motion; used from one thread.

    Args:
        joints: indices of those that are observed; () means all.
        codebook: where other explanations are looked for; by default among the learned mu.
        beside: linearise on a thread of its own. Without it nothing is linearised but by `work`.
    """

    def __init__(
        self,
        model: RNNPB,
        *,
        joints: Sequence[int] = (),
        codebook: Codebook | None = None,
        horizon: int = HORIZON,
        scale: float = ERROR_SCALE,
        beside: bool = True,
    ) -> None:
        self._model = model
        self._joints = torch.tensor(sorted(set(joints)) or range(model.config.num_joints))
        self._codebook = codebook or _learned(model)
        self._horizon, self._scale = horizon, scale
        mu = model.mu.detach().cpu().double()
        self._mean = mu.mean(dim=0)
        spread = torch.cov(mu.T).reshape(len(mu.T), -1) if len(mu) > 1 else torch.eye(mu.shape[1])
        held = spread * SPREAD**2 + 1e-9 * torch.eye(mu.shape[1]) * max(float(spread.trace()), 1e-9)
        self._precision = torch.linalg.inv(held)  # of the prior
        self._frames: list[Tensor] = []
        self._sums = np.zeros(self._codebook.entries)
        self._line: _Line | None = None
        self._fresh: _Line | None = None  # made beside, not yet in use
        self._normal = torch.zeros_like(self._precision)
        self._slope = torch.zeros_like(self._mean)
        self._wanted = threading.Event()
        self._pieces: Iterator[_Line | None] | None = None
        self._closed = False
        self._thread: threading.Thread | None = None
        if beside:
            self._thread = threading.Thread(target=self._beside, name="follower", daemon=True)
            self._thread.start()

    def close(self) -> None:
        """End the thread beside."""
        self._closed = True
        self._wanted.set()
        if self._thread is not None:
            self._thread.join()

    def __enter__(self) -> Follower:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- a frame ---
    @torch.no_grad()
    def update(self, frame: ArrayLike) -> Followed:
        """Take the next frame, (J,) joint values; those of joints that are not observed are unused.

        Raises:
            InputError: another number of joints, or an observed one that is not finite.
        """
        started = time.perf_counter()
        x = torch.as_tensor(np.asarray(frame, np.float64))
        if x.shape != (self._model.config.num_joints,):
            raise InputError(f"a frame has {self._model.config.num_joints} joints, got {x.shape}")
        if not torch.isfinite(x[self._joints]).all():
            raise InputError(f"frame {len(self._frames)} holds NaN or infinity")
        self._frames.append(x)
        self._compare(x)
        if self._line is None:  # the first frame: there is nothing to go on with
            *_, self._fresh = self._linearise(self._best_entry(), self._horizon)
        fresh, self._fresh = self._fresh, None
        if fresh is not None:
            self._take(fresh)
        else:
            self._add(len(self._frames) - 1)
        return self._followed(started)

    def _compare(self, x: Tensor) -> None:
        """Add a kept frame to the codebook's sums."""
        at = len(self._frames) - 1
        if at % STRIDE or at >= FRAMES:
            return
        book = self._codebook
        here = book.motions[: len(self._sums), at // STRIDE][:, self._joints].double()
        self._sums += (here - x[self._joints]).square().mean(dim=1).numpy()

    def _take(self, line: _Line) -> None:
        """Go on from another linearisation, with all frames so far."""
        self._line = line
        self._normal.zero_()
        self._slope.zero_()
        count = min(len(self._frames), len(line.output))
        residual = (line.output[:count] - torch.stack(self._frames[:count]))[:, self._joints]
        flat = line.jacobian[:count].index_select(1, self._joints).flatten(0, 1)
        self._normal += flat.mT @ flat
        self._slope += flat.mT @ residual.flatten()

    def _add(self, at: int) -> None:
        """What one frame adds: (J, D) and (J,) numbers."""
        assert self._line is not None
        if at >= len(self._line.output):
            return  # the horizon grows with the next linearisation
        jacobian = self._line.jacobian[at][self._joints]
        residual = (self._line.output[at] - self._frames[at])[self._joints]
        self._normal += jacobian.mT @ jacobian
        self._slope += jacobian.mT @ residual

    def _followed(self, started: float) -> Followed:
        line, seen = self._line, torch.stack(self._frames)[:, self._joints]
        assert line is not None
        mu = line.mu + self._step(self._normal, self._slope, line.mu)
        motion = self._motion(mu, max(len(line.output), len(seen)))
        error = _error(motion[: len(seen), self._joints], seen)
        linear = line.output + line.jacobian @ (mu - line.mu)
        bent = float((linear - motion[: len(linear)]).square().mean().sqrt())
        there = _error(line.output[: len(seen), self._joints], seen[: len(line.output)])
        if error > there:  # too long a step
            mu, motion, error = line.mu, self._motion(line.mu, len(motion)), there
        new = (len(self._frames) - 1) % STRIDE == 0 or len(motion) > len(line.output)
        if bent > BENT or new:
            self._wanted.set()
        foretold = motion[: max(self._horizon, len(seen))]
        variance = float((seen - seen.mean(dim=0)).square().mean())
        covariance = torch.linalg.inv(self._normal / max(error, MIN_VARIANCE) + self._precision)
        return Followed(
            frame=len(seen) - 1,
            mu=mu.numpy(),
            sigma=covariance.diagonal().sqrt().numpy(),
            covariance=covariance.numpy(),
            loss=error,
            explained=1 - error / variance if variance >= STILL else None,
            foretold=foretold.float().numpy(),
            milliseconds=1e3 * (time.perf_counter() - started),
        )

    def _step(self, normal: Tensor, slope: Tensor, mu: Tensor) -> Tensor:
        """(..., D) the Gauss-Newton step from mu, held by the prior."""
        hold = self._precision * self._scale**2
        down = slope + (mu - self._mean) @ hold
        step: Tensor = -torch.linalg.solve(normal + hold, down[..., None]).squeeze(-1)
        return step

    def _motion(self, mu: Tensor, steps: int) -> Tensor:
        pb = mu.to(self._model.mu)[None]
        return self._model.generate(pb, steps)[0].cpu().double()

    def shares(self) -> NDArray[np.float64]:
        """(n,) the belief over the codebook's entries, from the kept frames so far."""
        return posterior(self._sums, self._scale)

    # --- beside the frames ---
    def work(self) -> bool:
        """Do a piece of a linearisation that is wanted; whether there was one."""
        if self._pieces is None:
            if not self._wanted.is_set() or self._line is None:
                return False
            self._wanted.clear()
            self._pieces = self._anew(self._line.mu, torch.stack(self._frames))
        with torch.no_grad():
            line = next(self._pieces)
        if line is not None:
            self._fresh, self._pieces = line, None
        return True

    def _beside(self) -> None:
        while True:
            self._wanted.wait()
            while not self._closed and self.work():
                pass
            if self._closed:
                return

    def _anew(self, mu: Tensor, seen: Tensor) -> Iterator[_Line | None]:
        """Some steps from `mu` and from the best entry, in one batch; then the best one's line."""
        at = torch.stack([mu, self._best_entry()])
        tried: list[tuple[float, Tensor]] = []
        for step in range(STEPS + 1):
            motions = self._model.generate(at.to(self._model.mu), len(seen)).cpu().double()
            residual = (motions - seen)[:, :, self._joints]  # (2, T, O)
            far = at - self._mean
            objective = residual.square().sum(dim=(1, 2)) / self._scale**2
            objective += ((far @ self._precision) * far).sum(dim=1)
            tried += zip(objective.tolist(), at, strict=True)
            if step < STEPS:
                there = self._model.mu
                normal, slope = yield from normal_equations(
                    self._model, at.to(there), residual.to(there), self._joints.to(there.device)
                )
                at = at + self._step(normal.cpu(), slope.cpu().double(), at)
        _, best = min(tried, key=lambda one: one[0])
        yield from self._linearise(best, max(self._horizon, len(seen) + LONGER))

    def _linearise(self, mu: Tensor, steps: int) -> Iterator[_Line | None]:
        parts = []
        for part in jacobian_parts(self._model, mu.to(self._model.mu)[None], steps):
            parts.append(part[0].cpu().double())
            yield None
        yield _Line(mu, self._motion(mu, steps), torch.cat(parts))

    def _best_entry(self) -> Tensor:
        return self._codebook.pbs[int(self._sums.argmin())].double()


def _learned(model: RNNPB) -> Codebook:
    """The learned motions alone, as a codebook."""
    codebook = Codebook(model, model.config.num_motions)
    while not codebook.complete:
        for _ in codebook.grow():
            pass
    return codebook


def _error(motion: Tensor, seen: Tensor) -> float:
    return float((motion - seen).square().mean())
