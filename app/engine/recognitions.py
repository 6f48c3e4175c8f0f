"""Recognition, one iteration a piece, as a trace that grows."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from ...core.errors import InputError
from ...core.following import Follower
from ...core.observation import Observation
from ...core.recognition import recognition_pieces
from ...core.recognition_lm import LMConfig, lm_pieces, posterior_pieces
from ...core.recognition_run import (
    LM_ITERATIONS,
    Posterior,
    RecognitionConfig,
    RecognitionStep,
)
from ..state.document import MAX_PB
from ..state.results import RecognitionTrace
from ..state.work import RecogniseWork
from .beliefs import growth
from .generation import batch_size
from .job import Call, Last, Priority, Round, Stage, Steps, Task
from .sources import Sources

ENOUGH = 1_024  # entries of a codebook: a global search waits for as many
WIDEST = 10.0  # sd of the learned mu: deviation of what nothing determines
BESIDE = 3  # pieces of a linearisation between two frames of a motion that arrives

Pieces = Iterator[RecognitionStep | None]


def recognition(work: RecogniseWork, sources: Sources, wanted_at: float) -> Steps:
    """A recognition by any method, a stage an iteration.

    Raises:
        InputError: the target does not fit, or the run has left what a document can hold.
    """
    if work.method == "live":
        return _live(work, sources, wanted_at)
    return _global(work, sources) if work.method == "global" else _published(work, sources)


def _published(work: RecogniseWork, sources: Sources) -> Steps:
    """The published procedure (section III.D)."""
    model = sources.models[work.model]
    assert work.iterations is not None
    config = RecognitionConfig(
        init=work.init,
        observed=work.observed,
        iterations=work.iterations,
        trials=work.trials,
        seed=work.seed,
        joints=work.joints,
        beta=work.beta,
    )
    at_once = batch_size(model, max(1, int(work.observed * len(work.target))))
    pieces = recognition_pieces(model, work.target.array, config, at_once=at_once)
    yield from _iterations(pieces, model.config.pb_dim, work.iterations)


def _global(work: RecogniseWork, sources: Sources) -> Steps:
    """Levenberg-Marquardt from the best of the codebook as it is by now, and the belief there."""
    model, book = sources.models[work.model], sources.codebook(work.model)
    if not book.entries:
        yield Round(Priority.RECOGNITION, [Call(book.restore)])
    while book.entries < min(ENOUGH, len(book)):
        yield growth(book, sources, Priority.RECOGNITION)
    config = LMConfig(
        observed=work.observed,
        iterations=work.iterations or LM_ITERATIONS,
        joints=work.joints,
        beta=work.beta,
    )
    pieces = lm_pieces(model, work.target.array, config, codebook=book)
    pieces = _drawable(pieces, WIDEST * book.scale)
    path = yield from _iterations(pieces, model.config.pb_dim)
    trace = path.trace()
    if work.iterations is not None:  # somebody ended it there
        yield Stage(trace, done=True)
        return
    best = torch.as_tensor(trace.pb[trace.best]).to(model.mu)
    seen = Observation.of(model, work.target.array, work.observed, work.joints)
    belief = Last(posterior_pieces(model, best, seen))
    yield Round(Priority.RECOGNITION, [belief])
    assert isinstance(belief.result, Posterior)
    yield Stage(path.trace(finished=True, posterior=belief.result), done=True)


def _live(work: RecogniseWork, sources: Sources, wanted_at: float) -> Steps:
    """Frame by frame at the motion's own rate, from nothing but the frames so far."""
    model, book = sources.models[work.model], sources.codebook(work.model)
    if not book.entries:
        yield Round(Priority.LIVE, [Call(book.restore)])
    if not book.entries:
        yield growth(book, sources, Priority.LIVE)
    target = work.target.array
    follower = Follower(model, joints=work.joints, codebook=book, horizon=len(target), beside=False)
    path = _Path(1, model.config.pb_dim)
    frames = int(work.observed * len(target))
    for number in range(work.iterations or frames):
        frame = _Frame(follower, target, number, work)
        beside = _Beside(follower)
        due = wanted_at + number / work.target.fps
        yield Round(Priority.LIVE, [frame, beside], not_before=due)
        path.add(frame.result)
        yield Stage(path.trace(), done=False)
    yield Stage(path.trace(finished=work.iterations is None), done=True)


def _iterations(
    pieces: Pieces, pb_dim: int, last: int | None = None
) -> Generator[Round | Stage, None, _Path]:
    """All of a run's iterations, to its own end or to the last one; returns the path."""
    path: _Path | None = None
    while True:
        iteration = _Iteration(pieces)
        yield Round(Priority.RECOGNITION, [iteration])
        if iteration.result is None:
            assert path is not None
            return path
        path = path or _Path(len(iteration.result.loss), pb_dim)
        fault = _fault(iteration.result)
        if fault is not None:  # no board could draw it; what was finite stays
            raise InputError(fault)
        path.add(iteration.result)
        trace = path.trace()
        yield Stage(trace, done=trace.iterations == last)
        if trace.iterations == last:
            return path


