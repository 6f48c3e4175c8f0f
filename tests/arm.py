"""A robot that is not Pepper, and what one would record on it; shared by unit and browser tests.

The arm is made of boxes and cylinders, described in one small file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rnnpb_explorer.app.commands.main import main
from rnnpb_explorer.app.page.server import ServerOptions
from rnnpb_explorer.core.motion import Motion, write_motion

# Four joints that a model with the joints a to e moves, and a slide that it does not know.
ARM = """<?xml version="1.0"?>
<robot name="arm">
  <link name="base">
    <visual><origin xyz="0 0 0.05"/><geometry><cylinder radius="0.15" length="0.1"/></geometry>
      <material name="grey"><color rgba="0.4 0.4 0.45 1"/></material></visual>
  </link>
  {links}
  <joint name="a" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 1"/><limit lower="-3.1" upper="3.1" velocity="3" effort="1"/></joint>
  <joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="3" effort="1"/></joint>
  <joint name="c" type="revolute"><parent link="l2"/><child link="l3"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="3" effort="1"/></joint>
  <joint name="d" type="continuous"><parent link="l3"/><child link="l4"/><origin xyz="0 0 0.3"/>
    <axis xyz="1 0 0"/></joint>
  <joint name="slide" type="prismatic"><parent link="l4"/><child link="l5"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.1" velocity="0.5" effort="1"/></joint>
</robot>
"""
_LINK = """<link name="l{n}"><visual><origin xyz="0 0 0.15"/>
    <geometry><box size="{width} {width} 0.26"/></geometry>
    <material name="m{n}"><color rgba="0.9 {green} 0.3 1"/></material></visual></link>"""

ARM_JOINTS = ("a", "b", "c", "d", "slide")


def write_arm(folder: Path) -> Path:
    """`arm.urdf` in a folder."""
    links = "\n  ".join(
        _LINK.format(n=n, width=f"{0.12 - 0.02 * n:.2f}", green=f"{0.2 + 0.1 * n:.1f}")
        for n in range(1, 6)
    )
    path = folder / "arm.urdf"
    path.write_text(ARM.replace("{links}", links), encoding="utf-8")
    return path


RECORDED_JOINTS = ("a", "b", "c", "d", "e")  # the arm has no e
FRAMES = 20


def recording(name: str, phase: float) -> Motion:
    t = np.linspace(0, 2 * np.pi, FRAMES)[:, None]
    positions = 0.5 * np.sin(t + phase + np.arange(len(RECORDED_JOINTS)))
    return Motion(name, RECORDED_JOINTS, positions.astype(np.float32))


def options_for_the_arm(folder: Path, recipes: tuple[str, ...] = ("zero",)) -> ServerOptions:
    """The arm, three recordings, and models that `rnnpb train` made of them."""
    data = folder / "data"
    data.mkdir()
    for index, name in enumerate(("bend", "turn", "wave")):
        write_motion(recording(name, index), data / f"{name}.csv")
    small = ("--epochs", "150", "--hidden-size", "16", "--pb-dim", "2")
    checkpoints = tuple(str(folder / f"{recipe}.pt") for recipe in recipes)
    for recipe, out in zip(recipes, checkpoints, strict=True):
        flags = ("--data", str(data), "--recipe", recipe, *small, "--out", out)
        assert main(["train", *flags]) == 0
    robot = str(write_arm(folder))
    return ServerOptions(checkpoints, port=0, robot=robot, data=str(data))
