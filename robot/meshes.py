"""The shapes of a robot description: found, loaded, and written as GLB for the viewer."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial, SimpleMaterial

if TYPE_CHECKING:
    import yourdfpy

    from .kinematics import KinematicTree

Rgb = tuple[int, int, int]
DEFAULT_ROUGHNESS = 0.6


@dataclass(frozen=True, eq=False)
class Shape:
    """One piece of a robot's surface.

    frame: index of the moving frame that carries it, -1 for the base. mesh: in that frame, metres.
    """

    frame: int
    link: str
    mesh: trimesh.Trimesh


def load_shapes(
    urdf: yourdfpy.URDF, tree: KinematicTree, path: Path
) -> tuple[tuple[Shape, ...], list[str]]:
    """Every visual of every link; a mesh that cannot be loaded is left out with one warning."""
    materials = {material.name: material for material in urdf.robot.materials}
    shapes: list[Shape] = []
    warnings: dict[str, str] = {}  # by file name: one each
    cache: dict[str, list[trimesh.Trimesh]] = {}
    for link in urdf.robot.links:
        if link.name not in tree.links:
            continue
        frame, offset = tree.links[link.name]
        for visual in link.visuals:
            name = visual.geometry.mesh.filename if visual.geometry.mesh is not None else ""
            try:
                pieces = _pieces(visual.geometry, path, cache)
            except _Unusable as error:
                warnings[name] = f"link {link.name} is shown without {name}: {error}"
                continue
            pose = offset if visual.origin is None else offset @ visual.origin
            color = _urdf_color(visual, materials)
            for piece in pieces:
                mesh = _copy(piece)
                mesh.apply_transform(pose)
                if color is not None and not isinstance(mesh.visual, TextureVisuals):
                    mesh.visual = TextureVisuals(material=color)
                shapes.append(Shape(frame, link.name, mesh))
    return tuple(shapes), list(warnings.values())


class _Unusable(Exception):
    """Why a mesh cannot be shown."""


def _pieces(
    geometry: yourdfpy.Geometry, path: Path, cache: dict[str, list[trimesh.Trimesh]]
) -> list[trimesh.Trimesh]:
    """The meshes of one geometry, with normals, in its own coordinates."""
    if geometry.box is not None:
        return [_with_normals(trimesh.creation.box(geometry.box.size))]
    if geometry.sphere is not None:
        return [_with_normals(trimesh.creation.icosphere(3, geometry.sphere.radius))]
    if geometry.cylinder is not None:
        size = geometry.cylinder
        return [_with_normals(trimesh.creation.cylinder(size.radius, size.length, sections=48))]
    if geometry.mesh is None:
        return []
    name = geometry.mesh.filename
    if name not in cache:
        file = resolve(name, path)
        if file is None:
            raise _Unusable("no such file")
        cache[name] = list(_load(file))
    scale = np.eye(4)
    if geometry.mesh.scale is not None:
        scale[[0, 1, 2], [0, 1, 2]] = geometry.mesh.scale
    return [_copy(mesh).apply_transform(scale) for mesh in cache[name]]


def _load(file: Path) -> Iterator[trimesh.Trimesh]:
    try:
        scene = trimesh.load_scene(file)
    except Exception as error:  # each of trimesh's many readers fails in its own ways
        raise _Unusable(f"{type(error).__name__}: {error}".splitlines()[0]) from error
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            yield _copy(_with_normals(mesh)).apply_transform(transform)


def _copy(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """With normals and vertex colours, which trimesh's own copy leaves out."""
    copy = mesh.copy(include_cache=True)
    if isinstance(mesh.visual, TextureVisuals) and "color" in mesh.visual.vertex_attributes:
        copy.visual.vertex_attributes["color"] = mesh.visual.vertex_attributes["color"]
    return copy


