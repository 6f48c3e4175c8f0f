"""What is exported is within limits, and comes back the same."""

from __future__ import annotations

import ast
import runpy
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.core.recognition import recognize
from rnnpb_explorer.core.recognition_run import RecognitionConfig
from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.export import (
    export_motion,
    posture,
    with_safe_posture,
)
from rnnpb_explorer.robot.formats import FORMATS, Format
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS, PEPPER_STAND
from rnnpb_explorer.robot.reading import read_motions
from rnnpb_explorer.robot.reading.scripts import script_frames
from rnnpb_explorer.robot.safety import check_motion


@pytest.fixture(scope="module")
def pepper() -> Robot:
    return load_robot("pepper")


@pytest.fixture
def wild() -> Motion:
    """60 frames that break limits of position and velocity."""
    t = np.linspace(0, 4 * np.pi, 60)[:, None]
    phase = np.arange(len(PEPPER_JOINTS))
    positions = (1.5 * np.sin(t + phase)).astype(np.float32)
    return Motion("Wild_1", PEPPER_JOINTS, positions, 25.0)


def _back(content: str, file_format: Format) -> Motion:
    name = {"json": "Wild_1.json", "naoqi": "Wild_1.py", "csv": "Wild_1.csv"}[file_format]
    return read_motions(content.encode(), name, PEPPER_JOINTS).motion()


@pytest.mark.parametrize("file_format", FORMATS)
@pytest.mark.parametrize("safe", [False, True])
def test_exports_are_within_limits_unless_one_insists(
    wild: Motion, pepper: Robot, file_format: Format, safe: bool
) -> None:
    assert check_motion(wild, pepper).light == "red"
    exported = export_motion(wild, pepper, file_format, safe_posture=safe)
    assert exported.report.light == "red"  # of what was asked for
    assert check_motion(_back(exported.content, file_format), pepper).light == "green"
    insisted = export_motion(wild, pepper, file_format, safe_posture=safe, enforce_limits=False)
    assert check_motion(_back(insisted.content, file_format), pepper).light == "red"


@pytest.mark.parametrize("file_format", FORMATS)
@pytest.mark.parametrize("limited", [True, False])
def test_what_is_no_number_is_not_exported(
    wild: Motion, pepper: Robot, file_format: Format, limited: bool
) -> None:
    wild.positions[7, 0] = np.nan
    with pytest.raises(InputError, match=r"Wild_1 .*HeadPitch: nan instead of a position, frame 7"):
        export_motion(wild, pepper, file_format, safe_posture=True, enforce_limits=limited)


@pytest.mark.parametrize("file_format", FORMATS)
def test_what_was_exported_comes_back(wild: Motion, pepper: Robot, file_format: Format) -> None:
    exported = export_motion(wild, pepper, file_format)
    back = _back(exported.content, file_format)
    assert back.joints == wild.joints
    assert back.fps == wild.fps
    assert exported.suffix == {"csv": ".csv", "json": ".json", "naoqi": ".py"}[file_format]
    np.testing.assert_allclose(back.positions, exported.motion.positions, atol=1e-6)
    if file_format != "csv":
        assert back.name == "Wild_1"


@pytest.mark.parametrize("file_format", FORMATS)
def test_what_was_exported_is_recognised_as_before(
    strong: RNNPB, pepper: Robot, file_format: Format
) -> None:
    positions = strong.generate(strong.mu[4:5], 80)[0].numpy()
    motion = Motion("M", strong.info.joints, positions, strong.info.fps)
    exported = export_motion(motion, pepper, file_format)
    back = _back(exported.content, file_format)
    config = RecognitionConfig(iterations=5)
    before, after = (
        [step.loss for step in recognize(strong, m.positions, config)]
        for m in (exported.motion, back)
    )
    np.testing.assert_allclose(before, after, atol=1e-4)


