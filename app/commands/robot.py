"""`rnnpb robot`: what a robot description gives."""

from __future__ import annotations

from json import dumps
from math import isfinite
from typing import TYPE_CHECKING, Any

from .flags import Checkpoint, Robot

if TYPE_CHECKING:
    from ...robot.description import JointMatch
    from ...robot.description import Robot as Description
    from ...robot.tree import MovingFrame


def run(robot: Robot = "pepper", *, ckpt: Checkpoint | None = None, json: bool = False) -> None:
    """Print what is in a robot description, and what was found of it.

    Args:
        ckpt: a checkpoint whose joints are looked for on the robot
        json: print one JSON object
    """
    from ...core.checkpoint import load_checkpoint
    from ...robot.description import load_robot, match_joints

    description = load_robot(robot)
    match = None
    if ckpt is not None:
        match = match_joints(description, load_checkpoint(ckpt).info.joints)
    facts = describe(description, match)
    if json:
        print(dumps(facts, ensure_ascii=False, indent=2, allow_nan=False))
    else:
        print("\n".join(lines(facts)))


def describe(robot: Description, match: JointMatch | None) -> dict[str, Any]:
    """The fields of `rnnpb robot --json`; metres and radians, null where there is no limit."""
    from ...robot.kinematics import extent

    low, high = extent(robot)
    frames = robot.tree.frames
    facts: dict[str, Any] = {
        "name": robot.name,
        "links": list(robot.tree.links),
        "joints": list(robot.joints),
        "limits": {joint: list(map(_number, robot.limits[joint])) for joint in robot.joints},
        "velocity_limits": {joint: _number(robot.velocity_limits[joint]) for joint in robot.joints},
        "units": {one.joint: _unit(robot, one) for one in frames if one.joint in robot.limits},
        "mimics": {
            one.joint: {"joint": one.driver, "multiplier": one.multiplier, "offset": one.offset}
            for one in frames
            if one.joint not in robot.limits
        },
        "height": float(high[2] - low[2]),
        "size": (high - low).tolist(),
        "below_base": max(0.0, -float(low[2])),
        "meshes": [
            {
                "name": mesh.name,
                "link": mesh.link,
                "file": None if mesh.file is None else str(mesh.file),
                "remark": mesh.remark,
                "problem": mesh.problem,
            }
            for mesh in robot.meshes
        ],
        "missing_meshes": list(robot.missing_meshes),
        "warnings": list(robot.warnings),
    }
    if match is not None:
        facts |= {"matched": list(match.columns), "unmatched": list(match.missing)}
    return facts


def lines(facts: dict[str, Any]) -> list[str]:
    """The same for people."""
    x, y, z = facts["size"]
    found = len(facts["meshes"]) - len(facts["missing_meshes"])
    shown = {
        "name": facts["name"],
        "size": f"{x:.3g} x {y:.3g} x {z:.3g} m (deep, wide, high), at rest",
        "links": len(facts["links"]),
        "meshes": f"{found} of {len(facts['meshes'])} found",
    }
    if facts["below_base"] > 0.005:
        shown["base"] = f"{facts['below_base']:.3g} m above the floor"
    if "matched" in facts:
        joints = len(facts["matched"]) + len(facts["unmatched"])
        shown["model"] = f"{len(facts['matched'])} of its {joints} joints are on the robot"
        if facts["unmatched"]:
            shown["lacking"] = ", ".join(facts["unmatched"])
    out = [f"{name:8}{value}" for name, value in shown.items()]
    out.append(f"joints  {len(facts['joints'])}")
    out += [f"  {joint}: {_limits(facts, joint)}" for joint in facts["joints"]]
    for joint, mimic in facts["mimics"].items():
        leader = mimic["joint"] or "nothing"
        factor, offset = mimic["multiplier"], mimic["offset"]
        out.append(f"  {joint}: mimics {leader}, {factor:g} times its position {offset:+g}")
    for mesh in facts["meshes"]:
        remark = f" ({mesh['remark']})" if mesh["remark"] else ""
        how = f"missing: {mesh['problem']}" if mesh["problem"] else f"{mesh['file']}{remark}"
        out.append(f"mesh    {mesh['name']}: {how}")
    return out + [f"warning {line}" for line in facts["warnings"]]


def _limits(facts: dict[str, Any], joint: str) -> str:
    unit = facts["units"][joint]
    lower, upper = facts["limits"][joint]
    speed = facts["velocity_limits"][joint]
    position = "any position"
    if lower is not None or upper is not None:
        position = f"{_shown(lower)} to {_shown(upper)} {unit}"
    words = [position, "any speed" if speed is None else f"at most {speed:g} {unit}/s"]
    if "matched" in facts:
        words.append(
            "moved by the model" if joint in facts["matched"] else "not moved by the model"
        )
    return ", ".join(words)


def _unit(robot: Description, frame: MovingFrame) -> str:
    return "m" if frame.prismatic else "openings" if frame.joint in robot.openings else "rad"


def _shown(limit: float | None) -> str:
    return "no limit" if limit is None else f"{limit:g}"


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
