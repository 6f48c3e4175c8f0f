"""What a recognition came to, as a file: its path as a table, all of it as arrays, a figure."""

from __future__ import annotations

import csv
import io
import re

import numpy as np
from numpy.typing import NDArray

from ...core.motion import Motion
from ...core.recognition_run import RecognitionStep
from ..state.results import ExportedFile, RecognitionTrace
from ..state.work import TakeAwayWork
from .generation import Generation
from .job import Call, Priority, Round, Stage, Steps
from .sources import Sources

ENDS = {"path": " belief path.csv", "arrays": ".npz", "png": ".png", "svg": ".svg"}
ROWS = 3  # of a figure: the first iteration, one half-way, the last


def take_away(work: TakeAwayWork, sources: Sources) -> Steps:
    """The file."""
    trace, trial = work.trace, min(work.trial, work.trace.loss.shape[1] - 1)
    model, steps = sources.models[work.run.model], len(work.run.target)
    shown = sorted({0, trace.iterations // 2, trace.iterations - 1})[:ROWS]
    best = tuple(trace.pb[trace.best].tolist())
    wanted = [best] if work.what == "arrays" else []
    if work.what in ("png", "svg"):
        wanted = [tuple(trace.pb[iteration, trial].tolist()) for iteration in shown]
    motions = [Generation(model, pb, steps) for pb in wanted]
    if motions:
        yield Round(Priority.EXPORT, motions)
    positions = [motion.positions for motion in motions]
    if work.what == "path":
        file = Call(lambda: path_table(trace))
    elif work.what == "arrays":
        file = Call(lambda: arrays(trace, positions[0]))
    else:
        file = Call(lambda: _figure(work, sources, trial, dict(zip(shown, positions, strict=True))))
    yield Round(Priority.EXPORT, [file])
    name = re.sub(r"[^\w.+-]+", "_", work.name)[:80] + ENDS[work.what].replace(" ", "_")
    summary = f"{name}: {trace.iterations} iterations of {trace.loss.shape[1]} trials"
    yield Stage(ExportedFile(name, file.value, summary), done=True)


def path_table(trace: RecognitionTrace) -> bytes:
    """A row for each iteration of each trial; both are numbered from 1, as on the screen."""
    dimensions = range(1, trace.mu.shape[2] + 1)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(
        ["trial", "iteration"]
        + [f"{name}{d}" for name in ("mu", "sigma", "pb") for d in dimensions]
        + ["loss", "kl", "prediction_error", "early_update"]
    )
    for trial in range(trace.loss.shape[1]):
        for step in range(trace.iterations):
            at = step, trial
            numbers = (*trace.mu[at], *trace.sigma[at], *trace.pb[at])
            scalars = (trace.loss[at], trace.kl[at], trace.prediction_error[at])
            table.writerow(
                [trial + 1, step + 1]
                + [f"{float(value):.9g}" for value in (*numbers, *scalars)]
                + [int(trace.early_update[at])]
            )
    return text.getvalue().encode()


def arrays(trace: RecognitionTrace, output: NDArray[np.float32]) -> bytes:
    """An npz file with the trials first, as `rnnpb recognize` writes it, and the best motion."""
    names = ("mu", "sigma", "pb", "loss", "kl", "prediction_error", "early_update")
    content = {name: getattr(trace, name).swapaxes(0, 1) for name in names}
    if trace.posterior is not None:
        content["posterior_mu"] = trace.posterior.mu
        content["posterior_covariance"] = trace.posterior.covariance
        content["posterior_motion_deviation"] = trace.posterior.deviation
    file = io.BytesIO()
    np.savez_compressed(file, output=output, **content)
    return file.getvalue()


def _figure(
    work: TakeAwayWork, sources: Sources, trial: int, motions: dict[int, NDArray[np.float32]]
) -> bytes:
    """As Fig. 5, of one trial."""
    from ...core.paper.figures.recognition import iterations_figure
    from ...core.paper.figures.style import use_style

    run, model = work.run, sources.models[work.run.model]
    target = Motion(run.target.name, run.target.joints, run.target.array, run.target.fps)
    steps = [
        _step(work.trace, step, trial, motions.get(step)) for step in range(len(work.trace.pb))
    ]
    name = work.name.removeprefix(run.target.name).strip()
    figure = iterations_figure(
        name, model, target, steps, tuple(motions), run.observed, beta=run.beta
    )
    file = io.BytesIO()
    with use_style():
        figure.savefig(file, format=work.what, dpi=200)
    return file.getvalue()


def _step(
    trace: RecognitionTrace, step: int, trial: int, output: NDArray[np.float32] | None
) -> RecognitionStep:
    """One iteration of one trial; only those that are drawn have a motion."""
    at = slice(trial, trial + 1)
    return RecognitionStep(
        iteration=step,
        mu=trace.mu[step, at],
        sigma=trace.sigma[step, at],
        pb=trace.pb[step, at],
        loss=trace.loss[step, at],
        kl=trace.kl[step, at],
        explained=np.full(1, np.nan),
        prediction_error=trace.prediction_error[step, at],
        early_update=trace.early_update[step, at],
        output=np.empty((1, 0, 0)) if output is None else output[None],
        mu_next=trace.mu[step + 1, at],
        sigma_next=trace.sigma[step + 1, at],
    )
