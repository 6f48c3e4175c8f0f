"""A motion for a real robot: CSV, JSON, or a NAOqi script; nothing here connects to one."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..core.errors import InputError
from ..core.motion import Motion, format_motion
from .description import Robot
from .formats import FORMATS, JSON_FORMAT, Format
from .pepper import PEPPER_STAND
from .reading.scripts import script_frames
from .safety import check_motion, limit_motion
from .safety_report import SafetyReport

APPROACH_SPEED = 0.3  # of the velocity limits, on the way from and to the safe posture
MIN_APPROACH = 1.0  # seconds
UNKNOWN_SPEED = 0.5  # radians a second where a robot states no limit
LEAD_IN = 3.0  # seconds that a NAOqi script takes to its first frame, from wherever the robot is
NAOQI_DIGITS = 9  # after the point, of angles and times: rounding must not make a joint faster


@dataclass(frozen=True)
class Export:
    """What was written, and what is to be known of it.

    report: of the motion as it was given, before limits were enforced.
    changes: the largest change that limiting made to each joint that it changed, in its unit.
    """

    content: str
    suffix: str
    motion: Motion
    report: SafetyReport
    changes: dict[str, float] = field(default_factory=dict)


def export_motion(
    motion: Motion,
    robot: Robot,
    file_format: Format,
    *,
    safe_posture: bool = False,
    enforce_limits: bool = True,
) -> Export:
    """The motion as the text of a file.

    Args:
        safe_posture: start from and return to `posture`, slowly.
        enforce_limits: export the limited motion; without, the raw one, whatever it breaks.

    Raises:
        InputError: no such format, values that are not finite, joints that NAOqi does not know, or
            a file that would break limits as it is written.
    """
    if file_format not in FORMATS:
        raise InputError(f"no export format {file_format!r}; there are {', '.join(FORMATS)}")
    report = check_motion(motion, robot)
    for violation in report.violations:
        if violation.kind == "not finite":
            raise InputError(f"{motion.name} is no motion for a robot: {violation}")
    changes: dict[str, float] = {}
    if enforce_limits:
        raw, motion = motion, limit_motion(motion, robot)
        most = np.abs(motion.positions - raw.positions).max(axis=0)
        changes = {
            joint: float(change)
            for joint, change in zip(motion.joints, most, strict=True)
            if change > 0
        }
    leads = (0, 0)
    if safe_posture:
        motion, leads = with_safe_posture(motion, robot)
    times = None
    if file_format == "csv":  # float32 to the bit, as in JSON: what is written is the motion
        written, content, suffix = motion, format_motion(motion), ".csv"
    elif file_format == "json":
        written, content, suffix = motion, _format_json(motion, leads), ".json"
    else:
        content, suffix = _format_naoqi(motion, leads), ".py"
        title, joints, frames, times, fps = script_frames(content, "the script")
        written = Motion(title, joints, frames.astype(np.float32), fps)
    broken = check_motion(written, robot, times).violations
    if enforce_limits and broken:
        raise InputError(f"{motion.name} is not within the limits as it is written: {broken[0]}")
    return Export(content, suffix, motion, report, changes)


def posture(robot: Robot) -> dict[str, float]:
    """Where the robot stands safely: Pepper's standing posture; else all joints in neutral."""
    neutral = {joint: robot.neutral(joint) for joint in robot.joints}
    return neutral | PEPPER_STAND if set(PEPPER_STAND) <= set(neutral) else neutral


def with_safe_posture(motion: Motion, robot: Robot) -> tuple[Motion, tuple[int, int]]:
    """The motion, led in from the safe posture and back to it, and the frames that this takes.

    A lead is a smooth ramp from rest to rest, no joint above APPROACH_SPEED of its limit. Joints
    that the robot lacks wait where they are.
    """
    safe = posture(robot)
    positions = motion.positions.astype(np.float64)
    start, end = positions[0], positions[-1]
    rest = np.array([safe.get(joint, np.nan) for joint in motion.joints])
    lead_in = _ramp(np.where(np.isnan(rest), start, rest), start, motion, robot)
    lead_out = _ramp(np.where(np.isnan(rest), end, rest), end, motion, robot)[::-1]
    whole = np.concatenate([lead_in, positions, lead_out]).astype(np.float32)
    return Motion(motion.name, motion.joints, whole, motion.fps), (len(lead_in), len(lead_out))