def _drawable(pieces: Pieces, widest: float) -> Pieces:
    """With a deviation where a direction is open, which has none: no board could draw it."""
    for piece in pieces:
        if piece is not None:
            piece = replace(
                piece,
                sigma=np.minimum(piece.sigma, widest),
                sigma_next=np.minimum(piece.sigma_next, widest),
                kl=np.where(np.isfinite(piece.kl), piece.kl, np.nan),
            )
        yield piece


class _Iteration(Task):
    """The next iteration; before the first, the search for where to start. None at the end."""

    def __init__(self, pieces: Pieces) -> None:
        self.result: RecognitionStep | None = None
        super().__init__(self._until_the_step(pieces))

    def _until_the_step(self, pieces: Pieces) -> Iterator[None]:
        while True:
            with torch.no_grad():
                piece = next(pieces, self)
            if piece is self:
                return
            if isinstance(piece, RecognitionStep):
                self.result = piece
                return
            yield


class _Frame(Task):
    """What a follower makes of a frame, as an iteration."""

    def __init__(
        self, follower: Follower, target: NDArray[np.float32], number: int, work: RecogniseWork
    ) -> None:
        self._follower, self._target, self._number, self._work = follower, target, number, work
        self.result: RecognitionStep

    def step(self, riders: Sequence[Task] = ()) -> bool:
        belief = self._follower.update(self._target[self._number])
        later = slice(self._number + 1, None)
        joints = list(self._work.joints) or slice(None)
        rest = (belief.foretold[: len(self._target)] - self._target)[later, joints]
        mu, sigma = belief.mu[None], belief.sigma[None]
        self.result = RecognitionStep(
            iteration=self._number,
            mu=mu,
            sigma=sigma,
            pb=mu,
            loss=np.array([belief.loss]),
            kl=np.full(1, np.nan),
            explained=np.full(1, np.nan if belief.explained is None else belief.explained),
            prediction_error=np.array([np.square(rest).mean() if rest.size else np.nan]),
            early_update=np.zeros(1, dtype=bool),
            output=belief.foretold[None],
            mu_next=mu,
            sigma_next=sigma,
        )
        return True


class _Beside(Task):
    """Some pieces of what a follower does beside the frames."""

    def __init__(self, follower: Follower) -> None:
        self._follower = follower

    def step(self, riders: Sequence[Task] = ()) -> bool:
        for _ in range(BESIDE):
            if not self._follower.work():
                break
        return True


class _Path:
    """All iterations so far: a step writes its own rows, and a trace is a view of them.

    The rows of a trace that went out are not written again but for the last mu and sigma, which
    the next step writes anew with the same values. A step's motions are not kept.
    """

    def __init__(self, trials: int, pb_dim: int) -> None:
        self._steps, self._room = 0, 32
        self._rows: dict[str, NDArray[Any]] = {
            "mu": np.empty((self._room + 1, trials, pb_dim)),
            "sigma": np.empty((self._room + 1, trials, pb_dim)),
            "pb": np.empty((self._room, trials, pb_dim)),
            "loss": np.empty((self._room, trials)),
            "kl": np.empty((self._room, trials)),
            "prediction_error": np.empty((self._room, trials)),
            "early_update": np.empty((self._room, trials), dtype=np.bool_),
        }

    def add(self, step: RecognitionStep) -> None:
        at = self._steps
        if at == self._room:  # traces that went out keep the old arrays
            self._room *= 2
            for name, rows in self._rows.items():
                more = np.empty((self._room + (len(rows) > at), *rows.shape[1:]), rows.dtype)
                more[: len(rows)] = rows
                self._rows[name] = more
        for name, rows in self._rows.items():
            rows[at] = getattr(step, name)
        self._rows["mu"][at + 1], self._rows["sigma"][at + 1] = step.mu_next, step.sigma_next
        self._steps += 1

    def trace(
        self, *, finished: bool = False, posterior: Posterior | None = None
    ) -> RecognitionTrace:
        """The iterations so far."""
        now = self._steps
        views: dict[str, Any] = {
            name: rows[: now + (name in ("mu", "sigma"))] for name, rows in self._rows.items()
        }
        return RecognitionTrace(**views, finished=finished, posterior=posterior)


def _fault(step: RecognitionStep) -> str | None:
    """The first of a step's values that no document can hold, in a line; None where all can be."""
    for name, values, bound in (
        ("μ", step.mu, MAX_PB),
        ("σ", step.sigma, MAX_PB),
        ("PB", step.pb, MAX_PB),
        ("loss", step.loss[:, None], np.inf),
        ("μ", step.mu_next, MAX_PB),
        ("σ", step.sigma_next, MAX_PB),
    ):
        for trial, row in enumerate(values, start=1):
            if not (np.abs(row) <= bound).all() or not np.isfinite(row).all():
                what = f"beyond {bound:,.0f}" if np.isfinite(row).all() else "not finite"
                return f"the {name} of trial {trial} is {what} in iteration {step.iteration + 1}"
    return None
