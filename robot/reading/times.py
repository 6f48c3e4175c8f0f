"""When the frames of a file are: its rate, from stamps or from what it says, and another rate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.errors import InputError
from ...core.motion import MAX_FRAMES
from .columns import Column, named_for
from .layout import Rows
from .raw import Array, Raw

RATES = (1.5, 2000.0)  # frames a second that a recording of a robot can have
_SCALES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
JITTER = 0.1  # of a step; more is not what a clock does, and is said
GAP = 3.0  # steps without a frame that are named
SAME = 1e-4  # by which two rates may differ and still be one


@dataclass(frozen=True, eq=False)
class Clock:
    """When frames are.

    fps: frames a second. source: where that is known from. times: (T,) seconds from 0, where the
    file has stamps.
    """

    fps: float
    source: str
    times: Array | None = None
    remarks: tuple[str, ...] = ()


def clocks(
    raw: Raw, free: Sequence[Column], said: float | None, otherwise: float
) -> tuple[Callable[[Rows], Clock], set[int]]:
    """How to find the clock of some rows, and the columns that it is read from.

    Args:
        free: columns that move no joint.
        said: frames a second that somebody says; it counts before all else.
        otherwise: frames a second of a file that does not say.
    """
    if raw.time is not None and said is None:
        times = raw.time
        return lambda rows: stamped(times[rows], f"{raw.source}, its time"), set()
    if raw.fps is not None:  # of key frames it is the one that was said
        known = Clock(raw.fps, "in the file")
        return lambda rows: known, set()
    column, values = _stamps(raw, free)
    used = set() if column is None else {column.index}
    if said is not None or column is None:
        plain = Clock(otherwise, "assumed") if said is None else Clock(said, "said")
        return lambda rows: plain, used
    where = f"{raw.source}, column {column.name or column.index + 1}"
    return lambda rows: stamped(values[rows], where), used


def _stamps(raw: Raw, free: Sequence[Column]) -> tuple[Column | None, Array]:
    """The column that says when frames are, by its name and its values."""
    for column in (*named_for(free, "time"), *named_for(free, "count")):
        try:
            values = raw.numbers(column.index)
        except InputError:
            continue  # words: no clock
        if goes_up(values) and not is_count(values):
            return column, values
    return None, np.zeros(0)


def is_count(values: Array) -> bool:
    """Whether values go up by one, which counts frames and says nothing of time."""
    return len(values) > 1 and bool((np.diff(values) == 1).all())


def goes_up(values: Array) -> bool:
    """Whether values are stamps, by and large; one that goes back is a fault of theirs."""
    return len(values) > 1 and bool((np.diff(values) > 0).mean() > 0.5)


def stamped(values: Array, where: str) -> Clock:
    """The clock of stamps, in seconds or a part of them.

    Args:
        where: what to call the stamps in messages: 'walk.csv, column time'.

    Raises:
        InputError: they do not go up, or tell no rate that a robot's recording can have.
    """
    steps = np.diff(values)
    back = np.flatnonzero(steps <= 0)
    if len(back):
        row = int(back[0])
        raise InputError(
            f"{where}: frame {row + 2} is at {values[row + 1]:g}, not after the one before, at "
            f"{values[row]:g}"
        )
    step = float(np.median(steps))
    scale, unit = next(
        ((s, u) for s, u in _SCALES if RATES[0] <= 1 / (s * step) <= RATES[1]), (0.0, "")
    )
    if not scale:
        raise InputError(f"{where}: stamps that go up by {step:g} tell no rate")
    times = (values - values[0]) * scale
    fps = (len(values) - 1) / float(times[-1])
    even = 1 / (scale * step)
    remarks = []
    if np.abs(steps / step - 1).max() > JITTER:
        wide = int(np.argmax(steps))
        if steps[wide] > GAP * step:
            remarks.append(
                f"{where}: nothing for {steps[wide] * scale:.3g} s after frame {wide + 1}; the way "
                "there is straight"
            )
        else:
            low, high = 1 / (scale * steps.max()), 1 / (scale * steps.min())
            remarks.append(f"{where}: uneven stamps, {low:.3g} to {high:.3g} Hz")
        fps = even
    rounded = round(fps, 2)
    fps = rounded if abs(fps - rounded) < 0.002 * fps else fps
    said = "" if unit == "s" else f", in {unit}"
    return Clock(fps, f"{where}{said}", times, tuple(remarks))


def resampled(positions: Array, clock: Clock, fps: float) -> Array:
    """(T', J) the motion (T, J) at another rate, straight between frames.

    Raises:
        InputError: more frames than a motion has.
    """
    uneven = clock.times is not None and bool(clock.remarks)
    if abs(clock.fps / fps - 1) < SAME and not uneven:
        return positions
    times = clock.times if clock.times is not None else np.arange(len(positions)) / clock.fps
    if not uneven:
        times = np.arange(len(positions)) / clock.fps  # stamps are rounded, the rate is not
    frames = int(np.floor(times[-1] * fps + 1e-6)) + 1
    if frames > MAX_FRAMES:
        raise InputError(
            f"{clock.source}: from the first frame to the last it is {times[-1]:.4g} s, at {fps:g} "
            f"Hz {frames:,} frames; a motion has at most {MAX_FRAMES:,}"
        )
    at = np.arange(frames) / fps
    return np.column_stack([np.interp(at, times, column) for column in positions.T])
