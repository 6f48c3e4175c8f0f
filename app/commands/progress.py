"""Progress: on stderr, and only where that is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

Step = TypeVar("Step")


def progress_bar(text: str = "") -> Progress:
    """A bar with a count and the time left; `text` is a format of the task's own fields."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        *([TextColumn(text)] if text else []),
        TimeRemainingColumn(compact=True, elapsed_when_finished=True),
        console=Console(stderr=True),
        disable=not sys.stderr.isatty(),
        transient=True,
    )


def steps_bar(steps: Iterable[Step], total: int, description: str) -> Iterator[Step]:
    """The steps themselves, counted on the bar as they go by."""
    with progress_bar() as progress:
        yield from progress.track(steps, total=total, description=description)


@contextmanager
def working(what: str) -> Iterator[None]:
    """Say what is being waited for; the line is gone when it is there."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    with console.status(what):
        yield
