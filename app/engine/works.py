"""Which generator computes which work."""

from __future__ import annotations

from typing import assert_never

from ..state.work import ExportWork, LandscapeWork, MotionWork, RecogniseWork, Work
from .exports import export
from .job import Steps
from .landscapes import landscape
from .motions import motion
from .recognitions import recognition
from .sources import Sources


def steps_of(sources: Sources, work: Work, wanted_at: float) -> Steps:
    """
    Args:
        wanted_at: when a page first wanted it, on the engine's clock.
    """
    match work:
        case MotionWork():
            return motion(work, sources)
        case LandscapeWork():
            return landscape(work, sources, wanted_at)
        case RecogniseWork():
            return recognition(work, sources)
        case ExportWork():
            return export(work, sources)
        case _:
            assert_never(work)
