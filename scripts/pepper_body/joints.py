"""Pepper's kinematics: origins, axes, limits and speeds as published for the robot.

Facts of the machine, in metres and radians, restated in a structure of our own. Each link's frame
is where its joint turns; x points ahead, y to the robot's left, z up (along an arm: x outward).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import trimesh

from .head import LEDS, eye_led_place

Vector = tuple[float, float, float]
X: Vector = (1, 0, 0)
Y: Vector = (0, 1, 0)
Z: Vector = (0, 0, 1)
BACK: Vector = (-1, 0, 0)  # the three joints below the torso are counted from the torso downwards
RIGHT: Vector = (0, -1, 0)


@dataclass(frozen=True)
class Joint:
    """One joint of the URDF; fixed when it has no axis."""

    name: str
    parent: str
    child: str
    xyz: Vector = (0, 0, 0)
    rpy: Vector = (0, 0, 0)
    axis: Vector | None = None
    lower: float = 0
    upper: float = 0
    velocity: float = 0
    effort: float = 0
    mimics: str | None = None
    multiplier: float = 1


# How far the fingers of an open hand have turned at each of their joints.
FINGER_TURN = 0.872665
FINGER_CURL = -1.0472  # of a closed hand at the second and third joint
# Name, number of phalanges, origin on the hand and orientation there, of the left hand.
FINGERS: tuple[tuple[str, int, Vector, Vector], ...] = (
    ("Finger1", 3, (0.0821, -0.0268, 0.004), (1.74402, 1.04064, -0.0334335)),
    ("Finger2", 3, (0.0873, -0.0073, 0.006), (1.5708, 1.0472, -0.061086)),
    ("Finger3", 3, (0.0833, 0.0123, 0.004), (1.46636, 1.04483, -0.029314)),
    ("Finger4", 3, (0.074, 0.0309, 0), (1.39757, 1.04064, 0.0683394)),
    ("Thumb", 2, (0.0482, -0.0357, -0.0199), (-1.95836, 0.60626, 0.533978)),
)
PHALANX = 0.018  # from joint to joint
THUMB_PHALANX = 0.022


def pepper_joints() -> list[Joint]:
    """All joints, each after the one that carries it."""
    trunk = [
        Joint("base", "base_footprint", "skirt", (0, 0, 0.334)),
        Joint("KneePitch", "skirt", "thigh", (0, 0, 0), (0, 0, 0), RIGHT,
              -0.514872, 0.514872, 2.93276, 27.702),
        Joint("HipPitch", "thigh", "pelvis", (0, 0, 0.268), (0, 0, 0), RIGHT,
              -1.03847, 1.03847, 2.93276, 19.787),
        Joint("HipRoll", "pelvis", "torso", (0, 0, 0.079), (0, 0, 0), BACK,
              -0.514872, 0.514872, 2.27032, 10.1884),
        Joint("HeadYaw", "torso", "neck", (-0.038, 0, 0.3089), (0, 0, 0), Z,
              -2.08567, 2.08567, 7.33998, 5.428),
        Joint("HeadPitch", "neck", "head", (0, 0, 0), (0, 0, 0), Y,
              -0.706858, 0.43, 9.22756, 2.666),
    ]  # fmt: skip
    return [*trunk, *_arm("L"), *_arm("R"), *_eye_leds()]


def _eye_leds() -> list[Joint]:
    """Fixed joints of the 8 LED segments around each eye, so that a viewer can colour them."""
    joints = []
    for side, sign in (("l", 1), ("r", -1)):
        for index in range(LEDS):
            place = eye_led_place(sign, index)
            rpy = trimesh.transformations.euler_from_matrix(place)
            link = f"{side}_eye_led_{index}"
            x, y, z = (round(float(v), 6) for v in place[:3, 3])
            roll, pitch, yaw = (round(float(v), 6) for v in rpy)
            joints.append(Joint(link, "head", link, (x, y, z), (roll, pitch, yaw)))
    return joints


def _arm(side: str) -> list[Joint]:
    """The joints of an arm; the right one is the mirror image of the left."""
    left = side == "L"
    sign = 1 if left else -1
    link = side.lower() + "_"

    def span(low: float, high: float) -> tuple[float, float]:
        return (low, high) if left else (-high, -low)

    joints = [
        Joint(f"{side}ShoulderPitch", "torso", link + "shoulder",
              (-0.057, sign * 0.14974, 0.22582), (0, 0, 0), Y,
              -2.08567, 2.08567, 7.33998, 5.428),
        Joint(f"{side}ShoulderRoll", link + "shoulder", link + "upper_arm",
              (0, 0, 0), (0, 0, 0), Z, *span(0.00872665, 1.56207), 9.22756, 2.666),
        Joint(f"{side}ElbowYaw", link + "upper_arm", link + "elbow",
              (0.1812, sign * 0.015, 0.00013), (0, -0.157079, 0), X,
              -2.08567, 2.08567, 7.33998, 5.428),
        Joint(f"{side}ElbowRoll", link + "elbow", link + "forearm",
              (0, 0, 0), (0, 0, 0), Z, *span(-1.56207, -0.00872665), 9.22756, 2.666),
        Joint(f"{side}WristYaw", link + "forearm", link + "hand",
              (0.15, 0, 0), (0, 0, 0), X, -1.82387, 1.82387, 17.3835, 0.2014),
        # Not a turn: the opening of the hand, from 0 to 1, which the fingers mimic.
        Joint(f"{side}Hand", link + "hand", link + "grip",
              (0.025, 0, 0), (0, 0, 0), X, 0, 1, 12.56, 0.144),
    ]  # fmt: skip
    for name, phalanges, origin, orientation in FINGERS:
        joints += _finger(
            side, name, phalanges, _mirrored(origin, left), _turned(orientation, left)
        )
    return joints


def _finger(side: str, name: str, phalanges: int, xyz: Vector, rpy: Vector) -> list[Joint]:
    link = f"{side.lower()}_{name.lower()}_"
    length = THUMB_PHALANX if name == "Thumb" else PHALANX
    joints = []
    for number in range(1, phalanges + 1):
        parent = f"{side.lower()}_hand" if number == 1 else f"{link}{number - 1}"
        joints.append(
            Joint(
                f"{side}{name}{number}", parent, f"{link}{number}", xyz, rpy, Z,
                0, FINGER_TURN, 12.56, 0.144, mimics=f"{side}Hand", multiplier=FINGER_TURN,
            )
        )  # fmt: skip
        xyz, rpy = (length, 0, 0), (0, 0, FINGER_CURL)
    return joints


def _mirrored(xyz: Vector, left: bool) -> Vector:
    return xyz if left else (xyz[0], -xyz[1], xyz[2])


def _turned(rpy: Vector, left: bool) -> Vector:
    """A finger's frame as in a mirror, its axis still the one that opens it when positive."""
    roll, pitch, yaw = rpy
    return rpy if left else (math.copysign(math.pi, roll) - roll, pitch, -yaw)
