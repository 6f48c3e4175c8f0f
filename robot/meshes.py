"""The shapes of a robot description: found, loaded, and written as GLB for the viewer."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.visual import ColorVisuals, TextureVisuals
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from .tree import KinematicTree

if TYPE_CHECKING:
    import yourdfpy

ROUGHNESS = 0.6  # of shapes that say nothing of it
GREY = (0.8, 0.8, 0.8, 1.0)  # of shapes without a colour
CREASE = np.radians(35)  # faces that meet at less are smooth, in files without normals
LARGE = 200_000  # faces; smoothing them takes too long


@dataclass(frozen=True, eq=False)
class Shape:
    """One piece of a robot's surface.

    frame: index of the moving frame that carries it, -1 for the base.
    mesh: in that frame, metres, with vertex normals.
    material: what it looks like; colors (n, 4) uint8 and uv (n, 2) where its vertices have them.
    """

    frame: int
    link: str
    mesh: trimesh.Trimesh
    material: PBRMaterial
    colors: NDArray[np.uint8] | None = None
    uv: NDArray[np.float64] | None = None

    def moved(self, matrix: NDArray[np.float64]) -> Shape:
        """By any affine transform (4, 4); a mirror turns the faces, too."""
        mesh = self.mesh.copy(include_cache=True)
        return replace(self, mesh=mesh.apply_transform(matrix))


def load_shapes(
    urdf: yourdfpy.URDF, tree: KinematicTree, path: Path
) -> tuple[tuple[Shape, ...], list[str]]:
    """Every visual of every link; a mesh that cannot be loaded is left out with one warning."""
    materials = {material.name: material for material in urdf.robot.materials}
    shapes: list[Shape] = []
    warnings: dict[str, str] = {}  # by file name: one each
    cache: dict[str, list[Shape]] = {}
    for link in urdf.robot.links:
        if link.name not in tree.links:
            continue
        frame, offset = tree.links[link.name]
        for visual in link.visuals:
            try:
                pieces = _pieces(visual.geometry, path, cache)
            except _Unusable as error:
                name = visual.geometry.mesh.filename
                warnings[name] = f"link {link.name} is shown without {name}: {error}"
                continue
            pose = offset if visual.origin is None else offset @ visual.origin
            color = _urdf_color(visual, materials)
            for piece in pieces:
                # a file's own colours are worth more than the one that the URDF gives it
                plain = piece.material.name is None and piece.colors is None
                material = color if plain and color is not None else piece.material
                placed = replace(piece.moved(pose), frame=frame, link=link.name, material=material)
                shapes.append(placed)
    return tuple(shapes), list(warnings.values())


class _Unusable(Exception):
    """Why a mesh cannot be shown."""


def _pieces(geometry: yourdfpy.Geometry, path: Path, cache: dict[str, list[Shape]]) -> list[Shape]:
    """The shapes of one geometry, in its own coordinates."""
    if geometry.box is not None:
        return [_shape(trimesh.creation.box(geometry.box.size))]
    if geometry.sphere is not None:
        return [_shape(trimesh.creation.icosphere(3, geometry.sphere.radius))]
    if geometry.cylinder is not None:
        size = geometry.cylinder
        return [_shape(trimesh.creation.cylinder(size.radius, size.length, sections=48))]
    if geometry.mesh is None:
        return []
    name = geometry.mesh.filename
    if name not in cache:
        file = resolve(name, path)
        if file is None:
            raise _Unusable("no such file")
        cache[name] = list(_load(file))
        if not cache[name]:
            raise _Unusable("no triangles in it")
    scale = np.eye(4)
    if geometry.mesh.scale is not None:
        scale[[0, 1, 2], [0, 1, 2]] = geometry.mesh.scale
    return [shape.moved(scale) for shape in cache[name]]


def _load(file: Path) -> Iterator[Shape]:
    try:
        scene = trimesh.load_scene(file)
    except Exception as error:  # each of trimesh's many readers fails in its own ways
        raise _Unusable(f"{type(error).__name__}: {error}".splitlines()[0]) from error
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            yield _shape(mesh).moved(transform)


def _shape(mesh: trimesh.Trimesh) -> Shape:
    """A mesh with its normals, or smooth ones where it has none, and its looks."""
    visual = mesh.visual
    if isinstance(visual, TextureVisuals):
        material, colors = _pbr(visual.material), visual.vertex_attributes.data.get("color")
        _ = mesh.vertex_normals
        return Shape(-1, "", mesh, material, colors, visual.uv)
    if "vertex_normals" not in mesh._cache and len(mesh.faces) < LARGE:
        mesh = trimesh.graph.smooth_shade(mesh, angle=CREASE, facet_minarea=None)
        visual = mesh.visual
    _ = mesh.vertex_normals
    if isinstance(visual, ColorVisuals) and visual.defined:
        return Shape(-1, "", mesh, _painted(np.ones(4)), np.asarray(visual.vertex_colors))
    return Shape(-1, "", mesh, _painted(np.array(GREY)))


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


# Looks. glTF takes a shape without a metallic factor for dark metal, so that each has its own here.


def _painted(rgba: NDArray[np.float64]) -> PBRMaterial:
    return PBRMaterial(
        baseColorFactor=np.clip(np.round(rgba * 255), 0, 255).astype(np.uint8),
        metallicFactor=0.0,
        roughnessFactor=ROUGHNESS,
        alphaMode="BLEND" if rgba[3] < 1 else None,
    )


def _pbr(material: PBRMaterial | SimpleMaterial) -> PBRMaterial:
    """A file's material; it has a name, which tells it from the ones made here."""
    named = material.name or "unnamed"
    out: PBRMaterial
    out = material.to_pbr() if isinstance(material, SimpleMaterial) else material.copy()
    out.name = named
    glow = out.emissiveFactor
    if glow is not None and np.min(glow) > 0.99 and out.emissiveTexture is None:
        out.emissiveFactor = None  # exporters write this; nothing of the shape would be seen
    if out.metallicFactor is None:
        out.metallicFactor = 0.0
    if out.roughnessFactor is None:
        out.roughnessFactor = ROUGHNESS
    return out


def _urdf_color(
    visual: yourdfpy.Visual, materials: dict[str, yourdfpy.Material]
) -> PBRMaterial | None:
    """The URDF's own colour, for shapes that bring none."""
    material = visual.material
    if material is not None and material.color is None:
        material = materials.get(material.name)
    if material is None or material.color is None:
        return None
    return _painted(np.asarray(material.color.rgba, dtype=np.float64))


def to_glb(shapes: list[Shape]) -> bytes:
    """The shapes as one GLB."""
    scene = trimesh.Scene()
    for shape in shapes:
        mesh = shape.mesh.copy(include_cache=True)
        visual = TextureVisuals(uv=shape.uv, material=shape.material)
        if shape.colors is not None:
            visual.vertex_attributes["color"] = shape.colors
        mesh.visual = visual
        scene.add_geometry(mesh)
    buffer = io.BytesIO()
    scene.export(buffer, file_type="glb", include_normals=True)
    return buffer.getvalue()
