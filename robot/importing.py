"""Motions from files: CSV, and what `export.py` wrote; a script is read, never run."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from ..core.csv_table import Unit, implausible, read_csv_bytes
from ..core.errors import InputError
from ..core.motion import MAX_CSV_BYTES, Motion, check_length, parse_motion
from .formats import JSON_FORMAT
from .openings import pepper_openings

MAX_BYTES = 4_000_000  # the longest motion of Pepper's joints takes 1.2 MB
SUFFIXES = (".csv", ".json", ".py")
# Not Python's own parser: a small file can cost it gigabytes. Python and JSON write these alike.
_TITLE = re.compile(r'^"""([^:"\n]*):', re.M)
_LINES = re.compile(r"^(NAMES|FPS|LEADS) = ([^#\n]+)", re.M)
_ANGLES = ("\nANGLES = ", "\n]")  # how the table of angles begins and ends, on lines of their own
_LAST_COMMA = re.compile(r",\s*\]")
_UNREADABLE = (ValueError, KeyError, TypeError, OverflowError, RecursionError)


def read_motion(
    path: str | os.PathLike[str],
    joints: tuple[str, ...],
    *,
    fps: float = 25.0,
    unit: Unit = "radians",
) -> Motion:
    """A motion from a file; see `import_motion`.

    Raises:
        InputError: the file cannot be read, or its content is not a motion.
    """
    path = Path(path)
    content = read_csv_bytes(path, MAX_CSV_BYTES)
    return import_motion(
        content, path.suffix, joints, name=path.stem, source=path.name, fps=fps, unit=unit
    )


def import_motion(
    content: bytes,
    suffix: str,
    joints: tuple[str, ...],
    *,
    name: str,
    source: str,
    fps: float,
    unit: Unit = "radians",
    openings: Collection[str] | None = None,
) -> Motion:
    """A motion of these joints from the bytes of a CSV file, or of a JSON or NAOqi export.

    Args:
        suffix: `.json` and `.py` are exports, everything else is CSV.
        joints: the columns of the motion; others in the file are left out.
        name, source: what to call the motion, and the file in messages.
        fps: frames a second that the motion must have; a CSV file is taken to.
        unit: of the angles in a CSV file.
        openings: joints that are no angles, as in `Robot.openings`; by default Pepper's.

    Raises:
        InputError: not such a file, too large, joints that it lacks, or another rate.
    """
    suffix = suffix.lower()
    openings = pepper_openings() if openings is None else openings
    if suffix not in (".json", ".py"):
        return parse_motion(
            content, joints, name=name, source=source, fps=fps, unit=unit, openings=openings
        )
    if unit != "radians":
        raise InputError(f"{source} is an export and in radians")
    if len(content) > MAX_BYTES:
        raise InputError(f"{source} is too large; at most {MAX_BYTES / 1e6:g} MB can be read")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{source} is no UTF-8 text (byte {error.start})") from error
    found = (parse_json if suffix == ".json" else parse_naoqi)(text, source)
    missing = [joint for joint in joints if joint not in found.joints]
    if missing:
        raise InputError(f"{source} has no joint {', '.join(missing)}")
    if not math.isclose(found.fps, fps, rel_tol=1e-6):
        raise InputError(f"{source} has {found.fps:g} frames a second, the model {fps:g}")
    columns = [found.joints.index(joint) for joint in joints]
    for joint, column in zip(joints, columns, strict=True):
        values = found.positions[:, column]
        for value in (values.min(), values.max()):
            fault = implausible(value, None if joint in openings else "radians")
            if fault:
                raise InputError(f"{source}, {joint}: {fault}")
    return Motion(name, joints, np.ascontiguousarray(found.positions[:, columns]), fps)


def parse_json(content: str, source: str) -> Motion:
    """The motion in a JSON export, without the frames from and to the safe posture.

    Raises:
        InputError: not such a file.
    """
    try:
        data: Any = json.loads(content)
        if data["format"] != JSON_FORMAT:
            raise InputError(f"{source} is not of the format {JSON_FORMAT}")
        leads = (data["lead_in_frames"], data["lead_out_frames"])
        return _motion(data["name"], data["joints"], data["positions"], data["fps"], leads, source)
    except InputError:
        raise
    except _UNREADABLE as error:
        raise InputError(f"{source} is no motion exported as JSON ({_reason(error)})") from error


def parse_naoqi(content: str, source: str) -> Motion:
    """The motion in a NAOqi export, without the frames from and to the safe posture.

    Raises:
        InputError: not such a script.
    """
    title = _TITLE.search(content)
    try:
        values = {name: json.loads(text) for name, text in _LINES.findall(content)}
        frames = np.array(json.loads(_angles(content)), dtype=np.float32).T  # (T, J)
        leads = values.get("LEADS", (0, 0))
        name = title[1] if title else ""
        return _motion(name, values["NAMES"], frames, values["FPS"], leads, source)
    except InputError:
        raise
    except _UNREADABLE as error:
        raise InputError(f"{source} is no exported NAOqi script ({_reason(error)})") from error


def _angles(content: str) -> str:
    """The table of angles as JSON."""
    begin, end = _ANGLES
    _, found, rest = content.partition(begin)
    table, closed, _ = rest.partition(end)
    if not (found and closed):
        raise KeyError("ANGLES")
    return _LAST_COMMA.sub("]", table + end)


def _motion(name: Any, joints: Any, positions: Any, fps: Any, leads: Any, source: str) -> Motion:
    """A file may have been changed by hand, and may be anyone's."""
    names = tuple(joints)
    if not all(isinstance(joint, str) for joint in names) or len(set(names)) < len(names):
        raise InputError(f"{source}: its joints are not all different names")
    rate = float(fps)
    if not (math.isfinite(rate) and rate > 0):
        raise InputError(f"{source}: {rate:g} frames a second is no rate")
    frames = np.array(positions, dtype=np.float32)
    first, last = (int(count) for count in leads)
    if min(first, last) < 0:
        raise InputError(f"{source}: it cannot leave out {min(first, last)} frames")
    frames = np.ascontiguousarray(frames[first : max(len(frames) - last, 0)])
    motion = Motion(str(name), names, frames, rate)
    check_length(len(motion), source)
    if not np.isfinite(motion.positions).all():
        raise InputError(f"{source} has values that are not finite")
    return motion


def _reason(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0][:120]
