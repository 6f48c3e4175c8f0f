"""Robots of very different sizes and bases that move with Pepper's joints; boxes alone."""

from __future__ import annotations

from pathlib import Path

_LIMIT = '<limit lower="-2" upper="2" velocity="8" effort="1"/>'


def _link(name: str, size: tuple[float, float, float], at: tuple[float, float, float]) -> str:
    shade = 0.3 + 0.6 * (sum(map(ord, name)) % 7) / 6
    return (
        f'<link name="{name}"><visual><origin xyz="{at[0]:g} {at[1]:g} {at[2]:g}"/><geometry>'
        f'<box size="{size[0]:g} {size[1]:g} {size[2]:g}"/></geometry>'
        f'<material name="{name}"><color rgba="{shade:.2f} 0.55 0.6 1"/></material></visual></link>'
    )


def _joint(name: str, links: str, at: tuple[float, float, float], axis: str) -> str:
    parent, child = links.split()
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at[0]:g} {at[1]:g} {at[2]:g}"/><axis xyz="{axis}"/>{_LIMIT}</joint>'
    )


def _write(path: Path, parts: list[str]) -> Path:
    path.write_text(f'<robot name="{path.stem}">{"".join(parts)}</robot>', encoding="utf-8")
    return path


def write_desk_arm(folder: Path) -> Path:
    """An arm 10 cm high that stands on its base."""
    return _write(
        folder / "desk_arm.urdf",
        [
            _link("foot", (0.03, 0.03, 0.01), (0, 0, 0.005)),
            _link("upper", (0.01, 0.01, 0.04), (0, 0, 0.02)),
            _link("lower", (0.008, 0.008, 0.03), (0, 0, 0.015)),
            _link("tip", (0.012, 0.012, 0.02), (0, 0, 0.01)),
            _joint("LShoulderPitch", "foot upper", (0, 0, 0.01), "0 1 0"),
            _joint("LElbowRoll", "upper lower", (0, 0, 0.04), "1 0 0"),
            _joint("HeadYaw", "lower tip", (0, 0, 0.03), "0 0 1"),
        ],
    )


def write_giant(folder: Path) -> Path:
    """A biped 4 m high whose base is its pelvis, with the legs below it."""
    parts = [
        _link("pelvis", (0.4, 0.8, 0.3), (0, 0, 0)),
        _link("trunk", (0.5, 1.0, 1.1), (0, 0, 0.6)),
        _link("head", (0.4, 0.4, 0.45), (0, 0, 0.3)),
        _joint("HipRoll", "pelvis trunk", (0, 0, 0.15), "1 0 0"),
        _joint("HeadYaw", "trunk head", (0, 0, 1.15), "0 0 1"),
    ]
    for side, y in (("L", 1), ("R", -1)):
        parts += [
            _link(f"{side}leg", (0.3, 0.3, 1.85), (0, 0, -0.925)),
            _link(f"{side}foot", (0.6, 0.3, 0.15), (0.1, 0, -0.075)),
            _link(f"{side}arm", (0.2, 0.2, 1.3), (0, 0, -0.65)),
            _joint(f"{side}HipPitch", f"pelvis {side}leg", (0, 0.25 * y, -0.1), "0 1 0"),
            _joint(f"{side}Ankle", f"{side}leg {side}foot", (0, 0, -1.85), "0 1 0"),
            _joint(f"{side}ShoulderRoll", f"trunk {side}arm", (0, 0.65 * y, 1.0), "1 0 0"),
        ]
    return _write(folder / "giant.urdf", parts)
