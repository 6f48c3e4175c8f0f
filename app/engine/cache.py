"""Results that may be wanted again, by work; those wanted longest ago go first."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace
from typing import assert_never

import numpy as np

from ..state.results import (
    BeliefResult,
    CodebookResult,
    ExportedFile,
    LandscapeResult,
    MotionResult,
    RecognitionTrace,
    Result,
    StretchResult,
    WaysResult,
)
from ..state.work import BeliefWork, LandscapeWork, MotionWork, RecogniseWork, Work

MAX_BYTES = 64_000_000
EACH = 2_000  # of a result, besides its arrays
NUMBER = 32  # of a Python number in a tuple


class Cache:
    """At most so many bytes of results.

    Of a recognition the longest run so far is kept: its first iterations are every shorter run.
    """

    def __init__(self, max_bytes: int = MAX_BYTES) -> None:
        self._max_bytes = max_bytes
        self._results: OrderedDict[Work, Result] = OrderedDict()
        self.bytes = 0

    def get(self, work: Work) -> Result | None:
        """What the work comes to, all of it; None where that is not known."""
        key = _key(work)
        result = self._results.get(key)
        if isinstance(work, RecogniseWork) and isinstance(result, RecognitionTrace):
            if not work.is_met_by(result):
                return None
            result = result if work.iterations is None else result.first(work.iterations)
        if result is not None:
            self._results.move_to_end(key)
        return result

    def put(self, work: Work, result: Result) -> None:
        """Keep a result that is done, or a recognition as far as it has come."""
        key = _key(work)
        known = self._results.pop(key, None)
        if known is not None:
            self.bytes -= _size(key, known)
            result = _longer(known, result)
        self._results[key] = result
        self.bytes += _size(key, result)
        while self.bytes > self._max_bytes:
            self.bytes -= _size(*self._results.popitem(last=False))


def _key(work: Work) -> Work:
    return replace(work, iterations=0) if isinstance(work, RecogniseWork) else work


def _longer(known: Result, result: Result) -> Result:
    if isinstance(known, RecognitionTrace) and isinstance(result, RecognitionTrace):
        return known if known.iterations > result.iterations else result
    return result


def _size(work: Work, result: Result) -> int:
    """Bytes, those of the motion that the work holds included."""
    held = 0
    if isinstance(work, LandscapeWork | RecogniseWork | BeliefWork) and work.target is not None:
        held = len(work.target.positions) + len(work.target.eyes)
    if isinstance(work, MotionWork):
        held += NUMBER * sum(map(len, work.along))
    match result:
        case MotionResult(positions, check):
            held += positions.nbytes
            if check is not None and check.limited is not None:
                held += check.limited.nbytes
        case LandscapeResult(values):
            held += values.correlation.nbytes
        case RecognitionTrace():
            fields = (getattr(result, name) for name in result.__dataclass_fields__)
            arrays = [field for field in fields if isinstance(field, np.ndarray)]
            if result.posterior is not None:
                arrays += [result.posterior.covariance, result.posterior.deviation]
            # Views of the whole run's arrays, which they keep.
            held += sum(one.nbytes if one.base is None else one.base.nbytes for one in arrays)
        case BeliefResult(cloud, motions):
            held += cloud.pbs.nbytes + cloud.weights.nbytes + sum(one.nbytes for one in motions)
        case WaysResult(straight, shortest):
            held += sum(one.pbs.nbytes + one.steps.nbytes for one in (straight, shortest))
        case CodebookResult() | StretchResult():
            pass
        case ExportedFile(_, content, _):
            held += len(content)
        case _:
            assert_never(result)
    return held + EACH
