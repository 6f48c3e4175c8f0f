"""What pages see of the engine; see the package for its parts."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import joblib

from ...core.model import RNNPB
from ...core.motion import Motion
from ...robot.description import Robot
from .crew import Crew, Page
from .deliveries import Delivered, Delivery, Failed
from .sources import REST_SECONDS, Sources
from .works import steps_of

__all__ = ["Delivered", "Delivery", "Engine", "Failed", "Page"]


class Engine(Crew):
    """Computes for all pages of the process: motions, landscapes, recognitions, files.

    Args:
        models: by name; one that is added to it later can be computed with as well.
        data: of each model, of each of its motions: the training motion where there is one.
        workers: threads, one a core by default.
        clock: seconds that never go back.
        rest_seconds: how long a landscape has been wanted before it is completed.
    """

    def __init__(
        self,
        models: Mapping[str, RNNPB],
        data: Mapping[str, Sequence[Motion | None]],
        robot: Robot,
        workers: int | None = None,
        *,
        clock: Callable[[], float] = time.monotonic,
        rest_seconds: float = REST_SECONDS,
    ) -> None:
        if workers is None:
            workers = joblib.cpu_count()  # those that this process may use
        sources = Sources(models, data, robot, max(workers, 1), rest_seconds)
        super().__init__(partial(steps_of, sources), workers, clock)