def _ramp(
    rest: NDArray[np.float64], end: NDArray[np.float64], motion: Motion, robot: Robot
) -> NDArray[np.float64]:
    """(n, J) frames from the posture towards, not including, the motion's end."""
    limits = np.array([robot.velocity_limits.get(joint, np.inf) for joint in motion.joints])
    speeds = np.where(np.isfinite(limits), APPROACH_SPEED * limits, UNKNOWN_SPEED)
    peak = math.pi / 2  # of a cosine ramp, times its mean speed
    seconds = max(MIN_APPROACH, float((peak * np.abs(end - rest) / speeds).max()))
    count = math.ceil(seconds * motion.fps)
    share = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
    ramp: NDArray[np.float64] = rest + share[:, None] * (end - rest)
    return ramp


def _format_json(motion: Motion, lead: tuple[int, int]) -> str:
    rows = ",\n    ".join(
        json.dumps([float(f"{value:.9g}") for value in row]) for row in motion.positions.tolist()
    )
    head = json.dumps(
        {
            "format": JSON_FORMAT,
            "version": 1,
            "name": motion.name,
            "fps": motion.fps,
            "unit": "radians",
            "lead_in_frames": lead[0],
            "lead_out_frames": lead[1],
            "joints": list(motion.joints),
        },
        indent=2,
    )
    return f'{head.removesuffix(chr(10) + "}")},\n  "positions": [\n    {rows}\n  ]\n}}\n'


_NAOQI = '''# -*- coding: utf-8 -*-
"""{title}

For Pepper or its simulator, with the Python that comes with NAOqi (2.7) or a later one:
    python {file} [IP [PORT]]
Joint angles in radians, LHand and RHand as openings from 0 to 1; times in seconds.
{note}"""
from __future__ import print_function

import sys

FPS = {fps!r}
LEADS = {leads}  # frames from and to the safe posture
NAMES = {names}
TIMES = [[{times}]] * len(NAMES)
ANGLES = [
{angles}
]


def motion_service(ip, port):
    try:
        import qi
    except ImportError:
        from naoqi import ALProxy
        return ALProxy("ALMotion", ip, port)
    session = qi.Session()
    session.connect("tcp://%s:%d" % (ip, port))
    return session.service("ALMotion")


def main():
    ip = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1"
    port = int(sys.argv[2]) if len(sys.argv) > 2 else 9559
    motion = motion_service(ip, port)
    motion.wakeUp()
    motion.angleInterpolation(NAMES, ANGLES, TIMES, True)
    print("done: %d frames in %.1f s" % (len(ANGLES[0]), TIMES[0][-1]))


if __name__ == "__main__":
    main()
'''


def _format_naoqi(motion: Motion, leads: tuple[int, int]) -> str:
    strange = [joint for joint in motion.joints if joint not in PEPPER_STAND]
    if strange:
        raise InputError(f"NAOqi on Pepper has no joint {', '.join(strange)}; export CSV or JSON")
    times = LEAD_IN + np.arange(len(motion)) / motion.fps
    name = re.sub(r"[^A-Za-z0-9_. +-]", "_", motion.name)  # it may come from anyone's file
    columns = [
        "    [" + ", ".join(f"{value:.{NAOQI_DIGITS}f}" for value in column) + "],"
        for column in motion.positions.T
    ]
    return _NAOQI.format(
        title=f"{name}: {len(motion)} frames at {motion.fps:g} Hz, made with rnnpb-explorer.",
        file=f"{name.replace(' ', '_')}.py",
        note=f"The robot first takes {LEAD_IN:g} s to the first frame. Keep clear of its arms.\n",
        fps=motion.fps,
        leads=list(leads),
        names=json.dumps(list(motion.joints)),
        times=", ".join(f"{time:.{NAOQI_DIGITS}f}" for time in times),
        angles="\n".join(columns),
    )
