"""Neck and head: a wide round skull, large eyes, ears with speaker rings."""

from __future__ import annotations

import numpy as np

from .shapes import (
    ALONG,
    MIRROR_Y,
    Array,
    Surface,
    body,
    cut,
    lathe,
    loft,
    sphere,
    surface,
    turned,
)

EYE = np.array([0.0915, 0.0415, 0.114])  # on the face, left
EYE_TURN = 24.0  # degrees that an eye looks outwards
EYE_TILT = 3.0  # degrees that it looks up
LEDS = 8
EYE_SIZE = 1.12  # of all its parts
BOWL = 0.030  # radius of what is cut out of the head for an eye


def neck() -> list[Surface]:
    """A column; the axis of the head's pitch is the origin."""
    profile = [
        (0.001, -0.036),
        (0.030, -0.034),
        (0.030, -0.010),
        (0.032, 0.006),
        (0.033, 0.018),
        (0.026, 0.034),
        (0.001, 0.040),
    ]
    return [surface(lathe(profile, rings=12, sides=36), "grey")]


def head() -> list[Surface]:
    """Skull with eyes and ears; the axis of the head's pitch is the origin."""
    stations = [
        # z, ahead, behind, side, center
        (0.0080, 0.006, 0.006, 0.006, 0.030),
        (0.0100, 0.022, 0.022, 0.024, 0.030),
        (0.0200, 0.046, 0.040, 0.044, 0.028),
        (0.0400, 0.071, 0.061, 0.064, 0.022),
        (0.0650, 0.088, 0.080, 0.083, 0.014),
        (0.0900, 0.097, 0.092, 0.096, 0.007),
        (0.1150, 0.099, 0.098, 0.102, 0.003),
        (0.1400, 0.098, 0.098, 0.101, 0.001),
        (0.1650, 0.090, 0.090, 0.091, 0.001),
        (0.1880, 0.075, 0.075, 0.074, 0.001),
        (0.2050, 0.054, 0.054, 0.052, 0.001),
        (0.2155, 0.030, 0.030, 0.028, 0.001),
        (0.2190, 0.004, 0.004, 0.004, 0.001),
    ]
    solid = body(stations, rings=30, sides=52, power=2.15)
    holes = [sphere(BOWL, _bowl_center(side)) for side in (1, -1)]
    shell = surface(cut(solid, *holes), "white", crease=30)
    parts = shell.with_panels((_cap, "light"), (_eye_hole, "dark"))
    for side in (1, -1):
        parts += eye(side)
        parts += [s if side == 1 else s.moved(MIRROR_Y) for s in ear()]
    return parts + mouth() + forehead()


def _cap(p: Array) -> Array:
    """Negative on the panel that runs over the top and down the back of the head."""
    x, y, z = p[:, 0], p[:, 1], p[:, 2]
    width = 0.066 - 0.25 * np.clip(0.11 - z, 0, 0.06)
    ahead = np.clip(x + 0.02, 0, None) / 0.082
    bottom = (0.062 - z) / 0.03
    return np.maximum(np.sqrt((y / width) ** 2 + ahead**2) - 1, bottom)


def _eye_place(side: int) -> Array:
    """(4, 4): x out of the eye, z up."""
    return turned("z", side * EYE_TURN, EYE * (1, side, 1)) @ turned("y", -EYE_TILT)


def _bowl_center(side: int) -> Array:
    place = _eye_place(side)
    center: Array = place[:3, 3] + 0.013 * place[:3, 0]
    return center


def _eye_hole(p: Array) -> Array:
    """Negative on the bowls that the eyes lie in."""
    left, right = (np.linalg.norm(p - _bowl_center(side), axis=1) for side in (1, -1))
    return np.minimum(left, right) - BOWL - 2e-4


