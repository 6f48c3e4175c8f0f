"""`rnnpb robot`: what a description gives, what was found of it, and what a model moves there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from arm import write_arm

from .cli_harness import Rnnpb

FIELD = Path(__file__).parents[1] / "field" / "urdf"


def test_pepper_and_the_shipped_model(rnnpb: Rnnpb) -> None:
    facts = json.loads(rnnpb("robot", "--ckpt", "strong", "--json").out)
    assert facts["name"] == "pepper"
    assert facts["height"] == pytest.approx(1.21, abs=0.01)
    assert facts["missing_meshes"] == facts["warnings"] == facts["unmatched"] == []
    assert sorted(facts["matched"]) == sorted(facts["joints"])
    assert facts["limits"]["HeadYaw"] == pytest.approx([-2.08567, 2.08567])
    assert facts["units"]["LHand"] == "openings"
    assert facts["mimics"]["LFinger11"]["joint"] == "LHand"
    assert all(mesh["file"] for mesh in facts["meshes"])


def test_an_arm_for_programs(rnnpb: Rnnpb) -> None:
    path = write_arm(rnnpb.folder)
    facts = json.loads(rnnpb("robot", path, "--ckpt", "tiny.pt", "--json").out)
    assert facts["links"] == ["base", "l1", "l2", "l3", "l4", "l5"]
    assert facts["joints"] == ["a", "b", "c", "d", "slide"]
    assert (facts["matched"], facts["unmatched"]) == (["a", "b", "c", "d"], ["e"])
    assert facts["limits"]["d"] == [None, None]
    assert facts["velocity_limits"] == {"a": 3.0, "b": 3.0, "c": 3.0, "d": None, "slide": 0.5}
    assert facts["units"]["slide"] == "m"
    assert facts["height"] == pytest.approx(1.58)
    without = json.loads(rnnpb("robot", "--robot", path, "--json").out)
    assert without == {name: facts[name] for name in facts if name not in ("matched", "unmatched")}


def test_an_arm_for_people(rnnpb: Rnnpb) -> None:
    out = rnnpb("robot", write_arm(rnnpb.folder), "--ckpt", "tiny.pt").out.splitlines()
    for line in (
        "name    arm",
        "size    0.3 x 0.3 x 1.58 m (deep, wide, high), at rest",
        "model   4 of its 5 joints are on the robot",
        "lacking e",
        "  b: -2 to 2 rad, at most 3 rad/s, moved by the model",
        "  d: any position, any speed, moved by the model",
        "  slide: 0 to 0.1 m, at most 0.5 m/s, not moved by the model",
    ):
        assert line in out


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("no-meshes-found", "mesh    package://elsewhere/meshes/none.dae: missing: no such file"),
        ("mesh-case-differs", f"mesh    meshes/part.stl: {FIELD}/meshes/Part.STL (found in other"),
        ("mimic-limit", "  j2: mimics j1, 0.5 times its position +0"),
        ("legs-below-base", "base    0.8 m above the floor"),
        ("spaces-in-number", 'warning line 5: <limit lower="-1.0f">; read as -1'),
    ],
)
def test_what_is_not_as_it_should_be_is_said(name: str, line: str, rnnpb: Rnnpb) -> None:
    outcome = rnnpb("robot", FIELD / f"{name}.urdf")
    assert outcome.code == 0
    assert any(one.startswith(line) for one in outcome.out.splitlines()), outcome.out


def test_no_robot_is_one_line(rnnpb: Rnnpb) -> None:
    assert "no robot 'nobody'" in rnnpb.refuses("robot", "nobody")
    (rnnpb.folder / "bad.urdf").write_text("<robot>")
    assert "it ends within <robot>" in rnnpb.refuses("robot", "bad.urdf")
    assert "no-such.pt" in rnnpb.refuses("robot", "--ckpt", "no-such.pt")
