"""A crew without threads, whose works are names and whose pieces only say that they were done."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rnnpb_explorer.app.engine.crew import Crew, Page
from rnnpb_explorer.app.engine.deliveries import Delivered, Delivery, Failed
from rnnpb_explorer.app.engine.job import Call, Priority, Round, Stage, Steps, Task
from rnnpb_explorer.app.state.results import ExportedFile
from rnnpb_explorer.core.errors import InputError

REST = 0.5


class Shop:
    """
    pieces: what was done, in order. begun: the works that were begun, in order.
    now: the clock, which only a test moves.
    """

    def __init__(self, workers: int = 0) -> None:
        self.now = 0.0
        self.pieces: list[str] = []
        self.begun: list[str] = []
        self._kinds: dict[str, Callable[[str, float], Steps]] = {
            "motion": self._motion,
            "landscape": self._landscape,
            "recognition": self._recognition,
            "wrong": self._wrong,
            "broken": self._broken,
            "late": self._late,
            "together": self._together,
        }
        self.crew = Crew(self._begin, workers, lambda: self.now)  # type: ignore[arg-type]

    def page(self) -> ShopPage:
        return ShopPage(self.crew)

    def run(self, steps: int | None = None) -> list[str]:
        """Do so many pieces, or all there are; what was done."""
        before = len(self.pieces)
        while (steps is None or len(self.pieces) < before + steps) and self.crew.run_one():
            pass
        return self.pieces[before:]

    def _begin(self, work: str, wanted_at: float) -> Steps:
        self.begun.append(work)
        return self._kinds[work.split()[0]](work, wanted_at)

    def piece(self, name: str) -> Task:
        return Call(lambda: self.pieces.append(name))

    def _motion(self, work: str, wanted_at: float) -> Steps:
        """One piece, and a check."""
        yield Round(Priority.MOTION, [self.piece(work)], finish=True)
        yield stage(work)
        yield Round(Priority.CHECK, [self.piece(f"check {work}")])
        yield stage(f"checked {work}", done=True)

    def _landscape(self, work: str, wanted_at: float) -> Steps:
        """Two rounds of two pieces that come to a coarse stage; after a rest two more."""
        for _ in range(2):
            pieces = [self.piece(f"coarse {work}") for _ in range(2)]
            yield Round(Priority.COARSE, pieces, finish=True)
        yield stage(f"coarse {work}")
        pieces = [self.piece(f"complete {work}") for _ in range(2)]
        yield Round(Priority.COMPLETE, pieces, not_before=wanted_at + REST)
        yield stage(f"complete {work}", done=True)

    def _recognition(self, work: str, wanted_at: float) -> Steps:
        """Four pieces, a stage each."""
        for number in range(1, 5):
            yield Round(Priority.RECOGNITION, [self.piece(work)])
            yield stage(f"{work} {number}", done=number == 4)

    def _wrong(self, work: str, wanted_at: float) -> Steps:
        """Input that is wrong, found in the second piece."""
        yield Round(Priority.MOTION, [self.piece(work)])
        yield stage(work)

        def fault() -> None:
            self.pieces.append(work)
            raise InputError("row 3 has a gap")

        yield Round(Priority.MOTION, [Call(fault)])

    def _broken(self, work: str, wanted_at: float) -> Steps:
        """A fault between two pieces."""
        yield Round(Priority.MOTION, [self.piece(work)])
        raise ZeroDivisionError("one\nby nought")

    def _late(self, work: str, wanted_at: float) -> Steps:
        """Fails before there is any piece."""
        raise InputError("no such thing")
        yield  # a generator all the same

    def _failing_landscape(self, work: str, wanted_at: float) -> Steps:
        """Fails in the second round of what is to be finished."""
        yield Round(Priority.COARSE, [self.piece(work)], finish=True)
        yield Round(Priority.COARSE, [self.piece(work)], finish=True)
        raise InputError("no")

    def _together(self, work: str, wanted_at: float) -> Steps:
        """A piece that is done in one call with up to three of its kind."""
        yield Round(Priority.MOTION, [Together(self.pieces, work)])
        yield stage(work, done=True)


class Together(Task):
    def __init__(self, pieces: list[str], name: str) -> None:
        super().__init__(iter(()))
        self._pieces, self._name = pieces, name

    def joins(self, batch: Sequence[Task]) -> bool:
        return len(batch) < 3 and all(isinstance(one, Together) for one in batch)

    def step(self, riders: Sequence[Task] = ()) -> bool:
        names = [one._name for one in (self, *riders) if isinstance(one, Together)]
        if any("faulty" in name for name in names):
            raise ZeroDivisionError("by nought")
        self._pieces.append(" + ".join(name.removeprefix("together ") for name in names))
        return True


def stage(value: str, *, done: bool = False) -> Stage:
    return Stage(ExportedFile(value, "", ""), done)


class ShopPage:
    """What a page was told: (slot, value) of a stage, with "!" at the end of the last one."""

    def __init__(self, crew: Crew) -> None:
        self.told: list[tuple[str, str]] = []
        self._handle: Page = crew.open(self._take)

    def want(self, **works: str) -> None:
        """Works by slot."""
        self._handle.want(works)  # type: ignore[arg-type]

    def close(self) -> None:
        self._handle.close()

    def _take(self, delivery: Delivery) -> None:
        slot: Any = delivery.slot
        match delivery:
            case Delivered(result=ExportedFile(value), done=done):
                self.told.append((slot, value + "!" * done))
            case Failed(message=message):
                self.told.append((slot, f"failed: {message}"))