def eye(side: int) -> list[Surface]:
    """A glossy black eyeball with a small light in it; the LED ring is a link of its own."""
    ball = [
        (0.0001, -0.012),
        (0.0165, -0.012),
        (0.0165, 0.0005),
        (0.0135, 0.0045),
        (0.008, 0.0068),
        (0.0001, 0.0075),
    ]
    bed = [(0.015, -0.008), (0.0236, -0.008), (0.0236, 0.0008), (0.0165, 0.0018), (0.015, 0.0)]
    rim = [
        (0.0235, -0.012),
        (0.0255, -0.012),
        (0.0262, 0.0005),
        (0.0250, 0.0016),
        (0.0236, 0.0008),
        (0.0225, -0.004),
    ]
    parts = [
        (lathe(ball, rings=10, sides=28), "eye"),
        (lathe(bed), "dark"),
        (lathe(rim), "white"),
    ]
    place = _eye_place(side)
    glint = sphere(0.0034, (0.0053, 0.0055, 0.0070), detail=1)
    surfaces = [surface(glint, "glint").moved(place)]
    for mesh, color in parts:
        mesh.apply_scale(EYE_SIZE).apply_transform(ALONG["x"])
        surfaces.append(surface(mesh, color).moved(place))
    return surfaces


def eye_led_place(side: int, index: int) -> Array:
    """(4, 4) of a segment of the ring: LED 0 is the first from the top towards the nose."""
    return _eye_place(side) @ turned("x", side * 360 / LEDS * (index + 0.5))


def eye_led() -> list[Surface]:
    """One segment of an LED ring, at the top of the eye."""
    half = np.radians(180 / LEDS - 2.2)
    t = np.linspace(-half, half, 7)
    section = [
        (0.0168, -0.002),
        (0.0168, 0.0022),
        (0.0178, 0.0032),
        (0.0222, 0.0016),
        (0.0228, -0.002),
    ]
    rings = [np.array([(x, -r * np.sin(a), r * np.cos(a)) for r, x in section[::-1]]) for a in t]
    return [surface(loft(rings).apply_scale(EYE_SIZE), "led", crease=30)]


def ear() -> list[Surface]:
    """The speaker of the left ear: a ring, and grooves around a hub."""
    ring = lathe(
        [
            (0.028, -0.010),
            (0.0375, -0.010),
            (0.0385, 0.004),
            (0.0365, 0.0085),
            (0.0330, 0.0095),
            (0.0305, 0.0075),
            (0.0300, 0.002),
            (0.028, 0.0),
        ],
        sides=40,
    )
    dish = [(0.0305, -0.004), (0.0305, 0.0045)]
    for r in (0.027, 0.0215, 0.016):
        dish += [
            (r + 0.0018, 0.0062),
            (r + 0.0010, 0.0042),
            (r - 0.0010, 0.0042),
            (r - 0.0018, 0.0062),
        ]
    dish += [(0.011, 0.0062), (0.0095, 0.0080), (0.005, 0.0088), (0.0001, 0.0090)]
    place = ALONG["y"].copy()
    place[:3, 3] = (-0.006, 0.0985, 0.116)
    return [
        surface(ring, "white", crease=35).moved(place),
        surface(lathe(dish, sides=40), "grey", crease=35).moved(place),
    ]


def mouth() -> list[Surface]:
    """A small smiling slit."""
    t = np.linspace(-1, 1, 15)
    bend = np.column_stack([0.0968 - 0.0022 * t**2, 0.0135 * t, 0.0490 + 0.0038 * t**2])
    angle = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    rings = []
    for point, s in zip(bend, t, strict=True):
        r = 0.0016 * np.sqrt(max(1 - s**2, 0.02))
        rings.append(point + np.column_stack([r * np.cos(angle), 0 * angle, -r * np.sin(angle)]))
    return [surface(loft(rings), "dark", crease=60)]


def forehead() -> list[Surface]:
    """The lens of the camera above the eyes."""
    lens = lathe(
        [(0.0001, -0.004), (0.0048, -0.004), (0.0048, 0.0008), (0.003, 0.0016), (0.0001, 0.0018)],
        sides=24,
    )
    place = turned("y", -32, (0.0905, 0, 0.1655)) @ ALONG["x"]
    return [surface(lens, "eye", crease=50).moved(place)]
