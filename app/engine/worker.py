"""Long computations off the session's thread: latest wins, cancellable, never lost in silence.

A lane does one thing at a time. Work handed to a busy lane waits; newer work of the same key takes
its place, and the one under way is told to stop where it is willing to. Everything that a
computation yields is posted; its failure is posted, too.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Hashable, Iterator
from typing import Generic, TypeVar

from ...core.errors import Cancelled, InputError

WorkT = TypeVar("WorkT")
ResultT = TypeVar("ResultT")
log = logging.getLogger(__name__)


class Lane(Generic[WorkT, ResultT]):
    """One thread for one kind of work.

    Args:
        compute: yields results; its second argument is set when newer work waits, or at the end. It
            returns or raises `Cancelled` at the next convenient place then.
        post: takes results; called on the lane's thread.
        failed: makes a result of a computation that broke off, from the work and a line of text.
    """

    def __init__(
        self,
        name: str,
        compute: Callable[[WorkT, threading.Event], Iterator[ResultT]],
        post: Callable[[ResultT], None],
        failed: Callable[[WorkT, str], ResultT],
    ) -> None:
        self._compute, self._post, self._failed = compute, post, failed
        self._changed = threading.Condition()
        self._waiting: dict[Hashable, WorkT] = {}  # in the order in which the keys came
        self._running: tuple[Hashable, threading.Event] | None = None
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, work: WorkT, key: Hashable = None) -> None:
        """Have work done; it replaces older work of the same key."""
        with self._changed:
            self._waiting[key] = work
            if self._running is not None and self._running[0] == key:
                self._running[1].set()
            self._changed.notify_all()

    def cancel(self) -> None:
        """Drop what waits and stop what runs."""
        with self._changed:
            self._waiting.clear()
            if self._running is not None:
                self._running[1].set()

    def close(self) -> None:
        """Cancel, and have the thread end; `join` waits for that."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self.cancel()

    def join(self, timeout: float) -> None:
        """Wait until the thread has ended, at most `timeout` seconds."""
        self._thread.join(timeout)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._closed)
                if self._closed:
                    return
                key = next(iter(self._waiting))
                work = self._waiting.pop(key)
                cancelled = threading.Event()
                self._running = (key, cancelled)
            self._work_on(work, cancelled)
            with self._changed:
                self._running = None

    def _work_on(self, work: WorkT, cancelled: threading.Event) -> None:
        try:
            for result in self._compute(work, cancelled):
                self._post(result)
        except Cancelled:
            return
        except InputError as error:
            self._post(self._failed(work, str(error)))
        except Exception as error:  # the worker's boundary: nothing may vanish unseen
            log.exception("%s failed", type(work).__name__)
            self._post(self._failed(work, f"{type(work).__name__} failed: {error}"))