@pytest.mark.parametrize("file_format", FORMATS)
def test_from_the_safe_posture_and_back(wild: Motion, pepper: Robot, file_format: Format) -> None:
    whole = export_motion(wild, pepper, file_format, safe_posture=True).motion
    stand = [PEPPER_STAND[joint] for joint in PEPPER_JOINTS]
    np.testing.assert_allclose(whole.positions[[0, -1]], [stand, stand], atol=1e-6)
    motion, (lead_in, lead_out) = with_safe_posture(
        export_motion(wild, pepper, "csv").motion, pepper
    )
    np.testing.assert_array_equal(motion.positions, whole.positions)
    assert len(whole) == lead_in + len(wild) + lead_out
    limits = np.array([pepper.velocity_limits[joint] for joint in PEPPER_JOINTS])
    for part in (whole.positions[: lead_in + 1], whole.positions[-lead_out - 1 :]):
        speed = np.abs(np.diff(part, axis=0)) * whole.fps
        assert (speed <= 1.01 * 0.3 * limits).all()


@pytest.mark.parametrize("file_format", ["json", "naoqi"])
def test_an_import_leaves_out_the_leads(wild: Motion, pepper: Robot, file_format: Format) -> None:
    plain = export_motion(wild, pepper, file_format)
    led = export_motion(wild, pepper, file_format, safe_posture=True)
    back = _back(led.content, file_format)
    np.testing.assert_allclose(back.positions, plain.motion.positions, atol=1e-6)


def test_what_limiting_changed_is_said(wild: Motion, pepper: Robot) -> None:
    exported = export_motion(wild, pepper, "csv", safe_posture=True)
    assert set(exported.changes) == set(exported.report.joints)
    assert max(exported.changes.values()) > 0.1
    assert export_motion(wild, pepper, "csv", enforce_limits=False).changes == {}


def test_other_robots_rest_in_neutral(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="arm"><link name="a"/><link name="b"/><joint name="turn" type="revolute">'
        '<parent link="a"/><child link="b"/><limit lower="0.5" upper="2" velocity="0" effort="1"/>'
        "</joint></robot>"
    )
    arm = load_robot(str(path))
    assert posture(arm) == {"turn": 0.5}
    motion = Motion("m", ("turn", "tail"), np.full((5, 2), 1.5, dtype=np.float32), 20.0)
    whole = export_motion(motion, arm, "csv", safe_posture=True).motion
    np.testing.assert_allclose(whole.positions[[0, -1]], [[0.5, 1.5], [0.5, 1.5]])
    with pytest.raises(InputError, match="tail"):
        export_motion(motion, arm, "naoqi")


class FakeMotion:
    """Takes what a script sends to ALMotion."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []

    def wakeUp(self) -> None:  # NAOqi's name
        self.calls.append(("wakeUp",))

    def angleInterpolation(self, *arguments: Any) -> None:
        self.calls.append(("angleInterpolation", *arguments))


def test_the_naoqi_script_sends_the_motion(
    wild: Motion, pepper: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Run with stand-ins for the robot's own modules: the arguments are what ALMotion wants."""
    exported = export_motion(wild, pepper, "naoqi")
    path = tmp_path / "wild.py"
    path.write_text(exported.content)
    motion = FakeMotion()
    session = types.SimpleNamespace(
        connect=lambda url: motion.calls.append(("connect", url)), service=lambda name: motion
    )
    monkeypatch.setitem(sys.modules, "qi", types.SimpleNamespace(Session=lambda: session))
    monkeypatch.setattr(sys, "argv", [str(path), "10.0.0.5"])
    runpy.run_path(str(path), run_name="__main__")
    connect, wake, (call, names, angles, times, absolute) = motion.calls
    assert (connect, wake) == (("connect", "tcp://10.0.0.5:9559"), ("wakeUp",))
    assert (call, absolute) == ("angleInterpolation", True)
    assert names == list(PEPPER_JOINTS)
    assert [len(row) for row in angles] == [len(row) for row in times] == [60] * 17
    np.testing.assert_allclose(np.transpose(angles), exported.motion.positions, atol=1e-6)
    np.testing.assert_allclose(times[3], 3 + np.arange(60) / 25, atol=1e-8)


# HeadYaw of Pepper: at most 7.33998 radians a second.
def _swing(fps: float) -> Motion:
    """From side to side at 7.339 radians a second."""
    positions = 1.5 - np.abs(np.arange(90) * 7.339 / fps % 6 - 3)
    return Motion("swing", ("HeadYaw",), positions[:, None].astype(np.float32), fps)


