"""A motion as a file for a real robot."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ...robot.export import Export, export_motion
from ..state.results import ExportedFile
from ..state.work import ExportWork
from .generation import Generation
from .job import Call, Priority, Round, Stage, Steps
from .motions import named_motion
from .sources import Sources

MOST_JOINTS = 4  # in the line on a file


def export(work: ExportWork, sources: Sources) -> Steps:
    """The text of the file, and one line on what is in it."""
    motion = work.motion
    model = sources.models[motion.model]
    generation = Generation(model, motion.pb, motion.steps, motion.along)
    yield Round(Priority.EXPORT, [generation])
    file = Call(lambda: _file(work, sources, generation.positions))
    yield Round(Priority.EXPORT, [file])
    yield Stage(file.value, done=True)


def _file(work: ExportWork, sources: Sources, positions: NDArray[np.float32]) -> ExportedFile:
    exported = export_motion(
        named_motion(work.name, work.motion.model, sources, positions),
        sources.robot,
        work.options.file_format,
        safe_posture=work.options.safe_posture,
        enforce_limits=not work.options.beyond_limits,
    )
    file_name = re.sub(r"[^\w.+-]+", "_", work.name)[:80] + exported.suffix
    summary = export_summary(file_name, exported, insisted=work.options.beyond_limits)
    return ExportedFile(file_name, exported.content.encode(), summary)


def export_summary(file_name: str, export: Export, *, insisted: bool) -> str:
    """One line on a file that was written."""
    line = f"{file_name}: {len(export.motion)} frames"
    if insisted:
        beyond = ", beyond the limits of the robot" if export.report.violations else ""
        return f"{line}, as generated{beyond}"
    if not export.changes:
        return f"{line}, within the limits as generated"
    worst = sorted(export.changes.items(), key=lambda item: -item[1])
    joints = ", ".join(f"{joint} by up to {change:.3f}" for joint, change in worst[:MOST_JOINTS])
    more = f" and {len(worst) - MOST_JOINTS} more" if len(worst) > MOST_JOINTS else ""
    return f"{line}, limited: {joints}{more}"
