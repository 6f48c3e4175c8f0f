"""Skirt, thigh, waist and torso: lofts that meet on cylinders about their joints.

Where two shells meet at a joint, both follow a cylinder (or sphere) about the joint's axis, one
just inside the other, so that they slide past each other at every angle.
"""

from __future__ import annotations

import numpy as np

from .shapes import (
    Array,
    Surface,
    body,
    box,
    cut,
    cylinder,
    fine,
    lathe,
    loft,
    rounded_hull,
    slab,
    sphere,
    surface,
    through,
    turned,
)

KNEE_RADIUS = 0.074  # the skirt's round top, about the knee's axis
HIP_RADIUS = 0.070  # the thigh's lobes, about the axis of the hip's pitch
WAIST_RADIUS = 0.051  # the ball that carries the torso, about the middle of the hip's roll
GAP = 0.003
HIP = 0.268  # height of the hip above the knee
SLOT = ((0.206, 0.010), (0.26, 0.036), (0.30, 0.044), (0.40, 0.050))  # height, half width
ROLL = 0.079  # height of the roll axis above the hip
SHOULDER = np.array([-0.057, 0.14974, 0.22582])


def skirt() -> list[Surface]:
    """From the three wheels up to the knee; the knee's axis is the origin."""
    # height, wheel circles at (a, +-b) ahead and (-c, 0) behind, radius of the circles
    stations = [
        (-0.308, 0.086, 0.148, 0.166, 0.068),
        (-0.316, 0.089, 0.152, 0.169, 0.079),
        (-0.304, 0.091, 0.155, 0.170, 0.087),
        (-0.262, 0.091, 0.155, 0.169, 0.089),
        (-0.228, 0.084, 0.146, 0.158, 0.086),
        (-0.196, 0.064, 0.118, 0.138, 0.079),
        (-0.160, 0.034, 0.084, 0.112, 0.068),
        (-0.120, 0.016, 0.062, 0.080, 0.060),
        (-0.070, 0.008, 0.050, 0.046, 0.058),
        (-0.020, 0.003, 0.044, 0.014, 0.056),
        (0.030, 0.000, 0.043, 0.000, 0.054),
        (0.090, 0.000, 0.042, 0.000, 0.052),
    ]
    rings = []
    for z, a, b, c, r in through(stations, fine(30)):
        curve = rounded_hull([(a, b, r), (a, -b, r), (-c, 0, r)])
        height = z + _arch(curve, z)
        rings.append(np.column_stack([curve, height]))
    solid = loft(rings)
    above = cut(box((0.4, 0.4, 0.2), (0, 0, 0.1)), cylinder("y", KNEE_RADIUS, 0.3))
    shell = surface(cut(solid, above), "white", crease=30)
    parts = shell.with_panels((_dome, "grey"), (_front_seam, "light"))
    # of the wheels only what is seen below the rim
    slope = np.linspace(0, 1.0, 5)
    profile = [(0.066 * np.sin(a), -0.268 - 0.066 * np.cos(a)) for a in slope]
    for x, y in ((0.09, 0.155), (0.09, -0.155), (-0.17, 0.0)):
        wheel = lathe(profile, sides=20).apply_translation((x, y, 0))
        parts.append(surface(wheel, "dark"))
    return parts


def _dome(p: Array) -> Array:
    """Negative on the round top that the thigh slides on."""
    radius = np.hypot(p[:, 0], p[:, 2])
    return np.where(p[:, 2] > 0.02, KNEE_RADIUS - 4e-4 - radius, 1.0)


def _arch(curve: Array, z: float) -> Array:
    """The lower rim rises a little between the wheels."""
    angle = np.arctan2(curve[:, 1], curve[:, 0])
    between = 0.5 + 0.5 * np.cos(3 * angle)  # 1 ahead and on both sides behind, 0 at the wheels
    return 0.012 * between**2 * np.clip((-0.2 - z) / 0.1, 0, 1)


def _front_seam(p: Array) -> Array:
    """Negative on a line that runs up the front from an arch between the front wheels."""
    y, z = np.abs(p[:, 1]), p[:, 2]
    arch = z - (-0.172 - 0.10 * (y / 0.17) ** 2.4)
    return np.where(p[:, 0] > 0, np.minimum(y - 0.0035, np.maximum(arch, y - 0.172)), 1.0)


def thigh() -> list[Surface]:
    """From the knee to the hip's two lobes; the knee's axis is the origin."""
    stations = [
        # z, ahead, behind, side, center
        (0.016, 0.058, 0.046, 0.086, 0.004),
        (0.019, 0.066, 0.054, 0.095, 0.004),
        (0.026, 0.069, 0.057, 0.099, 0.004),
        (0.060, 0.072, 0.059, 0.104, 0.004),
        (0.120, 0.079, 0.062, 0.110, 0.005),
        (0.180, 0.083, 0.068, 0.115, 0.006),
        (0.225, 0.079, 0.073, 0.114, 0.004),
        (0.268, 0.069, 0.070, 0.106, 0.000),
        (0.296, 0.0625, 0.0630, 0.093, 0.000),
        (0.314, 0.0495, 0.0500, 0.077, 0.000),
        (0.326, 0.030, 0.030, 0.056, 0.000),
        (0.330, 0.008, 0.008, 0.030, 0.000),
    ]
    solid = body(stations, rings=32, sides=48, power=2.2)
    slot = loft(
        [
            np.array([(x, y * w, z) for x, y in ((0.2, -1), (0.2, 1), (-0.2, 1), (-0.2, -1))])
            for z, w in SLOT
        ]
    )
    knee = cylinder("y", KNEE_RADIUS + GAP, 0.3)
    shell = surface(cut(solid, slot, knee), "white", crease=30)
    return shell.with_panels((_slot, "dark"), (_thigh_seam, "light"))


