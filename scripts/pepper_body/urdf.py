"""Write joints and visuals as a URDF."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from dataclasses import dataclass

from .joints import Joint, Vector


@dataclass(frozen=True)
class Visual:
    """A mesh file on a link, beside the URDF; mirrored in y or as it is."""

    link: str
    filename: str
    mirrored: bool = False


def format_urdf(name: str, joints: list[Joint], visuals: list[Visual]) -> str:
    """The URDF as text. Display only: no inertia, no collision shapes."""
    robot = ElementTree.Element("robot", name=name)
    robot.append(ElementTree.Comment(" made by scripts/make_pepper_body.py; not for dynamics "))
    links = dict.fromkeys(name for joint in joints for name in (joint.parent, joint.child))
    for link in links:
        element = ElementTree.SubElement(robot, "link", name=link)
        for visual in visuals:
            if visual.link == link:
                geometry = ElementTree.SubElement(
                    ElementTree.SubElement(element, "visual"), "geometry"
                )
                mesh = ElementTree.SubElement(geometry, "mesh", filename=visual.filename)
                if visual.mirrored:
                    mesh.set("scale", "1 -1 1")
    for joint in joints:
        _add_joint(robot, joint)
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def _add_joint(robot: ElementTree.Element, joint: Joint) -> None:
    kind = "fixed" if joint.axis is None else "revolute"
    element = ElementTree.SubElement(robot, "joint", name=joint.name, type=kind)
    ElementTree.SubElement(element, "parent", link=joint.parent)
    ElementTree.SubElement(element, "child", link=joint.child)
    ElementTree.SubElement(element, "origin", xyz=_numbers(joint.xyz), rpy=_numbers(joint.rpy))
    if joint.axis is None:
        return
    ElementTree.SubElement(element, "axis", xyz=_numbers(joint.axis))
    ElementTree.SubElement(
        element,
        "limit",
        lower=f"{joint.lower:.9g}",
        upper=f"{joint.upper:.9g}",
        velocity=f"{joint.velocity:.9g}",
        effort=f"{joint.effort:.9g}",
    )
    if joint.mimics:
        ElementTree.SubElement(
            element, "mimic", joint=joint.mimics, multiplier=f"{joint.multiplier:.9g}", offset="0"
        )


def _numbers(values: Vector | Iterable[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)
