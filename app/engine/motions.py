"""Motions, and what they ask of the robot a moment later."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.motion import Motion
from ...robot.safety import check_motion, limit_motion
from ..state.results import CheckedMotion, MotionResult
from ..state.work import MotionWork
from .generation import Generation
from .job import Call, Priority, Round, Stage, Steps
from .sources import Sources


def motion(work: MotionWork, sources: Sources) -> Steps:
    """The motion first: its check comes as a piece of its own."""
    generation = Generation(sources.models[work.model], work.pb, work.steps, work.along)
    yield Round(Priority.MOTION, [generation], finish=True)
    positions = generation.positions
    yield Stage(MotionResult(positions), done=work.check == "no")
    if work.check == "no":
        return
    check = Call(lambda: _check(work, sources, positions))
    yield Round(Priority.CHECK, [check])
    yield Stage(MotionResult(positions, check.value), done=True)


def _check(work: MotionWork, sources: Sources, positions: NDArray[np.float32]) -> CheckedMotion:
    moved = named_motion("", work.model, sources, positions)
    report = check_motion(moved, sources.robot)
    limited = limit_motion(moved, sources.robot).positions if work.check == "limited" else None
    return CheckedMotion(report, limited)


def named_motion(name: str, model: str, sources: Sources, positions: NDArray[np.float32]) -> Motion:
    """Positions (T, J) that a model generated, with its joints and rate."""
    info = sources.models[model].info
    return Motion(name, info.joints, positions, info.fps)
