"""Every link's shape, by colour."""

from __future__ import annotations

import numpy as np
import trimesh
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from .joints import FINGERS, PHALANX, THUMB_PHALANX
from .shapes import capsule, ellipse, loft, sphere

WHITE = (242, 242, 240)
GREY = (120, 124, 130)
DARK = (40, 42, 48)
COLORS = {"white": WHITE, "grey": GREY, "dark": DARK}


def _paint(name: str, meshes: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    mesh = trimesh.util.concatenate(meshes)
    mesh.visual = TextureVisuals(
        material=PBRMaterial(
            name=name, baseColorFactor=[*COLORS[name], 255], metallicFactor=0.0, roughnessFactor=0.5
        )
    )
    _ = mesh.vertex_normals
    return mesh


def pepper_body() -> dict[str, dict[str, trimesh.Trimesh]]:
    parts: dict[str, dict[str, list[trimesh.Trimesh]]] = {}
    add = lambda link, color, mesh: parts.setdefault(link, {}).setdefault(color, []).append(mesh)
    add(
        "skirt",
        "white",
        loft(
            [
                (-0.334, ellipse(0.2, 0.22)),
                (-0.22, ellipse(0.2, 0.22)),
                (-0.12, ellipse(0.12, 0.13)),
                (0.04, ellipse(0.08, 0.1)),
            ]
        ),
    )
    add(
        "thigh",
        "white",
        loft(
            [(0.0, ellipse(0.075, 0.1)), (0.15, ellipse(0.075, 0.11)), (0.26, ellipse(0.08, 0.11))]
        ),
    )
    add("pelvis", "grey", loft([(-0.05, ellipse(0.06, 0.07)), (0.1, ellipse(0.06, 0.07))]))
    add(
        "torso",
        "white",
        loft(
            [
                (0.0, ellipse(0.07, 0.09)),
                (0.15, ellipse(0.1, 0.12)),
                (0.26, ellipse(0.1, 0.14, (-0.04, 0))),
                (0.3, ellipse(0.03, 0.03, (-0.04, 0))),
            ]
        ),
    )
    tablet = trimesh.creation.box((0.01, 0.246, 0.175))
    tablet.apply_transform(trimesh.transformations.rotation_matrix(-0.35, [0, 1, 0]))
    tablet.apply_translation((0.13, 0, 0.14))
    add("torso", "dark", tablet)
    add("neck", "grey", capsule((0, 0, -0.03), (0, 0, 0.03), 0.03))
    add("head", "white", sphere(0.105, (0, 0, 0.115), detail=4))
    for s in (1, -1):
        add("head", "dark", sphere(0.024, (0.088, s * 0.042, 0.115), (0.5, 1, 1)))
        add("head", "grey", capsule((0, s * 0.09, 0.115), (0, s * 0.104, 0.115), 0.03))
    for l in "lr":
        s = 1 if l == "l" else -1
        add(f"{l}_shoulder", "grey", sphere(0.042))
        add(f"{l}_upper_arm", "white", capsule((0.02, s * 0.01, 0), (0.15, s * 0.015, 0), 0.033))
        add(f"{l}_elbow", "grey", sphere(0.032))
        add(f"{l}_forearm", "white", capsule((0.03, 0, 0), (0.11, 0, 0), 0.03))
        add(f"{l}_hand", "white", sphere(0.04, (0.045, 0, 0), (1, 0.9, 0.4)))
        for name, phalanges, _, _ in FINGERS:
            length = THUMB_PHALANX if name == "Thumb" else PHALANX
            for k in range(1, phalanges + 1):
                add(
                    f"{l}_{name.lower()}_{k}",
                    "grey",
                    capsule((0, 0, 0), (length if k < phalanges else length * 0.7, 0, 0), 0.007),
                )
    return {link: {c: _paint(c, m) for c, m in colors.items()} for link, colors in parts.items()}
