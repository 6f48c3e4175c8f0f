"""Python scripts for NAOqi: what this project exports, and Choregraphe's. None is ever run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import InputError
from .keyframes import Key, played
from .literals import assigned
from .raw import Array, Raw, raw_array

OURS = {"NAMES", "FPS", "TIMES", "ANGLES"}
KEY_FRAMES = {"names", "times", "keys"}
_TITLE = re.compile(r'^"""([^:"\n]*):', re.M)
_BEZIER = 3.0  # NAOqi's number for the interpolation of a handle


def read_script(text: str, source: str, fps: float) -> Raw:
    """The motion in a script.

    Args:
        fps: frames a second that key frames are turned into.

    Raises:
        InputError: no motion in it.
    """
    held = assigned(text)
    if held.keys() >= OURS:
        return _exported(held, text, source)
    if held.keys() >= KEY_FRAMES:
        return _choregraphe(held, source, fps)
    raise InputError(
        f"{source} is neither a script that was exported here nor one of Choregraphe's: it has no "
        "lists of names, times and keys"
    )


def script_frames(text: str, source: str) -> tuple[str, tuple[str, ...], Array, Array, float]:
    """Every frame of an exported script, those from and to the safe posture included.

    Returns:
        the motion's name, (J,) joints, (T, J) angles, (T,) seconds at which they are reached, fps.

    Raises:
        InputError: not such a script.
    """
    held = assigned(text)
    if not held.keys() >= OURS:
        raise InputError(f"{source} is no exported NAOqi script")
    names, angles = _texts(held["NAMES"], source), _table(held["ANGLES"], source)
    times, fps = _table(held["TIMES"], source), _number(held["FPS"], source)
    if len(angles) != len(names) or times.shape[1] != angles.shape[1]:
        raise InputError(f"{source}: its names, times and angles do not go together")
    title = _TITLE.search(text)
    return title[1] if title else "", names, angles.T, times[0], fps


def _exported(held: dict[str, Any], text: str, source: str) -> Raw:
    _, names, angles, _, fps = script_frames(text, source)
    angles = without_leads(angles, held.get("LEADS", [0.0, 0.0]), source)
    units = ("radians",) * len(names)
    return raw_array("NAOqi script", source, names, angles, fps=fps, units=units)


def without_leads(frames: Array, leads: Any, source: str) -> Array:
    """The motion without its way from and to the safe posture: (frames before, frames after)."""
    if not (isinstance(leads, list) and len(leads) == 2):
        raise InputError(f"{source}: how many frames lead in and out is not two numbers")
    first, last = (_number(count, source) for count in leads)
    if min(first, last) < 0:
        raise InputError(f"{source}: it cannot leave out {min(first, last):g} frames")
    return frames[int(min(first, 1e9)) : max(len(frames) - int(min(last, 1e9)), 0)]


def _choregraphe(held: dict[str, Any], source: str, fps: float) -> Raw:
    joints, times, keys = _texts(held["names"], source), held["times"], held["keys"]
    if not (isinstance(times, list) and isinstance(keys, list)):
        raise InputError(f"{source}: its times and keys are no lists")
    if not len(joints) == len(times) == len(keys):
        raise InputError(
            f"{source} has {len(joints)} names, {len(times)} lists of times and {len(keys)} of keys"
        )
    curves = {
        joint: [_key(t, k, joint, source) for t, k in _pairs(at, values, joint, source)]
        for joint, at, values in zip(joints, times, keys, strict=True)
    }
    order, values = played(curves, fps, source)
    return raw_array(
        "Choregraphe script", source, order, values, fps=fps, units=("radians",) * len(order),
        remarks=(f"key frames, played at {fps:g} Hz",),
    )  # fmt: skip


def _pairs(times: Any, keys: Any, joint: str, source: str) -> list[tuple[Any, Any]]:
    if not (isinstance(times, list) and isinstance(keys, list) and len(times) == len(keys)):
        raise InputError(f"{source}, {joint}: not as many times as keys")
    return list(zip(times, keys, strict=True))


def _key(time: Any, key: Any, joint: str, source: str) -> Key:
    """A number, or [number, handle before, handle after] with handles [kind, seconds, angle]."""
    where = f"{source}, {joint}"
    if not isinstance(key, list):
        return Key(_number(time, where), _number(key, where))
    if not key:
        raise InputError(f"{where}: an empty key frame")
    handles = [_handle(one, where) for one in key[1:3]]
    before, after = (*handles, None, None)[:2]
    return Key(_number(time, where), _number(key[0], where), before, after)


def _handle(handle: Any, where: str) -> tuple[float, float] | None:
    if not (isinstance(handle, list) and len(handle) == 3):
        raise InputError(f"{where}: a handle is a kind, seconds and an angle")
    kind, seconds, angle = (_number(value, where) for value in handle)
    return (seconds, angle) if kind == _BEZIER else None


def _texts(value: Any, source: str) -> tuple[str, ...]:
    names = tuple(value) if isinstance(value, list) else ()
    if (
        not names
        or not all(isinstance(name, str) for name in names)
        or len(set(names)) < len(names)
    ):
        raise InputError(f"{source}: its joints are not all different names")
    return names


def _table(value: Any, source: str) -> Array:
    rows: Sequence[Any] = value if isinstance(value, list) else ()
    if not rows or len({len(row) if isinstance(row, list) else -1 for row in rows}) != 1:
        raise InputError(f"{source}: its lists of numbers are not equally long")
    try:
        table = np.array(rows, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise InputError(f"{source}: there is something else among its numbers") from error
    if table.ndim != 2:
        raise InputError(f"{source}: its lists of numbers are not equally long")
    return table


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where}: {str(value)[:20]!r} is no number")
    return float(value)
