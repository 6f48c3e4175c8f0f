"""The threads of the engine: they work at the same time, survive faults, and end when told to."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from queue import SimpleQueue

import pytest
import torch

from rnnpb_explorer.app.engine.crew import Crew
from rnnpb_explorer.app.engine.deliveries import Delivered, Delivery
from rnnpb_explorer.app.engine.job import Call, Priority, Round, Steps

from .engine_shop import stage

TIMEOUT = 20.0  # seconds until a test that hangs has failed; nothing waits for it otherwise


class Hall:
    """Two workers whose pieces say that they begin, and go on when they are told to."""

    def __init__(self) -> None:
        self.begun: SimpleQueue[str] = SimpleQueue()
        self.told: SimpleQueue[Delivery] = SimpleQueue()
        self.go_on = threading.Semaphore(0)
        self.ran_on: list[threading.Thread] = []
        self.torch_threads: list[int] = []
        self.crew = Crew(self._begin, 2)  # type: ignore[arg-type]
        self.page = self.crew.open(self.told.put)

    def want(self, *works: str) -> None:
        self.page.want({work: work for work in works})  # type: ignore[misc]

    def next_told(self) -> str:
        delivery = self.told.get(timeout=TIMEOUT)
        return delivery.result.file_name if isinstance(delivery, Delivered) else delivery.message

    def _begin(self, work: str, wanted_at: float) -> Steps:
        rest = wanted_at + 0.01 if work == "rested" else 0.0
        pieces = [Call(lambda: self._piece(work)) for _ in range(2 if work == "both" else 1)]
        yield Round(Priority.MOTION, pieces, not_before=rest)
        if work == "more":
            yield stage("begun")
            yield Round(Priority.MOTION, [Call(lambda: self._piece(work))])
        yield stage(work, done=True)

    def _piece(self, work: str) -> None:
        self.ran_on.append(threading.current_thread())
        self.torch_threads.append(torch.get_num_threads())
        self.begun.put(work)
        if work == "broken":
            raise ZeroDivisionError("one by nought")
        if work in ("held", "both", "more"):
            assert self.go_on.acquire(timeout=TIMEOUT)

    @property
    def threads(self) -> list[threading.Thread]:
        return self.crew._threads


@pytest.fixture
def hall() -> Iterator[Hall]:
    made = Hall()
    yield made
    made.go_on.release(100)
    made.crew.close(TIMEOUT)
    assert not any(thread.is_alive() for thread in made.threads)


def test_work_is_done_on_the_workers_threads(hall: Hall) -> None:
    hall.want("a")
    assert hall.next_told() == "a"
    assert hall.ran_on[0] in hall.threads
    assert all(thread.daemon for thread in hall.threads)


def test_each_worker_computes_on_one_thread_and_others_keep_theirs(hall: Hall) -> None:
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        hall.want("both")
        for _ in range(2):
            assert hall.begun.get(timeout=TIMEOUT) == "both"
        assert hall.torch_threads == [1, 1]
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(before)


def test_the_pieces_of_a_work_are_done_at_the_same_time(hall: Hall) -> None:
    hall.want("both")
    for _ in range(2):  # neither waits for the other
        assert hall.begun.get(timeout=TIMEOUT) == "both"
    assert set(hall.ran_on) == set(hall.threads)
    assert hall.told.empty()
    hall.go_on.release(2)
    assert hall.next_told() == "both"


def test_work_whose_time_comes_is_done_without_another_word(hall: Hall) -> None:
    hall.want("rested")
    assert hall.next_told() == "rested"


def test_work_that_comes_while_all_rest_wakes_a_worker(hall: Hall) -> None:
    for name in ("a", "b", "c"):
        hall.want(name)
        assert hall.next_told() == name


def test_a_known_result_is_told_on_a_workers_thread(hall: Hall) -> None:
    hall.want("a")
    hall.next_told()
    told_on: SimpleQueue[threading.Thread] = SimpleQueue()
    other = hall.crew.open(lambda _: told_on.put(threading.current_thread()))
    other.want({"x": "a"})  # type: ignore[dict-item]
    assert told_on.get(timeout=TIMEOUT) in hall.threads
    assert len(hall.ran_on) == 1


def test_no_fault_ends_a_worker(hall: Hall, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        for _ in range(4):  # more than there are workers
            hall.want("broken")
            assert hall.next_told() == "str failed: one by nought"
            hall.want()
    hall.want("a")
    assert hall.next_told() == "a"
    assert all(thread.is_alive() for thread in hall.threads)


def test_not_even_one_of_the_engine_itself(
    hall: Hall, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def no_rank(job: object) -> int:
        monkeypatch.undo()
        raise ZeroDivisionError("no rank")

    monkeypatch.setattr(hall.crew._schedule, "_rank", no_rank)
    with caplog.at_level(logging.ERROR):
        hall.want("a", "b")
        assert {hall.next_told(), hall.next_told()} == {"a", "b"}
    assert "no rank" in caplog.text


def test_closing_ends_all_threads(hall: Hall) -> None:
    hall.crew.close(TIMEOUT)
    assert not any(thread.is_alive() for thread in hall.threads)
    hall.crew.close(TIMEOUT)  # twice is once


def test_closing_ends_work_at_its_next_piece_and_never_begins_what_waits(hall: Hall) -> None:
    hall.want("held", "more", "waiting")
    begun = {hall.begun.get(timeout=TIMEOUT) for _ in range(2)}
    assert begun == {"held", "more"}
    hall.crew.close(0.0)  # does not wait for longer than it may
    assert all(thread.is_alive() for thread in hall.threads)
    hall.go_on.release(2)
    hall.crew.close(TIMEOUT)
    assert not any(thread.is_alive() for thread in hall.threads)
    assert hall.begun.empty()


def test_a_closed_engine_does_no_work(hall: Hall) -> None:
    hall.crew.close(TIMEOUT)
    hall.want("late")
    assert not hall.crew.run_one()
    assert hall.begun.empty()
