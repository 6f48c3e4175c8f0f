"""Which generator computes which work."""

from __future__ import annotations

from typing import assert_never

from ..state.work import (
    BeliefWork,
    CodebookWork,
    ExportWork,
    LandscapeWork,
    MotionWork,
    RecogniseWork,
    StretchWork,
    TakeAwayWork,
    WaysWork,
    Work,
)
from .beliefs import belief, codebook
from .exports import export
from .job import Steps
from .landscapes import landscape
from .motions import motion
from .recognitions import recognition
from .smoothness import stretch_here, ways
from .sources import Sources
from .take_away import take_away


def steps_of(sources: Sources, work: Work, wanted_at: float) -> Steps:
    """
    Args:
        wanted_at: when a page first wanted it, on the engine's clock.
    """
    match work:
        case CodebookWork():
            return codebook(work, sources)
        case StretchWork():
            return stretch_here(work, sources)
        case WaysWork():
            return ways(work, sources)
        case BeliefWork():
            return belief(work, sources)
        case TakeAwayWork():
            return take_away(work, sources)
        case MotionWork():
            return motion(work, sources)
        case LandscapeWork():
            return landscape(work, sources, wanted_at)
        case RecogniseWork():
            return recognition(work, sources, wanted_at)
        case ExportWork():
            return export(work, sources)
        case _:
            assert_never(work)
