"""Is a motion safe for the robot? Position and velocity limits, and a limited version of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.motion import Motion
from .description import Robot
from .safety_report import AMBER_POSITION, AMBER_VELOCITY, Kind, SafetyReport, Violation

START_FRAMES = 3  # a network's first steps, out of nothing, are where it jumps
SLACK = 1e-5  # rounding is no violation
# The limited motion stays this far inside, so that rounding to a file's digits breaks no limit.
INSIDE = 0.999


def check_motion(
    motion: Motion, robot: Robot, times: NDArray[np.float64] | None = None
) -> SafetyReport:
    """Check every frame against the limits in the robot's description.

    Values that are no numbers are found in all joints, those that the robot lacks included.

    Args:
        times: (T,) seconds, ascending, at which the frames are reached; by default evenly by `fps`.
    """
    known = [column for column, joint in enumerate(motion.joints) if joint in robot.limits]
    joints = [motion.joints[column] for column in known]
    positions = motion.positions[:, known].astype(np.float64)  # (T, K)
    positions[~np.isfinite(positions)] = np.nan  # which breaks no limit in what follows
    lower, upper = np.array([robot.limits[joint] for joint in joints]).reshape(-1, 2).T
    fastest = np.array([robot.velocity_limits[joint] for joint in joints])
    beyond = np.maximum(lower - positions, positions - upper)  # (T, K)
    rate = motion.fps if times is None else 1 / np.diff(times, prepend=-np.inf)[:, None]
    speed = np.abs(np.diff(positions, axis=0, prepend=positions[:1])) * rate  # 0 at first
    outside, too_fast = beyond > SLACK, speed > fastest * (1 + SLACK)
    sliding = {frame.joint for frame in robot.tree.frames if frame.prismatic}
    violations = _not_finite(motion)
    for k in np.flatnonzero((outside | too_fast).any(axis=0)):
        joint = joints[k]
        unit = "" if joint in robot.openings else "m" if joint in sliding else "rad"
        for first, last in _runs(outside[:, k]):
            at = first + int(beyond[first : last + 1, k].argmax())
            worst, excess = float(positions[at, k]), float(beyond[at, k])
            limit = float(lower[k] if worst < lower[k] else upper[k])
            violations.append(Violation("position", joint, first, last, worst, limit, excess, unit))
        for first, last in _runs(too_fast[:, k]):
            worst, limit = float(speed[first : last + 1, k].max()), float(fastest[k])
            kind: Kind = "start" if first <= START_FRAMES else "velocity"
            violations.append(
                Violation(kind, joint, first, last, worst, limit, worst / limit, unit)
            )
    violations.sort(key=_severity, reverse=True)
    unchecked = tuple(joint for joint in motion.joints if not robot.limited(joint))
    return SafetyReport(tuple(violations), unchecked)


def _not_finite(motion: Motion) -> list[Violation]:
    lost = ~np.isfinite(motion.positions)
    return [
        Violation(
            "not finite", joint, first, last, float(motion.positions[first, k]), np.nan, np.inf
        )
        for k, joint in enumerate(motion.joints)
        for first, last in _runs(lost[:, k])
    ]


def _severity(violation: Violation) -> float:
    """On one scale for both kinds: 1 is where amber turns red."""
    if violation.kind == "position":
        return violation.excess / AMBER_POSITION
    return (violation.excess - 1) / (AMBER_VELOCITY - 1)


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


def limit_motion(motion: Motion, robot: Robot) -> Motion:
    """The nearest motion within the robot's position and velocity limits.

    Positions are clipped; then each joint gets the curve that keeps the speed limit with the least
    largest deviation (the mean of the tightest curves above and below that do). It neither lags nor
    changes where nothing was too fast. Joints that the robot lacks stay as they are.
    """
    positions = motion.positions.astype(np.float64)
    for column, joint in enumerate(motion.joints):
        if joint in robot.limits:
            values = np.clip(positions[:, column], *robot.limits[joint])
            step = robot.velocity_limits[joint] / motion.fps
            if np.abs(np.diff(values)).max(initial=0.0) > step:
                values = _slowed(values, INSIDE * step)
            positions[:, column] = values
    return Motion(motion.name, motion.joints, positions.astype(np.float32), motion.fps)


def _slowed(values: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    slope = step * np.arange(len(values))
    above = np.minimum.accumulate(values - slope) + slope  # seen from the past
    above = np.minimum.accumulate((above + slope)[::-1])[::-1] - slope  # and from the future
    below = np.maximum.accumulate(values + slope) - slope
    below = np.maximum.accumulate((below - slope)[::-1])[::-1] + slope
    middle: NDArray[np.float64] = (above + below) / 2
    return middle
