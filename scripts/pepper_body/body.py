"""Every link's shape, and the palette."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from . import arms, head, trunk
from .joints import FINGERS
from .shapes import Surface


@dataclass(frozen=True)
class Paint:
    """sRGB colour and glTF roughness."""

    rgb: tuple[int, int, int]
    roughness: float = 0.5


PALETTE = {
    "white": Paint((240, 241, 243), 0.42),
    "light": Paint((196, 200, 206)),
    "grey": Paint((122, 127, 135)),
    "dark": Paint((52, 55, 62)),
    "screen": Paint((26, 31, 46), 0.55),
    "eye": Paint((16, 17, 24), 0.1),
    "glint": Paint((255, 255, 255), 0.1),
    "led": Paint((190, 225, 255)),
}


def shapes() -> dict[str, list[Surface]]:
    """Mesh file name -> surfaces, in the frame of the link (or links) that it is for."""
    files = {
        "skirt": trunk.skirt(),
        "thigh": trunk.thigh(),
        "pelvis": trunk.pelvis(),
        "torso": trunk.torso(),
        "neck": head.neck(),
        "head": head.head(),
        "eye_led": head.eye_led(),
        "shoulder": arms.shoulder(),
        "upper_arm": arms.upper_arm(),
        "elbow": arms.elbow(),
        "forearm": arms.forearm(),
        "hand": arms.hand(),
    }
    for thumb in (False, True):
        for last in (False, True):
            files[_phalanx(thumb, last)] = arms.phalanx(thumb, last)
    return files


def _phalanx(thumb: bool, last: bool) -> str:
    return ("thumb" if thumb else "finger") + ("_tip" if last else "")


def uses() -> list[tuple[str, str, bool]]:
    """(link, mesh file name, mirrored in y) of every visual."""
    rows = [(link, link, False) for link in ("skirt", "thigh", "pelvis", "torso", "neck", "head")]
    for side in "lr":
        for link in ("shoulder", "upper_arm", "elbow", "forearm", "hand"):
            rows.append((f"{side}_{link}", link, side == "r"))
        for name, count, _, _ in FINGERS:
            for number in range(1, count + 1):
                mesh = _phalanx(name == "Thumb", number == count)
                rows.append((f"{side}_{name.lower()}_{number}", mesh, False))
        rows += [(f"{side}_eye_led_{i}", "eye_led", False) for i in range(head.LEDS)]
    return rows


def to_glb(surfaces: list[Surface]) -> bytes:
    """One piece for each colour."""
    scene = trimesh.Scene()
    for color, paint in PALETTE.items():
        chosen = [s for s in surfaces if s.color == color]
        if not chosen:
            continue
        offsets = np.cumsum([0, *(len(s.vertices) for s in chosen[:-1])])
        mesh = trimesh.Trimesh(
            np.concatenate([s.vertices for s in chosen]),
            np.concatenate([s.faces + o for s, o in zip(chosen, offsets, strict=True)]),
            vertex_normals=np.concatenate([s.normals for s in chosen]),
            process=False,
        )
        material = PBRMaterial(
            name=color,
            baseColorFactor=[*_linear(paint.rgb), 255],
            metallicFactor=0.0,
            roughnessFactor=paint.roughness,
        )
        mesh.visual = TextureVisuals(material=material)
        scene.add_geometry(mesh, node_name=color, geom_name=color)
    content = scene.export(file_type="glb", include_normals=True)
    assert isinstance(content, bytes)
    return content


def _linear(rgb: tuple[int, int, int]) -> list[int]:
    """glTF's colours are linear, the palette is sRGB."""
    srgb = np.array(rgb) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return [int(v) for v in np.round(linear * 255)]
