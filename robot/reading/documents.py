"""Motions as JSON, as this project exports them."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from ...core.errors import InputError
from ..formats import JSON_FORMAT
from .foreign import foreign_json
from .raw import Raw, raw_array
from .scripts import without_leads


def read_json(text: str, source: str) -> Raw:
    """An exported motion, without the frames from and to the safe posture.

    Raises:
        InputError: not such a file.
    """
    try:
        data: Any = json.loads(text)
    except RecursionError as error:
        raise InputError(f"{source} is no motion exported as JSON") from error
    except ValueError as error:
        line = f", line {error.lineno}" if isinstance(error, json.JSONDecodeError) else ""
        raise InputError(f"{source}{line}: this is no JSON") from error
    other = foreign_json(data)
    if other:
        raise InputError(f"{source} {other}")
    if not isinstance(data, dict) or data.get("format") != JSON_FORMAT:
        raise InputError(f"{source} is no motion exported as JSON (not of format {JSON_FORMAT})")
    absent = [key for key in ("joints", "positions", "fps") if key not in data]
    if absent:
        raise InputError(f"{source} is no motion exported as JSON (it has no {absent[0]})")
    joints = data["joints"]
    names = tuple(joints) if isinstance(joints, list) else ()
    if not names or not all(isinstance(one, str) for one in names) or len(set(names)) < len(names):
        raise InputError(f"{source}: its joints are not all different names")
    fps = data["fps"]
    rate = float(fps) if isinstance(fps, int | float) and abs(fps) < 1e9 else math.nan
    if not rate > 0:
        raise InputError(f"{source}: {str(fps)[:20]} frames a second is no rate")
    leads = [data.get("lead_in_frames", 0), data.get("lead_out_frames", 0)]
    frames = without_leads(_frames(data["positions"], len(names), source), leads, source)
    return raw_array("JSON", source, names, frames, fps=rate, units=("radians",) * len(names))


def _frames(rows: Any, joints: int, source: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    if not isinstance(rows, list):
        raise InputError(f"{source}: its positions are no list of frames")
    for number, row in enumerate(rows, start=1):
        if not isinstance(row, list) or len(row) != joints:
            raise InputError(f"{source}, frame {number}: not one value for each of {joints} joints")
        for value in row:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(f"{source}, frame {number}: {str(value)[:20]!r} is no number")
            if not abs(value) < 1e300:
                raise InputError(f"{source}, frame {number}: a value is not finite")
    return np.array(rows, dtype=np.float64).reshape(-1, joints)
