"""The safety report on motions whose faults are known, and what limiting makes of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm import write_arm
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.safety import check_motion, limit_motion
from rnnpb_explorer.robot.safety_report import SafetyReport

FPS = 25.0
# In Pepper's URDF: HeadYaw +-2.08567 rad at 7.33998 rad/s, 0.2936 rad a frame of 25 Hz.
YAW, YAW_STEP = 2.08567, 7.33998 / FPS


@pytest.fixture(scope="module")
def pepper() -> Robot:
    return load_robot("pepper")


def _yaw(*values: float) -> Motion:
    positions = np.array(values, dtype=np.float32)[:, None]
    return Motion("turn", ("HeadYaw",), positions, FPS)


def _only(report: SafetyReport) -> tuple[str, int, int, str]:
    (violation,) = report.violations
    return violation.kind, violation.first, violation.last, violation.light


def test_a_calm_motion_is_green(pepper: Robot) -> None:
    report = check_motion(_yaw(0, 0.1, 0.2, 0.1), pepper)
    assert (report.light, report.violations, report.joints) == ("green", (), ())


def test_a_little_beyond_a_limit_is_amber(pepper: Robot) -> None:
    report = check_motion(_yaw(2.0, 2.1, 2.12, 2.0, 2.1), pepper)
    assert report.light == "amber"
    assert sorted((v.first, v.last) for v in report.violations) == [(1, 2), (4, 4)]
    worst = report.violations[0]
    assert (worst.kind, worst.first, worst.last) == ("position", 1, 2)
    assert worst.worst == pytest.approx(2.12)
    assert worst.limit == YAW
    assert worst.excess == pytest.approx(2.12 - YAW, abs=1e-6)
    assert str(worst) == "HeadYaw: position 2.120 rad, limit 2.086, frames 1–2"


def test_far_below_a_limit_is_red(pepper: Robot) -> None:
    report = check_motion(_yaw(-2.0, -2.2, -2.0), pepper)
    assert report.light == "red"
    assert report.violations[0].limit == -YAW


def test_too_fast(pepper: Robot) -> None:
    calm = [0.0] * 10
    report = check_motion(_yaw(*calm, 1.2 * YAW_STEP, 2.4 * YAW_STEP, 2.4 * YAW_STEP), pepper)
    assert _only(report) == ("velocity", 10, 11, "amber")
    assert report.violations[0].worst == pytest.approx(1.2 * 7.33998, rel=1e-5)
    assert report.violations[0].excess == pytest.approx(1.2, rel=1e-5)
    assert str(report.violations[0]) == "HeadYaw: velocity 8.8 rad/s over 7.3, frames 10–11"
    assert check_motion(_yaw(*calm, 2.1 * YAW_STEP), pepper).light == "red"


@pytest.mark.parametrize(
    ("fps", "step", "light"),
    [
        (25.0, 0.29, "green"),  # 7.25 radians a second; the limit is 7.34
        (30.0, 0.24, "green"),
        (30.0, 0.25, "amber"),  # 7.5
        (30.0, 0.5, "red"),
        (60.0, 0.12, "green"),
        (60.0, 0.125, "amber"),
        (60.0, 0.25, "red"),  # 15, more than twice the limit
    ],
)
def test_speed_is_a_matter_of_the_rate(pepper: Robot, fps: float, step: float, light: str) -> None:
    positions = np.array([0.0] * 6 + [step] * 3, dtype=np.float32)[:, None]
    motion = Motion("turn", ("HeadYaw",), positions, fps)
    report = check_motion(motion, pepper)
    assert report.light == light
    if light != "green":
        assert report.violations[0].worst == pytest.approx(step * fps, rel=1e-5)
    # the same frames, reached in half the time
    faster = check_motion(motion, pepper, np.arange(9) / (2 * fps))
    assert faster.violations[0].worst == pytest.approx(2 * step * fps, rel=1e-5)


def test_a_jump_at_the_start_is_called_so(pepper: Robot) -> None:
    report = check_motion(_yaw(0.0, 2.5 * YAW_STEP, 2.5 * YAW_STEP, 2.5 * YAW_STEP), pepper)
    assert _only(report) == ("start", 1, 1, "red")
    assert "at the start" in str(report.violations[0])


def test_the_worst_comes_first(pepper: Robot) -> None:
    positions = np.zeros((6, 2), dtype=np.float32)
    positions[4:, 0] = 2.1  # HeadYaw: a little beyond, and a jump of many times the speed limit
    positions[:, 1] = 0.48  # HeadPitch: 0.05 beyond 0.43
    report = check_motion(Motion("m", ("HeadYaw", "HeadPitch"), positions, FPS), pepper)
    assert [v.joint for v in report.violations] == ["HeadYaw", "HeadPitch", "HeadYaw"]
    assert report.joints == ("HeadYaw", "HeadPitch")


def test_strange_joints_are_named_not_checked(pepper: Robot) -> None:
    motion = Motion("m", ("Tail", "HeadYaw"), np.full((3, 2), 9.0, dtype=np.float32), FPS)
    report = check_motion(motion, pepper)
    assert report.unchecked == ("Tail",)
    assert report.joints == ("HeadYaw",)
    limited = limit_motion(motion, pepper)
    assert (limited.positions[:, 0] == 9.0).all()
    assert check_motion(limited, pepper).light == "grey"


def test_a_joint_without_limits_is_not_checked(tmp_path: Path) -> None:
    arm = load_robot(str(write_arm(tmp_path)))  # its joint d is continuous, of any speed
    report = check_motion(Motion("m", ("a", "d"), np.zeros((3, 2), dtype=np.float32)), arm)
    assert (report.unchecked, report.light) == (("d",), "grey")
    report = check_motion(Motion("m", ("a", "slide"), np.zeros((3, 2), dtype=np.float32)), arm)
    assert (report.unchecked, report.light) == ((), "green")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("joint", ["HeadYaw", "Tail"])
def test_what_is_no_number_is_red_and_comes_first(pepper: Robot, value: float, joint: str) -> None:
    positions = np.zeros((8, 2), dtype=np.float32)
    positions[3:5, 0] = value
    positions[7, 1] = 0.8  # HeadPitch: too far and too fast
    report = check_motion(Motion("m", (joint, "HeadPitch"), positions, FPS), pepper)
    assert report.light == "red"
    first, *others = report.violations
    assert (first.kind, first.joint, first.first, first.last) == ("not finite", joint, 3, 4)
    assert str(first) == f"{joint}: {value} instead of a position, frames 3–4"
    assert [v.joint for v in others] == ["HeadPitch", "HeadPitch"]


def test_a_motion_within_limits_stays_as_it_is(pepper: Robot) -> None:
    motion = _yaw(0, 0.2, 0.4, 0.3)
    np.testing.assert_array_equal(limit_motion(motion, pepper).positions, motion.positions)


def test_limiting_splits_a_step_evenly(pepper: Robot) -> None:
    """Half of a step of twice the speed comes a frame early, half a frame late; no lag remains."""
    motion = _yaw(*[0.0] * 5, *[2 * YAW_STEP] * 5)
    slowed = limit_motion(motion, pepper).positions[:, 0]
    expected = np.array([0, 0, 0, 0, 0.5, 1.5, 2, 2, 2, 2]) * YAW_STEP
    np.testing.assert_allclose(slowed, expected, atol=0.002)


@pytest.mark.parametrize(
    ("fps", "jump", "expected"),
    [
        (25.0, 0.6, [0, 0, 0, 0.00669, 0.15335, 0.44665, 0.59331, 0.6, 0.6]),
        (30.0, 0.5, [0, 0, 0, 0.00558, 0.12779, 0.37221, 0.49442, 0.5, 0.5]),
        (60.0, 0.25, [0, 0, 0, 0.00279, 0.06389, 0.18611, 0.24721, 0.25, 0.25]),
    ],
)
def test_limiting_knows_the_rate(
    pepper: Robot, fps: float, jump: float, expected: list[float]
) -> None:
    """A thousandth inside of 7.33998 radians a second, so that a file's digits break no limit."""
    positions = np.array([0.0] * 5 + [jump] * 4, dtype=np.float32)[:, None]
    slowed = limit_motion(Motion("turn", ("HeadYaw",), positions, fps), pepper)
    np.testing.assert_allclose(slowed.positions[:, 0], expected, atol=6e-6)
    assert np.abs(np.diff(slowed.positions[:, 0])).max() * fps < 7.3350


