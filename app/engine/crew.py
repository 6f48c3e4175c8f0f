"""The threads that do the work of all pages, and the lock that they share with the pages."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Mapping

import torch

from ...core.errors import InputError
from ..state.work import Slot, Work
from .cache import Cache
from .deliveries import Delivery
from .job import Stage, Steps, Task
from .schedule import Batch, Client, Job, Progress, Schedule

log = logging.getLogger(__name__)


class Crew:
    """
    Args:
        begin: the steps of a work that is wanted since a time.
        workers: threads; none for a caller that does all by `run_one`.
    """

    def __init__(
        self,
        begin: Callable[[Work, float], Steps],
        workers: int,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self._schedule = Schedule(begin, _advance, Cache())
        self._changed = threading.Condition()
        self._closed = False
        self._threads = [
            threading.Thread(target=self._run, name=f"engine {number}", daemon=True)
            for number in range(workers)
        ]
        for thread in self._threads:
            thread.start()

    def open(self, deliver: Callable[[Delivery], None]) -> Page:
        """A page whose works are to be done.

        Args:
            deliver: called on a worker's thread, one delivery after the other; it may only queue.
        """
        return Page(self, Client(deliver))

    def close(self, timeout: float) -> None:
        """End all threads at their next piece; wait for that, at most `timeout` seconds."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        deadline = time.monotonic() + timeout
        for thread in self._threads:
            thread.join(max(deadline - time.monotonic(), 0.0))

    def want(self, client: Client, works: Mapping[Slot, Work]) -> None:
        with self._changed:
            if not self._closed:
                self._schedule.want(client, works, self._clock())
                self._changed.notify()

    def drop(self, client: Client) -> None:
        with self._changed:
            self._schedule.drop(client)

    def run_one(self) -> bool:
        """Do the next piece, and tell pages what there is to tell; whether there was anything."""
        told = self._tell()
        with self._changed:
            batch = [] if self._closed else self._schedule.take(self._clock())
            if batch:
                self._changed.notify()  # whoever finds work wakes one more: there may be more
        if batch:
            self._do(batch)
            self._tell()
        return told or bool(batch)

    def _run(self) -> None:
        # As measured with torch 2.13 for the processor (OpenMP): a count holds for the thread that
        # sets it, and for those that first compute later, which take the one set last; asking for
        # it counts as computing. So it is asked for first: nobody's later setting changes it here
        # then. The main thread keeps its own. Without it each worker computes on all cores, and
        # they wait for each other.
        torch.get_num_threads()
        torch.set_num_threads(1)
        while not self._closed:
            try:
                if not self.run_one():
                    self._wait()
            except Exception:  # the thread's boundary: no page may take a worker from the others
                log.exception("a worker met a fault")

    def _wait(self) -> None:
        with self._changed:
            now = self._clock()
            if not (self._closed or self._schedule.busy(now)):
                then = self._schedule.next_time(now)
                self._changed.wait(None if then is None else then - now)

    def _do(self, batch: Batch) -> None:
        """A piece, done for all of a batch, and what the jobs go on to."""
        (job, task), *riders = batch
        try:
            finished = task.step([rider for _, rider in riders])
        except Exception as error:  # the work's boundary: nothing may vanish unseen
            if riders:  # it is the fault of one of them
                for one in batch:
                    self._do([one])
                return
            fault = _fault(job, error)
            with self._changed:
                self._schedule.fail(job, fault, self._clock())
            return
        for job, task in batch:
            self._stepped(job, task, finished)

    def _stepped(self, job: Job, task: Task, finished: bool) -> None:
        with self._changed:
            goes_on = self._schedule.stepped(job, task, finished=finished)
        if goes_on:
            progress = _advance(job)
            with self._changed:
                self._schedule.progress(job, progress, self._clock())

    def _tell(self) -> bool:
        """Hand out what pages have not been told, without the lock: they may have locks, too."""
        told = False
        while True:
            with self._changed:
                mail = self._schedule.mail()
            if mail is None:
                return told
            client, deliveries = mail
            for delivery in deliveries:
                try:
                    client.deliver(delivery)
                except Exception:  # the page's boundary
                    log.exception("a page did not take what came for it")
            with self._changed:
                self._schedule.told(client)
            told = True


class Page:
    """One browser's works; used from one thread."""

    def __init__(self, crew: Crew, client: Client) -> None:
        self._crew, self._client = crew, client
        self._wanted: dict[Slot, Work] = {}
        self._closed = False

    def want(self, works: Mapping[Slot, Work]) -> None:
        """All that this page wants from now on; what it no longer wants is cancelled.

        Newer work of a slot takes the place of the older. What has failed is not tried again as
        long as it stays wanted.
        """
        if not self._closed and works != self._wanted:
            self._wanted = dict(works)
            self._crew.want(self._client, self._wanted)

    def close(self) -> None:
        """Nothing is wanted any more."""
        self._closed = True
        self._wanted = {}
        self._crew.drop(self._client)


def _advance(job: Job) -> Progress:
    stages: list[Stage] = []
    try:
        for step in job.steps:
            if isinstance(step, Stage):
                stages.append(step)
            elif step.tasks:
                return Progress(stages, step)
    except Exception as error:  # the work's boundary: nothing may vanish unseen
        return Progress(stages, fault=_fault(job, error))
    return Progress(stages)


def _fault(job: Job, error: Exception) -> str:
    """One line on what went wrong; what no person can mend is logged, too."""
    if isinstance(error, InputError):
        return str(error)
    name = type(job.work).__name__
    log.error("%s failed", name, exc_info=error)
    return f"{name} failed: {' '.join(str(error).split())}"