def _slot(p: Array) -> Array:
    """Negative on the walls of the slot."""
    heights, widths = np.array(SLOT).T
    return np.abs(p[:, 1]) - np.interp(p[:, 2] + 2e-4, heights, widths + 3e-4, left=-1.0)


def _thigh_seam(p: Array) -> Array:
    """Negative on a line up the front."""
    return np.where(p[:, 0] > 0, np.abs(p[:, 1]) - 0.0035, 1.0)


def pelvis() -> list[Surface]:
    """The waist between thigh and torso; the axis of the hip's pitch is the origin."""
    barrel = cylinder("y", HIP_RADIUS - 0.004, 0.040, sections=72)
    stations = [
        (-0.02, 0.048, 0.048, 0.037, 0.0),
        (0.020, 0.050, 0.050, 0.037, 0.0),
        (0.040, 0.046, 0.046, 0.037, 0.0),
        (0.065, 0.045, 0.045, 0.043, 0.0),
    ]
    column = body(stations, rings=12, sides=40, power=2.4)
    ball = sphere(WAIST_RADIUS, (0, 0, ROLL), 3)
    return [surface(s, "grey", crease=30) for s in (barrel, column, ball)]


def torso() -> list[Surface]:
    """From the waist to the neck, with the tablet; the axis of the hip's roll is the origin."""
    stations = [
        # z, ahead, behind, side, center
        (0.002, 0.0525, 0.0515, 0.0525, 0.000),
        (0.006, 0.0560, 0.0545, 0.0570, 0.000),
        (0.034, 0.063, 0.057, 0.071, 0.000),
        (0.080, 0.074, 0.064, 0.086, 0.000),
        (0.130, 0.086, 0.080, 0.098, -0.003),
        (0.180, 0.094, 0.094, 0.107, -0.014),
        (0.220, 0.095, 0.101, 0.115, -0.026),
        (0.248, 0.088, 0.096, 0.1175, -0.038),
        (0.268, 0.072, 0.083, 0.106, -0.041),
        (0.281, 0.054, 0.066, 0.084, -0.040),
        (0.290, 0.040, 0.049, 0.058, -0.039),
        (0.296, 0.032, 0.036, 0.040, -0.038),
        (0.298, 0.026, 0.026, 0.026, -0.038),
    ]
    solid = body(stations, rings=36, sides=52, power=2.25)
    sockets = [sphere(0.0475, SHOULDER * (1, s, 1), 3) for s in (1, -1)]
    waist = sphere(WAIST_RADIUS + 0.002, (0, 0, 0), 3)
    shell = surface(cut(solid, waist, *sockets), "white", crease=30)
    parts = shell.with_panels((_socket, "grey"), (_side_panel, "light"))
    collar = lathe(
        [(0.028, 0.284), (0.0375, 0.286), (0.0385, 0.294), (0.036, 0.299), (0.028, 0.299)],
        sides=40,
    )
    parts.append(surface(collar.apply_translation((-0.038, 0, 0)), "grey", crease=50))
    return parts + tablet()


def _socket(p: Array) -> Array:
    """Negative on the round sockets of the shoulders and of the waist."""
    at = np.column_stack([p[:, 0], np.abs(p[:, 1]), p[:, 2]]) - SHOULDER
    shoulder = np.linalg.norm(at, axis=1) - 0.0478
    waist = np.linalg.norm(p, axis=1) - (WAIST_RADIUS + 0.0022)
    return np.minimum(shoulder, waist)


def _side_panel(p: Array) -> Array:
    """Negative under the arms: the panel between the front and the back shell."""
    x, y, z = p[:, 0], np.abs(p[:, 1]), p[:, 2]
    middle = -0.030 - 0.10 * (z - 0.1)
    width = 0.008 + 0.12 * np.clip(z - 0.03, 0, 0.17)
    return np.where((y > 0.03) & (z < 0.235), np.abs(x - middle) - width, 1.0)


def tablet() -> list[Surface]:
    """The screen on the chest, leaning back."""
    place = turned("y", -32, (0.106, 0, 0.193))

    frame = slab(0.110, 0.079, 0.016, bevel=0.004, power=9.0).apply_translation((-0.008, 0, 0))
    screen = slab(0.095, 0.063, 0.0012, bevel=0.0003, power=14.0)
    screen.apply_translation((0.0076, 0, 0))
    arm = box((0.05, 0.09, 0.06), (-0.03, 0, -0.005))
    painted = ((frame, "white"), (screen, "screen"), (arm, "grey"))
    return [surface(mesh, color, crease=30).moved(place) for mesh, color in painted]
