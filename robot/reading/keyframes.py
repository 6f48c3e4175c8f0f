"""Key frames as a motion: joint by joint, straight or along Bezier curves, at an even rate."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import InputError
from ...core.motion import MAX_FRAMES

Array = NDArray[np.float64]
STEPS = 64  # of a Bezier curve, whose times are not even


@dataclass(frozen=True)
class Key:
    """A value that a joint has at a time (seconds).

    before, after: handles of the curves that end and begin here, relative to the key, as seconds
    and value; None for a straight line.
    """

    time: float
    value: float
    before: tuple[float, float] | None = None
    after: tuple[float, float] | None = None


def played(
    curves: Mapping[str, Sequence[Key]], fps: float, source: str
) -> tuple[tuple[str, ...], Array]:
    """Names (J,) and values (T, J) of all joints from the first key of any to the last.

    Before its first key and after its last a joint rests.

    Raises:
        InputError: no keys, times that do not grow, or more frames than a motion has.
    """
    if not curves or any(not keys for keys in curves.values()):
        raise InputError(f"{source} has a joint without key frames")
    for name, keys in curves.items():
        times = [key.time for key in keys]
        numbers = [x for key in keys for x in (key.time, key.value)]
        if not np.isfinite(numbers).all():
            raise InputError(f"{source}, {name}: a key frame is not finite")
        late = next((i for i, (a, b) in enumerate(itertools.pairwise(times)) if b <= a), None)
        if late is not None:
            raise InputError(
                f"{source}, {name}: key {late + 2} at {times[late + 1]:g} s is not after the one "
                f"before, at {times[late]:g} s"
            )
    first = min(keys[0].time for keys in curves.values())
    last = max(keys[-1].time for keys in curves.values())
    frames = int(np.floor((last - first) * fps + 1e-6)) + 1
    if frames > MAX_FRAMES:
        raise InputError(f"{source} lasts {last - first:g} s; a motion has at most {MAX_FRAMES}")
    at = first + np.arange(frames) / fps
    return tuple(curves), np.column_stack([_values(keys, at) for keys in curves.values()])


def _values(keys: Sequence[Key], at: Array) -> Array:
    """(T,) one joint's values."""
    times, values = [keys[0].time], [keys[0].value]
    for start, end in itertools.pairwise(keys):
        if start.after is not None or end.before is not None:
            curve = _bezier(start, end)
            times += curve[1:-1, 0].tolist()
            values += curve[1:-1, 1].tolist()
        times.append(end.time)
        values.append(end.value)
    return np.interp(at, times, values)


def _bezier(start: Key, end: Key) -> Array:
    """(STEPS + 1, 2) points of a cubic from key to key, evenly spread in its parameter."""
    from scipy.interpolate import BPoly  # a tenth of a second, for files that have curves

    after, before = start.after or (0.0, 0.0), end.before or (0.0, 0.0)
    points = np.array(
        [
            (start.time, start.value),
            # A handle that reaches beyond the other key would have time run backwards.
            (min(start.time + after[0], end.time), start.value + after[1]),
            (max(end.time + before[0], start.time), end.value + before[1]),
            (end.time, end.value),
        ]
    )
    curve: Array = BPoly(points[:, None, :], [0.0, 1.0])(np.linspace(0, 1, STEPS + 1))
    return curve
