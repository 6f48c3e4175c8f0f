"""The lane: one thread, the newest work of each kind, nothing lost without a word."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from queue import Empty, Queue

import pytest

from rnnpb_explorer.app.engine.worker import Lane
from rnnpb_explorer.core.errors import Cancelled, InputError

TIMEOUT = 20.0  # seconds until a test that hangs has failed; nothing waits for it otherwise


class Workshop:
    """A lane whose work says when it begins and goes on when it is told to.

    Work is a name. One that begins with `held` waits for `go_on`; what it posts ends in `cancelled`
    if it was told to stop by then.
    """

    def __init__(self) -> None:
        self.begun: Queue[str] = Queue()
        self.posted: Queue[str] = Queue()
        self.go_on = threading.Semaphore(0)
        self.lane: Lane[str, str] = Lane("test", self._compute, self.posted.put, self._failed)

    def _compute(self, work: str, cancelled: threading.Event) -> Iterator[str]:
        self.begun.put(work)
        yield f"{work} begins"
        if work.startswith("held"):
            assert self.go_on.acquire(timeout=TIMEOUT)
        if work.startswith("stoppable"):
            assert cancelled.wait(TIMEOUT)
            raise Cancelled
        if work.startswith("wrong"):
            raise InputError("row 3 has a gap")
        if work.startswith("broken"):
            raise ZeroDivisionError("one by nought")
        yield f"{work} {'cancelled' if cancelled.is_set() else 'done'}"

    @staticmethod
    def _failed(work: str, message: str) -> str:
        return f"{work} failed: {message}"

    def hold(self, name: str = "held", key: str | None = None) -> None:
        """Have the lane busy with work that waits for `go_on`."""
        self.lane.submit(name, key)
        assert self.begun.get(timeout=TIMEOUT) == name

    def results(self, count: int) -> list[str]:
        return [self.posted.get(timeout=TIMEOUT) for _ in range(count)]

    def nothing_more(self) -> bool:
        """Whether nothing else was posted, once the lane has ended."""
        self.end()
        try:
            self.posted.get_nowait()
        except Empty:
            return True
        return False

    def end(self) -> None:
        self.lane.close()
        self.lane.join(TIMEOUT)

    @property
    def thread(self) -> threading.Thread:
        return self.lane._thread


@pytest.fixture
def workshop() -> Iterator[Workshop]:
    made = Workshop()
    yield made
    made.go_on.release(100)
    made.end()
    assert not made.thread.is_alive()


def test_everything_that_a_computation_yields_is_posted_in_order(workshop: Workshop) -> None:
    workshop.lane.submit("a")
    assert workshop.results(2) == ["a begins", "a done"]


def test_it_runs_on_a_thread_of_its_own(workshop: Workshop) -> None:
    assert workshop.thread is not threading.current_thread()
    assert workshop.thread.daemon
    workshop.hold()  # returns while the work goes on


def test_of_what_waits_only_the_latest_is_done(workshop: Workshop) -> None:
    workshop.hold()
    for name in ("old", "newer", "newest"):
        workshop.lane.submit(name)
    workshop.go_on.release()
    assert workshop.results(4)[2:] == ["newest begins", "newest done"]
    assert workshop.nothing_more()


def test_every_key_has_its_latest(workshop: Workshop) -> None:
    workshop.hold(key="first")
    workshop.lane.submit("a1", "a")
    workshop.lane.submit("b1", "b")
    workshop.lane.submit("a2", "a")
    workshop.go_on.release()
    workshop.results(2)
    assert workshop.results(4) == ["a2 begins", "a2 done", "b1 begins", "b1 done"]
    assert workshop.nothing_more()


def test_a_busy_key_does_not_starve_another(workshop: Workshop) -> None:
    workshop.hold("held 1", "busy")
    workshop.lane.submit("patient", "patient")
    workshop.lane.submit("held 2", "busy")
    workshop.go_on.release(2)
    begun = [workshop.begun.get(timeout=TIMEOUT) for _ in range(2)]
    assert begun == ["patient", "held 2"]


def test_newer_work_tells_the_older_to_stop(workshop: Workshop) -> None:
    workshop.hold("held old", "a")
    workshop.lane.submit("new", "a")
    workshop.go_on.release()
    assert workshop.results(4) == [
        *("held old begins", "held old cancelled"),
        *("new begins", "new done"),
    ]


def test_newer_work_of_another_key_leaves_it_alone(workshop: Workshop) -> None:
    workshop.hold("held", "a")
    workshop.lane.submit("new", "b")
    workshop.go_on.release()
    assert workshop.results(2) == ["held begins", "held done"]


def test_work_that_stops_posts_nothing_and_the_lane_goes_on(workshop: Workshop) -> None:
    workshop.lane.submit("stoppable")
    assert workshop.begun.get(timeout=TIMEOUT) == "stoppable"
    workshop.lane.submit("next")
    assert workshop.results(3) == ["stoppable begins", "next begins", "next done"]
    assert workshop.nothing_more()


def test_cancelling_stops_what_runs_and_drops_what_waits(workshop: Workshop) -> None:
    workshop.hold()
    workshop.lane.submit("waiting", "other")
    workshop.lane.cancel()
    workshop.lane.submit("after")
    workshop.go_on.release()
    assert workshop.results(4) == ["held begins", "held cancelled", "after begins", "after done"]
    assert workshop.nothing_more()


def test_cancelling_an_idle_lane_is_nothing(workshop: Workshop) -> None:
    workshop.lane.cancel()
    workshop.lane.submit("a")
    assert workshop.results(2) == ["a begins", "a done"]


def test_the_cancellation_of_one_work_is_not_the_next_ones(workshop: Workshop) -> None:
    workshop.hold("held 1")
    workshop.lane.cancel()
    workshop.lane.submit("held 2")
    workshop.go_on.release(2)
    assert workshop.results(4)[2:] == ["held 2 begins", "held 2 done"]


def test_bad_input_becomes_a_result_in_its_own_words(workshop: Workshop) -> None:
    workshop.lane.submit("wrong")
    workshop.lane.submit("next", "other")
    assert workshop.results(4) == [
        *("wrong begins", "wrong failed: row 3 has a gap"),
        *("next begins", "next done"),
    ]


def test_any_other_failure_becomes_a_result_and_is_logged(
    workshop: Workshop, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.ERROR):
        workshop.lane.submit("broken")
        workshop.lane.submit("next", "other")
        results = workshop.results(4)
    assert results[0] == "broken begins"
    assert results[1].startswith("broken failed: ")
    assert "one by nought" in results[1]
    assert results[2:] == ["next begins", "next done"]
    assert "ZeroDivisionError" in caplog.text


def test_closing_ends_the_thread(workshop: Workshop) -> None:
    workshop.end()
    assert not workshop.thread.is_alive()
    workshop.end()  # twice is once


def test_closing_does_not_wait(workshop: Workshop) -> None:
    workshop.hold()
    workshop.lane.close()
    assert workshop.thread.is_alive()
    workshop.go_on.release()
    assert workshop.results(2) == ["held begins", "held cancelled"]


def test_closing_stops_what_runs_and_never_begins_what_waits(workshop: Workshop) -> None:
    workshop.lane.submit("stoppable")
    assert workshop.begun.get(timeout=TIMEOUT) == "stoppable"
    workshop.lane.submit("waiting", "other")
    workshop.end()
    assert not workshop.thread.is_alive()
    assert workshop.begun.empty()
    assert workshop.results(1) == ["stoppable begins"]


def test_a_closed_lane_does_no_work(workshop: Workshop) -> None:
    workshop.end()
    workshop.lane.submit("late")
    assert workshop.begun.empty()
    assert workshop.nothing_more()