@pytest.mark.parametrize(
    ("fps", "first"),
    [
        (25.0, [3.0, 3.04, 3.08, 3.12]),
        (30.0, [3.0, 3.033333333, 3.066666667, 3.1]),
        (60.0, [3.0, 3.016666667, 3.033333333, 3.05]),
        (120.0, [3.0, 3.008333333, 3.016666667, 3.025]),
    ],
)
def test_a_naoqi_script_keeps_the_speed_limit_at_any_rate(
    pepper: Robot, fps: float, first: list[float]
) -> None:
    script = export_motion(_swing(fps), pepper, "naoqi").content
    values = {
        node.targets[0].id: ast.unparse(node.value)
        for node in ast.parse(script).body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    times = np.array(ast.literal_eval(values["TIMES"].partition(" *")[0])[0])
    (angles,) = np.array(ast.literal_eval(values["ANGLES"]))
    assert times[:4].tolist() == first
    speed = np.abs(np.diff(angles)) / np.diff(times)
    assert 7.33 < speed.max() < 7.33998
    _, _, frames, read, _ = script_frames(script, "x.py")
    np.testing.assert_array_equal(read, times)
    np.testing.assert_allclose(frames[:, 0], angles, rtol=1e-7)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_script_that_breaks_limits_as_written_is_not_handed_out(
    pepper: Robot, fps: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rnnpb_explorer.robot.export.NAOQI_DIGITS", 3)
    says = r"swing is not within the limits as it is written: HeadYaw: .* 7\.\d rad/s over 7\.3"
    with pytest.raises(InputError, match=says):
        export_motion(_swing(fps), pepper, "naoqi")
    assert export_motion(_swing(fps), pepper, "csv").suffix == ".csv"
    assert export_motion(_swing(fps), pepper, "naoqi", enforce_limits=False).suffix == ".py"


@pytest.mark.parametrize(
    ("fps", "frames", "least"), [(25.0, 36, 25), (30.0, 43, 30), (60.0, 86, 60)]
)
def test_the_way_from_the_safe_posture_is_slow(
    pepper: Robot, fps: float, frames: int, least: int
) -> None:
    """At most 0.3 of the speed limit, 2.202 radians a second, and never less than a second."""
    far, near = (
        Motion("m", ("HeadYaw",), np.full((5, 1), yaw, dtype=np.float32), fps) for yaw in (2.0, 0.1)
    )
    whole, leads = with_safe_posture(far, pepper)
    assert leads == (frames, frames)
    assert 2.16 < (np.abs(np.diff(whole.positions[:, 0])) * fps).max() < 2.202
    assert with_safe_posture(near, pepper)[1] == (least, least)


def test_the_naoqi_script_falls_back_on_naoqi(
    wild: Motion, pepper: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "wild.py"
    path.write_text(export_motion(wild, pepper, "naoqi").content)
    motion = FakeMotion()
    proxies: list[tuple[Any, ...]] = []

    def proxy(*arguments: Any) -> FakeMotion:
        proxies.append(arguments)
        return motion

    monkeypatch.setitem(sys.modules, "qi", None)
    monkeypatch.setitem(sys.modules, "naoqi", types.SimpleNamespace(ALProxy=proxy))
    monkeypatch.setattr(sys, "argv", [str(path)])
    runpy.run_path(str(path), run_name="__main__")
    assert proxies == [("ALMotion", "127.0.0.1", 9559)]
    assert len(motion.calls) == 2


def test_a_motions_name_cannot_write_code(pepper: Robot, tmp_path: Path) -> None:
    name = '"""\nimport os\nos.abort()\n"""\\'
    motion = Motion(name, ("HeadYaw",), np.zeros((3, 1), dtype=np.float32), 25.0)
    path = tmp_path / "x.py"
    path.write_text(export_motion(motion, pepper, "naoqi").content)
    ran = subprocess.run(
        [sys.executable, "-c", f"import runpy; runpy.run_path({str(path)!r})"], check=False
    )
    assert ran.returncode == 0
    assert path.read_text().isascii()


def test_an_unknown_format_lists_what_there_is(wild: Motion, pepper: Robot) -> None:
    with pytest.raises(InputError, match="csv, json, naoqi"):
        export_motion(wild, pepper, "bvh")  # type: ignore[arg-type]
