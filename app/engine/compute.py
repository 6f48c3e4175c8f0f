"""The computations behind the screen, each an iterator of intents, run on a lane of the worker."""

from __future__ import annotations

import re
from collections.abc import Iterator
from threading import Event

import numpy as np
import torch
from numpy.typing import NDArray

from ...core.correlation import landscape_stages
from ...core.model import RNNPB
from ...core.motion import Motion
from ...core.recognition import recognize
from ...core.recognition_run import RecognitionConfig, RecognitionStep
from ...robot.description import Robot
from ...robot.export import export_motion
from ...robot.safety import check_motion, limit_motion
from ..page.words import export_summary
from ..state import intents as do
from ..state.document import CheckedMotion, ComputedLandscape, RecognitionTrace

REST_SECONDS = 0.15  # the complete landscape begins when its slice has rested this long


class Computations:
    """The loaded models and what can be asked of them."""

    def __init__(self, models: tuple[RNNPB, ...], robot: Robot) -> None:
        self._models, self._robot = models, robot

    @torch.inference_mode()
    def generate(self, work: do.GenerateWork, cancelled: Event) -> Iterator[do.Intent]:
        """The motion of a PB; in the same batch the reconstruction that it is compared with.

        The motion goes out first: what it asks of the robot may come a moment later.
        """
        model = self._models[work.model]
        pb = torch.as_tensor(work.pb, dtype=torch.float32, device=model.mu.device)[None]
        if work.target is not None:
            positions = model.generate(pb, work.steps)[0].cpu().numpy()
            reference = work.target
        else:
            both = model.generate(torch.cat([pb, model.mu[work.motion][None]]), work.steps)
            positions, reference = both.cpu().numpy()
        yield do.MotionReady(work.model, work.request, positions, reference)
        yield do.MotionChecked(work.model, self._check(work, positions))

    def _check(self, work: do.GenerateWork, positions: NDArray[np.float32]) -> CheckedMotion:
        motion = self._motion(work.model, "", positions)
        report = check_motion(motion, self._robot)
        limited = limit_motion(motion, self._robot).positions if work.limited else None
        return CheckedMotion(work.request, report, limited)

    def _motion(self, model: int, name: str, positions: NDArray[np.float32]) -> Motion:
        info = self._models[model].info
        return Motion(name, info.joints, positions, info.fps)

    def export(self, work: do.ExportWork, cancelled: Event) -> Iterator[do.Intent]:
        """The text of a file for a robot, and one line on what is in it."""
        options = work.options
        exported = export_motion(
            self._motion(work.model, work.name, work.positions),
            self._robot,
            options.file_format,
            safe_posture=options.safe_posture,
            enforce_limits=not options.beyond_limits,
        )
        file_name = re.sub(r"[^\w.+-]+", "_", work.name)[:80] + exported.suffix
        summary = export_summary(file_name, exported, insisted=options.beyond_limits)
        yield do.ExportReady(work.request, file_name, exported.content, summary)

    def landscape(self, work: do.LandscapeWork, cancelled: Event) -> Iterator[do.Intent]:
        """Coarse at once, whatever comes next; complete when the slice has rested for a moment."""
        model = self._models[work.model]
        target = work.target
        if target is None:
            target = model.reconstruct(work.motion).cpu().numpy()
        coarse = Event()  # the coarse stage is never cancelled: a drag would starve it
        stages = landscape_stages(
            model,
            target,
            work.center,
            directions=work.directions,
            radius=work.radius,
            origin=work.zero,
            cancelled=lambda: coarse.is_set() and cancelled.is_set(),
        )
        for stage in stages:
            yield do.LandscapeReady(work.model, ComputedLandscape(work.request, stage))
            coarse.set()
            if not stage.complete and cancelled.wait(REST_SECONDS):
                return

    def recognise(self, work: do.RecogniseWork, cancelled: Event) -> Iterator[do.Intent]:
        """The published procedure (section III.D), one intent an iteration."""
        config = RecognitionConfig(
            init=work.init,
            observed=work.observed,
            iterations=work.iterations,
            trials=work.trials,
            seed=work.seed,
        )
        model = self._models[work.model]
        path = _Path(work, model.config.pb_dim)
        for step in recognize(model, work.target, config, cancelled=cancelled.is_set):
            fault = _fault(step)
            if fault is not None:  # no board could draw it; what was finite stays
                yield do.WorkFailed("recognition", work.request, fault)
                return
            yield do.RecognitionStepped(work.request, path.add(step))
        yield do.RecognitionFinished(work.request)


class _Path:
    """Room for all iterations of a run: a step writes its own rows, and a trace is a view of them.

    The rows of a trace that went out are not written again but for the last mu and sigma, which
    the next step writes anew with the same values. A step's motions are not kept.
    """

    def __init__(self, work: do.RecogniseWork, pb_dim: int) -> None:
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
    """The first of a step's values that is no number any more, in a line; None where all are."""
    for name, values in (
        ("μ", step.mu),
        ("σ", step.sigma),
        ("PB", step.pb),
        ("loss", step.loss[:, None]),
        ("μ", step.mu_next),
        ("σ", step.sigma_next),
    ):
        finite = np.isfinite(values).all(axis=1)  # (K,)
        if not finite.all():
            trial = int(finite.argmin()) + 1
            return f"the {name} of trial {trial} is not finite in iteration {step.iteration + 1}"
    return None
