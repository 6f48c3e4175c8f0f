"""The left arm and hand: sleeves that cup the balls of the joints; the right mirrors it."""

from __future__ import annotations

import numpy as np

from .joints import PHALANX, THUMB_PHALANX
from .shapes import ALONG, Array, Surface, body, cut, cylinder, lathe, sphere, surface, turned

ELBOW = 0.1812  # from shoulder to elbow, along x
ELBOW_SIDE = 0.015
BALL = 0.0325  # the elbow's
GAP = 0.0015


def shoulder() -> list[Surface]:
    """What the torso's socket holds; turns about y."""
    profile = [
        (0.001, -0.042),
        (0.026, -0.042),
        (0.034, -0.036),
        (0.0385, -0.022),
        (0.040, 0.0),
        (0.036, 0.02),
        (0.02, 0.034),
        (0.001, 0.036),
    ]
    return [surface(lathe(profile, rings=14, sides=32), "grey").moved(ALONG["y"])]


def upper_arm() -> list[Surface]:
    """Sleeve with a round cap over the shoulder; x runs to the elbow, turned up by 9 degrees."""
    stations = [
        # x, then ahead/behind = +y/-y, side = z, center = y
        (-0.0435, 0.002, 0.002, 0.002, 0.002),
        (-0.040, 0.017, 0.016, 0.017, 0.003),
        (-0.028, 0.036, 0.030, 0.034, 0.003),
        (-0.010, 0.045, 0.037, 0.042, 0.004),
        (0.015, 0.046, 0.036, 0.0435, 0.006),
        (0.050, 0.042, 0.033, 0.041, 0.010),
        (0.100, 0.0375, 0.0325, 0.0385, 0.014),
        (0.138, 0.0345, 0.0335, 0.0355, 0.015),
        (0.150, 0.0332, 0.0327, 0.0342, 0.015),
        (0.1545, 0.0305, 0.0305, 0.0315, 0.015),
        (0.157, 0.0250, 0.0250, 0.0250, 0.015),
    ]
    solid = body(stations, rings=26, sides=36).apply_transform(ALONG["x"])
    ball = sphere(BALL + GAP, (ELBOW, ELBOW_SIDE, 0), 3)
    # the cap is open towards the torso, where the shoulder comes in
    mouth = cylinder("y", 0.041, 0.03, (0, -0.052, 0))
    return [surface(cut(solid, ball, mouth), "white", crease=32)]


def elbow() -> list[Surface]:
    """The ball between the sleeves, and the ring that turns it."""
    ring = lathe(
        [(0.001, -0.034), (0.026, -0.034), (0.0285, -0.028), (0.0285, -0.02), (0.001, -0.018)],
        sides=40,
    )
    return [
        surface(sphere(BALL, detail=3), "grey"),
        surface(ring.apply_transform(ALONG["x"]), "grey", crease=40),
    ]


def forearm() -> list[Surface]:
    """Sleeve from the elbow to the wrist's seam, open on the inner side where the arm bends."""
    stations = [
        (0.000, 0.030, 0.030, 0.030, 0.0),
        (0.004, 0.0345, 0.0345, 0.0345, 0.0),
        (0.020, 0.0355, 0.0355, 0.0355, 0.0),
        (0.050, 0.0350, 0.0345, 0.0350, 0.0),
        (0.080, 0.0315, 0.0315, 0.0315, 0.0),
        (0.0845, 0.0305, 0.0305, 0.0305, 0.0),
        (0.0855, 0.0270, 0.0270, 0.0270, 0.0),
    ]
    solid = body(stations, rings=18, sides=36).apply_transform(ALONG["x"])
    ball = sphere(BALL + GAP, detail=3)
    # cut slantwise: the elbow bends towards -y
    slant = cylinder("x", 0.08, 0.05, (-0.05, 0, 0)).apply_transform(turned("z", 38, (0.020, 0, 0)))
    return [surface(cut(solid, ball, slant), "white", crease=32)]


def hand() -> list[Surface]:
    """Cuff and palm; the palm faces down, fingers ahead. The wrist's axis is x."""
    cuff = lathe(
        [(0.001, -0.066), (0.0255, -0.066), (0.0255, -0.061), (0.001, -0.060)], sides=40
    ).apply_transform(ALONG["x"])
    stations = [
        # x, +y, -y, z, center y
        (-0.0625, 0.026, 0.026, 0.026, 0.0),
        (-0.0615, 0.0295, 0.0295, 0.0295, 0.0),
        (-0.050, 0.0300, 0.0300, 0.0300, 0.0),
        (-0.020, 0.0265, 0.0265, 0.0270, 0.0),
        (0.000, 0.0270, 0.0270, 0.0255, 0.0),
        (0.025, 0.0335, 0.0335, 0.0235, 0.001),
        (0.050, 0.0385, 0.0385, 0.0205, 0.002),
        (0.070, 0.0400, 0.0385, 0.0160, 0.002),
        (0.082, 0.0370, 0.0350, 0.0115, 0.002),
        (0.088, 0.0300, 0.0300, 0.0070, 0.002),
        (0.090, 0.0200, 0.0200, 0.0030, 0.002),
    ]
    palm = body(stations, rings=26, sides=32, power=2.2).apply_transform(ALONG["x"])
    thumb = sphere(0.0165, (0.042, -0.027, -0.012), 2)
    shell = surface(palm, "white", crease=40)
    return [surface(cuff, "grey"), *shell.painted(_palm, "light"), surface(thumb, "white")]


def _palm(p: Array) -> Array:
    """Negative on the soft inside of the hand."""
    spot = ((p[:, 0] - 0.052) / 0.038) ** 2 + ((p[:, 1] - 0.002) / 0.034) ** 2 - 1
    return np.where(p[:, 2] < 0, spot, 1.0)


def phalanx(thumb: bool, last: bool) -> list[Surface]:
    """A finger's piece along x, bent about z; the joint is a grey ball."""
    length = THUMB_PHALANX if thumb else PHALANX
    r = 0.0078 if thumb else 0.0074
    end = length * (0.62 if last else 1.0) + (r if last else 0.0)
    # x, radius: from the joint to a round tip, or to the next joint
    profile = [(0.0, 0.0052), (0.0022, r * 0.95), (end * 0.45, r)]
    if last:
        profile += [(end - 0.0058, r * 0.87), (end - 0.0016, r * 0.5), (end, 0.001)]
    else:
        profile += [(end - 0.0035, r * 0.87), (end - 0.0016, r * 0.81), (end, 0.0045)]
    stations = [(x, radius, radius, 1.04 * radius, 0.0) for x, radius in profile]
    piece = body(stations, rings=8, sides=10).apply_transform(ALONG["x"])
    return [surface(piece, "light"), surface(sphere(0.0066, detail=1), "grey")]
