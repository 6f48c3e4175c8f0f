"""Make static/pepper: the URDF and its meshes, all from parameters of our own.

Run from anywhere: python scripts/make_pepper_body.py
It needs scipy and manifold3d besides the package itself.
"""

from __future__ import annotations

from pathlib import Path

from pepper_body.body import shapes, to_glb, uses
from pepper_body.joints import pepper_joints
from pepper_body.urdf import Visual, format_urdf

FOLDER = Path(__file__).parents[1] / "static" / "pepper"


def main() -> None:
    """Write every file anew, and say how large they are."""
    meshes = FOLDER / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    for old in meshes.glob("*.glb"):
        old.unlink()
    size = 0
    triangles = {}
    for name, surfaces in shapes().items():
        content = to_glb(surfaces)
        (meshes / f"{name}.glb").write_bytes(content)
        size += len(content)
        triangles[name] = sum(len(s.faces) for s in surfaces)
    visuals = [Visual(link, f"meshes/{mesh}.glb", mirrored) for link, mesh, mirrored in uses()]
    (FOLDER / "pepper.urdf").write_text(
        format_urdf("pepper", pepper_joints(), visuals), encoding="utf-8"
    )
    drawn = sum(triangles[mesh] for _, mesh, _ in uses())
    print(triangles)
    print(f"{len(triangles)} meshes, {size / 1e6:.2f} MB; {drawn} triangles on the robot")


if __name__ == "__main__":
    main()
