"""Pages of the engine, as the benchmarks use them."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from rnnpb_explorer.app.engine.engine import Delivered, Delivery, Engine
from rnnpb_explorer.app.state.document import Target
from rnnpb_explorer.app.state.results import MotionResult
from rnnpb_explorer.app.state.work import LandscapeWork, MotionWork
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.robot.description import load_robot

MODEL = "strong"
FRAMES = 140
STEP = 1e-3  # of a component of mu, from one work to the next


class Pages:
    """An engine, its works in order, and a page to ask with."""

    def __init__(self, model: RNNPB, rest_seconds: float) -> None:
        self._mu = tuple(model.mu[0].tolist())
        data = {MODEL: (None,) * model.config.num_motions}
        robot = load_robot("pepper")
        self.engine = Engine({MODEL: model}, data, robot, rest_seconds=rest_seconds)
        self.workers = len(self.engine._threads)
        self._done = threading.Event()
        self._page = self.engine.open(self._take)

    def motion(self, number: int, page: int = 0) -> MotionWork:
        return MotionWork(MODEL, self._point(number, page), FRAMES, "report")

    def landscape(self, number: int, target: Target, page: int = 0) -> LandscapeWork:
        zeros = (0.0,) * (len(self._mu) - 2)
        directions = ((1.0, 0.0, *zeros), (0.0, 1.0, *zeros))
        point = self._point(number, page)
        return LandscapeWork(MODEL, point, directions, (0.0, 0.0, *zeros), 1.0, target, -1)

    def complete(self, work: LandscapeWork) -> None:
        """Have a landscape done."""
        self._done.clear()
        self._page.want({("landscape", 0): work})
        self._done.wait()

    def close(self) -> None:
        self.engine.close(10.0)

    def _point(self, number: int, page: int) -> tuple[float, ...]:
        return (self._mu[0] + STEP * number, self._mu[1] + STEP * page, *self._mu[2:])

    def _take(self, delivery: Delivery) -> None:
        if not isinstance(delivery, Delivered):
            raise RuntimeError(delivery.message)
        if delivery.done:
            self._done.set()


@dataclass
class Drag:
    """What a page that drags has asked for, and when which of it was there."""

    asked: list[float] = field(default_factory=list)
    numbers: dict[MotionWork, int] = field(default_factory=dict)
    arrived: list[tuple[int, float]] = field(default_factory=list)  # number of a motion, time
    coarse: int = 0

    def take(self, delivery: Delivery) -> None:
        if not isinstance(delivery, Delivered):
            raise RuntimeError(delivery.message)
        if not isinstance(delivery.result, MotionResult):
            self.coarse += 1
        elif delivery.result.check is None:
            assert isinstance(delivery.work, MotionWork)
            self.arrived.append((self.numbers[delivery.work], time.perf_counter()))

    @property
    def lags(self) -> Sequence[float]:
        """Seconds from each wish until that motion, or a newer one, was there."""
        lags: list[float] = []
        for number, then in self.arrived:
            lags += [then - asked for asked in self.asked[len(lags) : number + 1]]
        return lags
