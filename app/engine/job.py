"""How work is cut: a job goes in rounds, a round has tasks, a task is done piece by piece.

A kind of work is one generator function: it yields the round that it needs next and is resumed when
all of the round's tasks are done, and it yields the stages of its result in between. What it does
between two yields has to be short; whatever takes more than a millisecond belongs into a task.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Generic, TypeVar

from ..state.results import Result

ValueT = TypeVar("ValueT")


class Priority(IntEnum):
    """What pages wait for most goes first."""

    MOTION = 0
    CHECK = 1
    EXPORT = 2
    LIVE = 3  # a frame of a motion that arrives
    COARSE = 4  # landscapes, as long as they are coarse
    RECOGNITION = 5
    SMOOTHNESS = 6
    COMPLETE = 7  # landscapes, the rest of them
    CODEBOOK = 8


class Task:
    """Something for one worker at a time, in pieces of about 25 ms at most."""

    def __init__(self, pieces: Iterator[object]) -> None:
        """
        Args:
            pieces: each `next` is a piece.
        """
        self._pieces = pieces

    def joins(self, batch: Sequence[Task]) -> bool:
        """Whether the next piece can be done together with that of these, in one call."""
        return False

    def step(self, riders: Sequence[Task] = ()) -> bool:
        """Do a piece, and that of the riders; whether that was the last."""
        for _ in self._pieces:
            return False
        return True


class Call(Task, Generic[ValueT]):
    """One function call, whose value is there when the round is over."""

    def __init__(self, function: Callable[[], ValueT]) -> None:
        self._function = function
        self.value: ValueT

    def step(self, riders: Sequence[Task] = ()) -> bool:
        self.value = self._function()
        return True


class Last(Task):
    """The last of some pieces."""

    def __init__(self, pieces: Iterator[object]) -> None:
        self.result: object = None
        super().__init__(self._through(pieces))

    def _through(self, pieces: Iterator[object]) -> Iterator[None]:
        while True:
            piece = next(pieces, self)
            if piece is self:
                return
            self.result = piece
            yield


@dataclass(frozen=True)
class Round:
    """Tasks that several workers can do at the same time.

    not_before: on the engine's clock.
    finish: once one of its pieces has begun, the job goes on to its next stage even when newer work
        of the page waits: a hand that never rests would see nothing otherwise.
    """

    priority: Priority
    tasks: Sequence[Task]
    not_before: float = 0.0
    finish: bool = False


@dataclass(frozen=True)
class Stage:
    """A result; unless done, one that holds more will follow."""

    result: Result
    done: bool


Steps = Iterator[Round | Stage]