def _with_normals(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The mesh with the normals of its file; without any, smooth where it is not creased."""
    if "vertex_normals" not in mesh._cache:
        if not isinstance(mesh.visual, TextureVisuals):
            mesh = trimesh.graph.smooth_shade(mesh, angle=np.radians(35), facet_minarea=None)
        _ = mesh.vertex_normals
    return mesh


def resolve(name: str, urdf_path: Path) -> Path | None:
    """The file that a URDF means by `package://PKG/rest`, `file://path`, or a path of its own.

    A package is looked for beside and above the URDF, by its name or as the folder that holds
    `rest`, and then in the folders of ROS_PACKAGE_PATH.
    """
    above = urdf_path.resolve().parents
    if name.startswith("package://"):
        package, _, rest = name.removeprefix("package://").partition("/")
        roots = [Path(p) for p in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if p]
        candidates = [folder / package / rest for folder in above]
        candidates += [folder / rest for folder in above if rest]
        candidates += [root / package / rest for root in roots]
    else:
        candidates = [urdf_path.parent / name.removeprefix("file://")]  # absolute ones stay so
    return next((file for file in candidates if file.is_file()), None)


def _urdf_color(
    visual: yourdfpy.Visual, materials: dict[str, yourdfpy.Material]
) -> PBRMaterial | None:
    """The URDF's own colour, for shapes that bring none."""
    material = visual.material
    if material is not None and material.color is None:
        material = materials.get(material.name)
    if material is None or material.color is None:
        return None
    return _pbr(np.asarray(material.color.rgba, dtype=np.float64))


def _pbr(rgba: NDArray[np.float64], roughness: float = DEFAULT_ROUGHNESS) -> PBRMaterial:
    return PBRMaterial(
        baseColorFactor=np.clip(np.round(rgba * 255), 0, 255).astype(np.uint8),
        metallicFactor=0.0,
        roughnessFactor=roughness,
        alphaMode="BLEND" if rgba[3] < 1 else None,
    )


def to_glb(shapes: list[Shape], tint: Rgb | None = None, opacity: float | None = None) -> bytes:
    """The shapes as one GLB.

    Args:
        tint: a colour to multiply with the shapes' own, 0 to 255.
        opacity: from 0 (not there) to 1.
    """
    scene = trimesh.Scene()
    for shape in shapes:
        mesh = _copy(shape.mesh)
        mesh.visual = _visual(mesh, tint, opacity)
        scene.add_geometry(mesh)
    buffer = io.BytesIO()
    scene.export(buffer, file_type="glb", include_normals=True)
    return buffer.getvalue()


def _visual(mesh: trimesh.Trimesh, tint: Rgb | None, opacity: float | None) -> TextureVisuals:
    """The mesh's material as glTF wants it: without one, a viewer shows dark metal."""
    visual = mesh.visual
    factor = np.ones(4)
    if tint is not None:
        factor[:3] = np.asarray(tint) / 255
    if opacity is not None:
        factor[3] = opacity
    if not isinstance(visual, TextureVisuals):
        colors = np.asarray(visual.vertex_colors) if visual.defined else None
        base = np.full(4, 0.8) if colors is None else np.ones(4)
        base[3] = 1.0 if colors is None else colors[:, 3].min() / 255
        out = TextureVisuals(material=_pbr(base * factor))
        if colors is not None:
            out.vertex_attributes["color"] = colors
        return out
    material = visual.material
    if isinstance(material, SimpleMaterial):
        material = material.to_pbr()
    material = material.copy()
    base = material.baseColorFactor
    rgba = np.ones(4) if base is None else np.asarray(base, dtype=np.float64) / 255
    material.baseColorFactor = np.round(rgba * factor * 255).astype(np.uint8)
    if material.metallicFactor is None:
        material.metallicFactor = 0.0
    if material.roughnessFactor is None:
        material.roughnessFactor = DEFAULT_ROUGHNESS
    if (rgba * factor)[3] < 1:
        material.alphaMode = "BLEND"
    out = TextureVisuals(uv=visual.uv, material=material)
    if "color" in visual.vertex_attributes:
        out.vertex_attributes["color"] = visual.vertex_attributes["color"]
    return out
