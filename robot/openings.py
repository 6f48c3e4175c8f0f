"""Openings: joints that are no angles but shares from 0 (closed) to 1 (open), as of a hand.

A robot description has no word for them. In it, an opening is a joint limited to 0 and 1 that moves
others: its fingers mimic it, each by an angle of its own.
"""

from __future__ import annotations

from functools import cache
from xml.etree import ElementTree

from .pepper import PEPPER_URDF


def openings(urdf: ElementTree.Element) -> frozenset[str]:
    """The names of the openings in a robot description."""
    followed = {mimic.get("joint") for mimic in urdf.iterfind("joint/mimic")}
    return frozenset(
        name
        for joint in urdf.iterfind("joint")
        if joint.get("type") == "revolute"
        and (name := joint.get("name")) in followed
        and name is not None
        and joint.find("mimic") is None
        and (limit := joint.find("limit")) is not None
        and float(limit.get("lower", 0)) == 0
        and float(limit.get("upper", 0)) == 1
    )


@cache
def pepper_limits() -> dict[str, tuple[float, float]]:
    """Lower and upper limits of the shipped Pepper's joints, radians; (0, 1) of an opening."""
    root = ElementTree.parse(PEPPER_URDF).getroot()
    return {
        joint.get("name", ""): (float(limit.get("lower", 0)), float(limit.get("upper", 0)))
        for joint in root.iterfind("joint")
        if joint.get("type") == "revolute" and (limit := joint.find("limit")) is not None
    }


@cache
def pepper_openings() -> frozenset[str]:
    """Those of the shipped Pepper; reading its description for them takes milliseconds."""
    return openings(ElementTree.parse(PEPPER_URDF).getroot())
