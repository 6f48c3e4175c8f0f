"""Files from anywhere: a motion, or one plain line on why it is none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.core.recognition_lm import LMConfig, recognize_lm
from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.export import export_motion
from rnnpb_explorer.robot.formats import FORMATS, Format
from rnnpb_explorer.robot.importing import MAX_BYTES, import_motion, parse_json, parse_naoqi
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS


@pytest.fixture(scope="module")
def pepper() -> Robot:
    return load_robot("pepper")


@pytest.fixture
def calm() -> Motion:
    """20 frames within all limits."""
    t = np.linspace(0, 2, 20)[:, None]
    positions = (0.3 + 0.05 * np.sin(t + np.arange(17))).astype(np.float32)
    return Motion("Calm_1", PEPPER_JOINTS, positions, 25.0)


def imported(content: str | bytes, suffix: str, joints: tuple[str, ...] = PEPPER_JOINTS) -> Motion:
    content = content.encode() if isinstance(content, str) else content
    return import_motion(content, suffix, joints, name="x", source=f"x{suffix}", fps=25.0)


@pytest.mark.parametrize("file_format", FORMATS)
def test_joints_go_by_name(calm: Motion, pepper: Robot, file_format: Format) -> None:
    exported = export_motion(calm, pepper, file_format)
    joints = ("RHand", "HeadYaw", "KneePitch")
    back = imported(exported.content, exported.suffix, joints)
    columns = [PEPPER_JOINTS.index(joint) for joint in joints]
    assert back.joints == joints
    np.testing.assert_allclose(back.positions, exported.motion.positions[:, columns], atol=1e-6)


@pytest.mark.parametrize("file_format", FORMATS)
def test_a_generated_motion_comes_back_to_its_mu(
    strong: RNNPB, pepper: Robot, file_format: Format
) -> None:
    """Generate, export, import, recognise: the latent that it started from."""
    mu = strong.mu[strong.motion_index("Happy_4")] + 0.15  # no learned one: it has to travel
    positions = strong.generate(mu[None], 40)[0].numpy()
    motion = Motion("M", strong.info.joints, positions, strong.info.fps)
    exported = export_motion(
        motion, pepper, file_format, safe_posture=file_format != "csv", enforce_limits=False
    )
    back = imported(exported.content, exported.suffix, strong.info.joints)
    *_, last = recognize_lm(strong, back.positions, LMConfig(1, iterations=10))
    np.testing.assert_allclose(last.mu_next[0], mu.numpy(), atol=5e-3)


def test_the_suffix_says_what_a_file_is(calm: Motion, pepper: Robot) -> None:
    exported = export_motion(calm, pepper, "json").content
    assert len(imported(exported, ".JSON")) == 20
    with pytest.raises(InputError, match=r"x\.py is no exported NAOqi script"):
        imported(exported, ".py")
    assert len(imported(format_motion(calm), ".txt")) == 20  # everything else is CSV


def test_a_joint_that_the_file_lacks_is_named(calm: Motion, pepper: Robot) -> None:
    exported = export_motion(calm, pepper, "json").content
    with pytest.raises(InputError, match=r"x\.json has no joint Tail"):
        imported(exported, ".json", (*PEPPER_JOINTS, "Tail"))


def test_a_motion_at_another_rate_is_refused(calm: Motion, pepper: Robot) -> None:
    slow = Motion(calm.name, calm.joints, calm.positions, 20.0)
    with pytest.raises(InputError, match="20 frames a second, the model 25"):
        imported(export_motion(slow, pepper, "json").content, ".json")


@pytest.mark.parametrize("suffix", [".json", ".py"])
def test_a_large_file_is_not_read(suffix: str) -> None:
    with pytest.raises(InputError, match=r"too large; at most 4 MB"):
        imported(b" " * (MAX_BYTES + 1), suffix)


@pytest.mark.parametrize("suffix", [".json", ".py"])
def test_binary_is_no_text(suffix: str) -> None:
    with pytest.raises(InputError, match="no UTF-8 text"):
        imported(bytes(range(256)), suffix)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("{", "no motion exported as JSON"),
        ("", "no motion exported as JSON"),
        ("[]", "no motion exported as JSON"),
        ("[" * 100_000, "no motion exported as JSON"),
        (json.dumps({"format": "other"}), "rnnpb-motion"),
        (json.dumps({"format": "rnnpb-motion"}), "KeyError"),
    ],
)
def test_no_json_export_is_one_plain_line(content: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        parse_json(content, "x.json")
    assert "\n" not in str(refused.value)


def cell(value: object) -> Any:
    return lambda data: data["positions"][3].__setitem__(2, value)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (cell(float("nan")), "not finite"),
        (cell(1e9), "HipPitch: 1e.09 is no plausible angle in radians"),
        (cell(10**400), "OverflowError"),
        (cell("left"), "ValueError"),
        (cell(None), "not finite|TypeError"),
        (cell([1, 2]), "ValueError"),
        (lambda data: data["positions"][3].pop(), "ValueError"),
        (lambda data: data.update(positions=data["positions"][:1]), "1 frame"),
        (lambda data: data.update(positions=7), "TypeError"),
        (lambda data: data.update(positions=[]), "shape|frames"),
        (lambda data: data.update(lead_in_frames=-3), "leave out -3"),
        (lambda data: data.update(lead_in_frames=10**9), "0 frames"),
        (lambda data: data.update(lead_out_frames=10**9), "0 frames"),
        (lambda data: data.update(fps=0), "no rate"),
        (lambda data: data.update(fps=float("inf")), "no rate"),
        (lambda data: data.update(fps="fast"), "ValueError"),
        (lambda data: data.update(joints=data["joints"][1:]), "shape"),
        (lambda data: data.update(joints=[{}] * 17), "not all different names"),
        (lambda data: data.update(joints=["HeadYaw"] * 17), "not all different names"),
        (lambda data: data.update(joints=None), "TypeError"),
    ],
)
def test_a_json_export_with_rubbish_in_it(
    calm: Motion, pepper: Robot, spoil: Any, says: str
) -> None:
    data = json.loads(export_motion(calm, pepper, "json").content)
    spoil(data)
    with pytest.raises(InputError, match=says) as refused:
        imported(json.dumps(data), ".json")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("NAMES = [", "NAMES = [1, "),
        ("NAMES = ", "NAMEN = "),
        ("ANGLES = [", "ANGLES = [["),
        ("FPS = 25.0", "FPS = None"),
        ("LEADS = [0, 0]", "LEADS = [0]"),
        ("\n]", "\n"),
    ],
)
def test_a_naoqi_script_with_rubbish_in_it(calm: Motion, pepper: Robot, old: str, new: str) -> None:
    script = export_motion(calm, pepper, "naoqi").content
    assert old in script
    with pytest.raises(InputError, match=r"^x\.py") as refused:
        parse_naoqi(script.replace(old, new), "x.py")
    assert "\n" not in str(refused.value)


def test_a_table_that_begins_often_and_never_ends_is_looked_at_once() -> None:
    """Each of these beginnings, followed to the end of the file, would take hours in all."""
    with pytest.raises(InputError, match=r"^x\.py is no exported NAOqi script"):
        parse_naoqi("\nANGLES = [\n" * 300_000, "x.py")


def test_a_script_of_before_there_were_leads_is_read(calm: Motion, pepper: Robot) -> None:
    lines = export_motion(calm, pepper, "naoqi").content.splitlines(keepends=True)
    script = "".join(line for line in lines if not line.startswith("LEADS"))
    assert len(parse_naoqi(script, "x.py")) == 20


def test_a_naoqi_script_is_read_not_run(tmp_path: Path) -> None:
    mark = tmp_path / "ran"
    with pytest.raises(InputError, match=r"x\.py is no exported NAOqi script"):
        parse_naoqi(f"open({str(mark)!r}, 'w')\nNAMES = open('y')", "x.py")
    assert not mark.exists()
