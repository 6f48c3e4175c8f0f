"""What a page is told of its works."""

from __future__ import annotations

from dataclasses import dataclass

from ..state.results import Result
from ..state.work import Slot, Work


@dataclass(frozen=True)
class Delivered:
    """A stage of a result; the last one is done.

    The first stage of a motion or a landscape may come although newer work of the slot is wanted.
    """

    slot: Slot
    work: Work
    result: Result
    done: bool


@dataclass(frozen=True)
class Failed:
    """A work will not be done; it is tried again when it is wanted anew."""

    slot: Slot
    work: Work
    message: str  # one line


Delivery = Delivered | Failed
