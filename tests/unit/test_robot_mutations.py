"""Whatever becomes of a robot description: a robot, or one line in our own words."""

from __future__ import annotations

import logging
import re
import shutil
import unicodedata
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rnnpb_explorer.app.commands.robot import describe, lines
from rnnpb_explorer.app.page.stage import room_of, staged
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.robot.description import load_robot
from rnnpb_explorer.robot.kinematics import joint_poses
from rnnpb_explorer.robot.meshes import to_glb

FIELD = Path(__file__).parents[1] / "field" / "urdf"
DESCRIPTIONS = {path.name: path.read_bytes() for path in sorted(FIELD.glob("*.urdf"))}
MESHES = {path.name: path.read_bytes() for path in sorted((FIELD / "meshes").iterdir())}
ODD = (
    b"", b" ", b"0", b"0 0 0", b"-1", b"1e999", b"nan", b"-inf", b"1e300", b"1,5", b"1 2", b"pi/2",
    b"${pi}", b"$(find x)", b"1.0f", b"base", b"arm", b"world", b"j1", b"prismatic", b"fixed",
    b"floating", b"../../../..", b"/", b"//", b"file://", b"package://", b"package:///a.stl",
    b"model://x", b"http://x/a.stl", b"%00.stl", b"%", b"\\", b"a" * 3000 + b".stl", b"&lt;",
    b"&a;", b"&#10;", b"&#10;a.stl", b"a&#x9b;", b"\xff", b"1e-300", b"\xe2\x88\x921",
)  # fmt: skip
NOT_OURS = ("Error", "Exception", "Traceback", "object at 0x", "NoneType", "yourdfpy", "trimesh")

Mutation = Callable[[bytes], bytes]


@st.composite
def mutations(draw: st.DrawFn) -> Mutation:
    """One change of a text: bytes deleted, doubled, swapped or others; a value, a name, a tag."""
    kind = draw(
        st.sampled_from(("delete", "double", "swap", "other", "tag", "value", "value", "value"))
    )
    at, length = draw(st.floats(0, 1)), draw(st.integers(1, 60))
    new = draw(st.sampled_from(ODD) | st.binary(max_size=8))

    def change(text: bytes) -> bytes:
        start = int(at * max(len(text) - 1, 0))
        piece, rest = text[start : start + length], text[start + length :]
        if kind == "delete":
            return text[:start] + rest
        if kind == "double":
            return text[:start] + piece * 2 + rest
        if kind == "swap":
            return text[:start] + rest[:length] + piece + rest[length:]
        if kind == "other":
            return text[:start] + new + rest
        found = list(re.finditer(rb'"[^"]*"' if kind == "value" else rb"<[^ />]*", text))
        if not found:
            return text
        begin, end = found[int(at * (len(found) - 1))].span()
        return text[: begin + 1] + new + text[end - (kind == "value") :]

    return change


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("field")
    shutil.copytree(FIELD / "meshes", folder / "meshes")
    return folder


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from(sorted(DESCRIPTIONS)),
    changes=st.lists(mutations(), min_size=1, max_size=4),
)
def test_a_robot_or_one_line(
    name: str, changes: list[Mutation], folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    text = DESCRIPTIONS[name]
    for change in changes:
        text = change(text)
    path = folder / "robot.urdf"
    path.write_bytes(text)
    caplog.clear()
    try:
        said = seen(path)
    except InputError as error:
        said = (str(error),)
        assert "robot.urdf" in said[0]
    in_own_words(said, caplog)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from(sorted(MESHES)),
    changes=st.lists(mutations(), min_size=1, max_size=4),
)
def test_whatever_becomes_of_a_mesh_there_is_a_robot(
    name: str, changes: list[Mutation], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    mesh = MESHES[name]
    for change in changes:
        mesh = change(mesh)
    (tmp_path / name).write_bytes(mesh)
    path = tmp_path / "robot.urdf"
    path.write_bytes(DESCRIPTIONS["utf8-bom.urdf"].replace(b"meshes/Part.STL", name.encode()))
    caplog.clear()
    in_own_words(seen(path), caplog)


def seen(path: Path) -> tuple[str, ...]:
    """A robot's warnings, once all that is shown of it was made and found to be numbers."""
    robot = load_robot(str(path))
    shown = staged(robot)
    assert np.isfinite(room_of(shown)).all()
    poses = joint_poses(shown, robot.joints, np.zeros((2, len(robot.joints))))
    assert np.isfinite(poses.wxyz).all()
    assert np.isfinite(poses.position).all()
    assert to_glb(list(shown.shapes))
    assert lines(describe(robot, None))
    return robot.warnings


def in_own_words(said: tuple[str, ...], caplog: pytest.LogCaptureFixture) -> None:
    for line in said:
        assert not any(unicodedata.category(one) in ("Cc", "Zl", "Zp") for one in line), repr(line)
        assert not any(word in line for word in NOT_OURS), line
    assert [one for one in caplog.records if one.levelno >= logging.WARNING] == []
