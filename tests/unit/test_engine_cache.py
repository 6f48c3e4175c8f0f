"""Results that are kept: how many, how long, and that a run has its shorter runs in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rnnpb_explorer.app.engine.cache import EACH, Cache
from rnnpb_explorer.app.state.document import Target
from rnnpb_explorer.app.state.results import CheckedMotion, MotionResult, RecognitionTrace
from rnnpb_explorer.app.state.work import MotionWork, RecogniseWork
from rnnpb_explorer.robot.safety_report import SafetyReport

TARGET = Target("t", ("a", "b"), 25.0, np.zeros((10, 2), "<f4").tobytes())
RUN = RecogniseWork("one", TARGET, "paper", 0.8, (), 0.0, "learned", 20, 2, 0)


def motion(frames: int, limited: bool = False) -> MotionResult:
    positions = np.zeros((frames, 5), np.float32)
    report = SafetyReport((), ())
    return MotionResult(positions, CheckedMotion(report, positions.copy() if limited else None))


def trace(iterations: int) -> RecognitionTrace:
    """A view of a run of 20 iterations."""
    whole = np.zeros((21, 2, 3))
    flat = np.zeros((20, 2))
    return RecognitionTrace(
        whole[: iterations + 1],
        whole[: iterations + 1],
        whole[:iterations],
        flat[:iterations],
        flat[:iterations],
        flat[:iterations],
        np.zeros((20, 2), bool)[:iterations],
    )


def work(number: int) -> MotionWork:
    return MotionWork("one", (float(number),), 100)


def test_equal_works_have_the_same_result() -> None:
    cache, result = Cache(), motion(100)
    cache.put(work(1), result)
    assert cache.get(work(1)) is result
    assert cache.get(work(2)) is None
    assert cache.get(replace(work(1), check="report")) is None


def test_what_was_wanted_longest_ago_goes_first() -> None:
    size = 100 * 5 * 4 + EACH
    cache = Cache(3 * size)
    for number in range(3):
        cache.put(work(number), motion(100))
    cache.get(work(0))
    cache.put(work(3), motion(100))
    assert [cache.get(work(number)) is not None for number in range(4)] == [True, False, True, True]
    assert cache.bytes == 3 * size


def test_limited_motions_and_targets_count() -> None:
    cache = Cache()
    cache.put(work(0), motion(100, limited=True))
    assert cache.bytes == 2 * 100 * 5 * 4 + EACH
    cache.put(RUN, trace(3))  # the whole run's arrays, which its views keep
    whole = (21 * 6 * 3 + 20 * 2 * 3) * 8 + 20 * 2
    assert cache.bytes == 2 * 100 * 5 * 4 + EACH + whole + 80 + EACH


def test_a_result_too_large_is_not_kept_and_the_same_twice_counts_once() -> None:
    cache = Cache(10_000)
    cache.put(work(1), motion(100))
    cache.put(work(1), motion(100))
    assert cache.bytes == 100 * 5 * 4 + EACH
    cache.put(work(2), motion(1_000))
    assert cache.get(work(2)) is None
    assert cache.bytes <= 10_000


def test_a_shorter_run_is_the_beginning_of_a_longer_one() -> None:
    cache = Cache()
    cache.put(RUN, trace(12))
    short = cache.get(replace(RUN, iterations=7))
    assert isinstance(short, RecognitionTrace)
    assert short.iterations == 7
    assert short.mu.shape == (8, 2, 3)
    assert cache.get(replace(RUN, iterations=13)) is None
    assert cache.get(replace(RUN, iterations=7, seed=1)) is None


def test_the_longer_run_stays() -> None:
    cache = Cache()
    cache.put(RUN, trace(12))
    cache.put(replace(RUN, iterations=5), trace(5))
    assert cache.get(replace(RUN, iterations=12)) is not None
    cache.put(RUN, trace(20))
    assert cache.get(RUN) is not None