@settings(max_examples=60, deadline=None)
@given(
    values=arrays(np.float32, st.tuples(st.integers(2, 30), st.just(2)),
                  elements=st.floats(-4, 4, width=32))
)  # fmt: skip
def test_any_motion_can_be_limited(values: NDArray[np.float32]) -> None:
    pepper = load_pepper()
    motion = Motion("wild", ("HeadPitch", "LElbowRoll"), values, FPS)
    limited = limit_motion(motion, pepper)
    assert check_motion(limited, pepper).light == "green"
    again = limit_motion(limited, pepper)
    np.testing.assert_allclose(again.positions, limited.positions, atol=1e-6)
    clipped = np.stack(
        [np.clip(values[:, i], *pepper.limits[joint]) for i, joint in enumerate(motion.joints)], 1
    )
    # within what the clipped values span: nothing overshoots
    assert (limited.positions <= clipped.max(axis=0) + 1e-5).all()
    assert (limited.positions >= clipped.min(axis=0) - 1e-5).all()


_LOADED: list[Robot] = []


def load_pepper() -> Robot:
    """Once: hypothesis takes no fixtures of smaller scope."""
    if not _LOADED:
        _LOADED.append(load_robot("pepper"))
    return _LOADED[0]


def test_recorded_motions_are_never_red(dataset: Dataset, pepper: Robot) -> None:
    """They ran on the robot; some ask for a little more than its description allows."""
    lights = [check_motion(motion, pepper).light for motion in dataset.motions]
    assert set(lights) == {"green", "amber"}
    for motion in dataset.motions:
        limited = limit_motion(motion, pepper)
        assert check_motion(limited, pepper).light == "green"
        assert np.abs(limited.positions - motion.positions).max() < 0.12
