"""The room that robots stand in, the same on every page: light, and a floor that fades away."""

from __future__ import annotations

import io

import numpy as np
import trimesh
import viser
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

BACKDROP = (214, 219, 226)
FLOOR = (210, 218, 229)
FLOOR_OPAQUE, FLOOR_RADIUS = 3.0, 9.0  # metres from the middle: the floor is all there, and gone
SECTORS = 96


def set_up_studio(scene: viser.SceneApi) -> None:
    """A floor and soft studio light: white shells keep their shape, the floor gets one shadow.

    No environment map: it arrives late, and software renderers pay for it in every pixel.
    """
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.set_background_image(np.full((2, 2, 3), BACKDROP, dtype=np.uint8), format="png")
    # No fog: the mark that viser draws during a drag has no fog uniforms, and three.js stops there.
    scene.add_light_hemisphere(
        "/stage/sky", sky_color=(255, 255, 255), ground_color=(176, 180, 190), intensity=1.6
    )
    scene.add_light_spot(
        "/stage/key",
        position=(3.2, 2.2, 4.5),
        direction=(-3.2, -2.2, -3.9),
        angle=0.6,
        penumbra=1.0,
        decay=0.0,
        intensity=0.9,
        cast_shadow=True,
    )
    for name, position, intensity in (
        ("fill", (3.5, 0.5, 4.0), 1.1),
        ("rim", (-3.0, -2.5, 3.0), 0.6),
    ):
        x, y, z = position
        scene.add_light_spot(
            f"/stage/{name}",
            position=position,
            direction=(-x, -y, 0.7 - z),
            angle=1.3,
            penumbra=1.0,
            decay=0.0,
            intensity=intensity,
        )
    scene.add_glb("/stage/floor", floor_glb(), cast_shadow=False, receive_shadow=True)


def floor_glb() -> bytes:
    """A disc at z = 0 whose rim is transparent: a floor without a horizon, and without fog."""
    radii = np.array([0.0, FLOOR_OPAQUE, *np.linspace(FLOOR_OPAQUE, FLOOR_RADIUS, 9)[1:]])
    angles = np.linspace(0.0, 2 * np.pi, SECTORS, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(SECTORS)], axis=1)
    vertices = (radii[:, None, None] * circle).reshape(-1, 3)  # ring by ring
    here = np.arange(SECTORS)
    beside = np.roll(here, -1)
    faces = np.concatenate(
        [
            np.concatenate(
                [
                    np.stack([inner + here, outer + here, outer + beside], axis=1),
                    np.stack([inner + here, outer + beside, inner + beside], axis=1),
                ]
            )
            for inner, outer in zip(
                range(0, len(vertices) - SECTORS, SECTORS),
                range(SECTORS, len(vertices), SECTORS),
                strict=True,
            )
        ]
    )
    there = np.clip((FLOOR_RADIUS - radii) / (FLOOR_RADIUS - FLOOR_OPAQUE), 0.0, 1.0)
    smooth = there**2 * (3 - 2 * there)
    colors = np.empty((len(vertices), 4), dtype=np.uint8)
    colors[:, :3] = 255
    colors[:, 3] = np.repeat(np.round(255 * smooth), SECTORS)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.update_faces(mesh.nondegenerate_faces())  # in the middle a ring is a point
    material = PBRMaterial(
        baseColorFactor=[*FLOOR, 255], alphaMode="BLEND", metallicFactor=0.0, roughnessFactor=1.0
    )
    visual = TextureVisuals(material=material)
    visual.vertex_attributes["color"] = colors
    mesh.visual = visual
    buffer = io.BytesIO()
    trimesh.Scene([mesh]).export(buffer, file_type="glb", include_normals=True)
    return buffer.getvalue()
