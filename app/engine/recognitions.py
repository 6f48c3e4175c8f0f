"""Recognition, one iteration a piece, as a trace that grows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.errors import InputError
from ...core.recognition import recognition_pieces
from ...core.recognition_run import RecognitionConfig, RecognitionStep
from ..state.document import MAX_PB
from ..state.results import RecognitionTrace
from ..state.work import RecogniseWork
from .generation import batch_size
from .job import Priority, Round, Stage, Steps, Task
from .sources import Sources


def recognition(work: RecogniseWork, sources: Sources) -> Steps:
    """The published procedure (section III.D), a stage an iteration.

    Raises:
        InputError: the target does not fit, or the run has left what a document can hold.
    """
    model = sources.models[work.model]
    config = RecognitionConfig(
        init=work.init,
        observed=work.observed,
        iterations=work.iterations,
        trials=work.trials,
        seed=work.seed,
    )
    path = _Path(work, model.config.pb_dim)
    at_once = batch_size(model, max(1, int(work.observed * len(work.target))))
    pieces = recognition_pieces(model, work.target.array, config, at_once=at_once)
    for _ in range(work.iterations):
        iteration = _Iteration(pieces)
        yield Round(Priority.RECOGNITION, [iteration])
        fault = _fault(iteration.result)
        if fault is not None:  # no board could draw it; what was finite stays
            raise InputError(fault)
        trace = path.add(iteration.result)
        yield Stage(trace, done=trace.iterations == work.iterations)


class _Iteration(Task):
    """The next iteration; before the first, the search for where to start."""

    def __init__(self, pieces: Iterator[RecognitionStep | None]) -> None:
        super().__init__(self._until_the_step(pieces))
        self.result: RecognitionStep

    def _until_the_step(self, pieces: Iterator[RecognitionStep | None]) -> Iterator[None]:
        for piece in pieces:
            if piece is not None:
                self.result = piece
                return
            yield


class _Path:
    """Room for all iterations of a run: a step writes its own rows, and a trace is a view of them.

    The rows of a trace that went out are not written again but for the last mu and sigma, which
    the next step writes anew with the same values. A step's motions are not kept.
    """

    def __init__(self, work: RecogniseWork, pb_dim: int) -> None:
        shape = (work.iterations, work.trials)
        self._steps = 0
        self._mu = np.empty((work.iterations + 1, work.trials, pb_dim))
        self._sigma = np.empty_like(self._mu)
        self._pb = np.empty((*shape, pb_dim))
        self._loss = np.empty(shape)
        self._prediction_error = np.empty(shape)
        self._early_update = np.empty(shape, dtype=np.bool_)

    def add(self, step: RecognitionStep) -> RecognitionTrace:
        """The trace with this step at its end."""
        at = self._steps
        self._steps = now = at + 1
        self._mu[at : at + 2] = step.mu, step.mu_next
        self._sigma[at : at + 2] = step.sigma, step.sigma_next
        self._pb[at] = step.pb
        self._loss[at] = step.loss
        self._prediction_error[at] = step.prediction_error
        self._early_update[at] = step.early_update
        return RecognitionTrace(
            mu=self._mu[: now + 1],
            sigma=self._sigma[: now + 1],
            pb=self._pb[:now],
            loss=self._loss[:now],
            prediction_error=self._prediction_error[:now],
            early_update=self._early_update[:now],
        )


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
