"""Make static/pepper: the URDF and its meshes, all from parameters of our own.

Run from anywhere: python scripts/make_pepper_body.py
"""

from __future__ import annotations

from pathlib import Path

import trimesh
from pepper_body.body import pepper_body
from pepper_body.joints import pepper_joints
from pepper_body.urdf import Visual, format_urdf

FOLDER = Path(__file__).parents[1] / "static" / "pepper"


def main() -> None:
    meshes = FOLDER / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    for old in meshes.glob("*.glb"):
        old.unlink()
    visuals = []
    size = triangles = 0
    for link, parts in pepper_body().items():
        scene = trimesh.Scene()
        for name, mesh in parts.items():
            scene.add_geometry(mesh, node_name=name, geom_name=name)
            triangles += len(mesh.faces)
        content = scene.export(file_type="glb", include_normals=True)
        (meshes / f"{link}.glb").write_bytes(content)
        size += len(content)
        visuals.append(Visual(link, f"meshes/{link}.glb"))
    urdf = format_urdf("pepper", pepper_joints(), visuals)
    (FOLDER / "pepper.urdf").write_text(urdf, encoding="utf-8")
    print(f"{len(visuals)} meshes, {triangles} triangles, {size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
