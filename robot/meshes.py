"""The shapes of a robot description: found, loaded, and written as GLB for the viewer."""

from __future__ import annotations

import io
import logging
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.visual import ColorVisuals, TextureVisuals
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from .mesh_files import MAX_BYTES, MeshFile, MeshFinder
from .tree import KinematicTree
from .urdf_file import LARGEST

if TYPE_CHECKING:
    import yourdfpy

ROUGHNESS = 0.6  # of shapes that say nothing of it
GREY = (0.8, 0.8, 0.8, 1.0)  # of shapes without a colour
CREASE = np.radians(35)  # faces that meet at less are smooth, in files without normals
LARGE = 200_000  # faces; smoothing them takes too long
MAX_FACES = 5_000_000  # of a whole robot
MAX_VISUALS = 3_000
# It logs tracebacks of what it cannot read; that is a warning in our words here.
logging.getLogger("trimesh").setLevel(logging.CRITICAL)


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
    urdf: yourdfpy.URDF, tree: KinematicTree, finder: MeshFinder
) -> tuple[tuple[Shape, ...], tuple[MeshFile, ...], list[str]]:
    """Every visual of every link, the files that they are in, and warnings in plain words."""
    materials = {material.name: material for material in urdf.robot.materials}
    shapes: list[Shape] = []
    files: dict[str, MeshFile] = {}
    loaded: dict[str, list[Shape]] = {}
    room = MAX_FACES
    said = []
    for number, (link, visual) in enumerate(_visuals(urdf, tree)):
        geometry = visual.geometry
        if geometry.mesh is not None and geometry.mesh.filename not in files:
            name = geometry.mesh.filename
            files[name], loaded[name] = _load(name, link, finder)
        frame, offset = tree.links[link]
        pose = offset if visual.origin is None else offset @ visual.origin
        color = _urdf_color(visual, materials)
        pieces = _pieces(visual, loaded)
        room -= sum(len(piece.mesh.faces) for piece in pieces)
        if room < 0 or number == MAX_VISUALS:
            said.append(f"too many shapes to be shown; left out from link {link} on")
            break
        for piece in pieces:
            # a file's own colours are worth more than the one that the URDF gives it
            plain = piece.material.name is None and piece.colors is None
            material = color if plain and color is not None else piece.material
            shapes.append(replace(piece.moved(pose), frame=frame, link=link, material=material))
    return tuple(shapes), tuple(files.values()), said


def painted(mesh: trimesh.Trimesh, color: tuple[float, ...]) -> Shape:
    """A shape of one colour, RGBA from 0 to 1."""
    return replace(_shape(mesh), material=_painted(np.array(color)))


def _visuals(urdf: yourdfpy.URDF, tree: KinematicTree) -> Iterator[tuple[str, yourdfpy.Visual]]:
    for link in urdf.robot.links:
        if link.name in tree.links:
            yield from ((link.name, visual) for visual in link.visuals)


def _pieces(visual: yourdfpy.Visual, loaded: dict[str, list[Shape]]) -> list[Shape]:
    """The shapes of one visual, in its own coordinates."""
    geometry = visual.geometry
    if geometry.box is not None:
        return [_shape(trimesh.creation.box(geometry.box.size))]
    if geometry.sphere is not None:
        return [_shape(trimesh.creation.icosphere(3, geometry.sphere.radius))]
    if geometry.cylinder is not None:
        size = geometry.cylinder
        if visual.name == "capsule":
            return [_shape(trimesh.creation.capsule(size.length, size.radius))]
        return [_shape(trimesh.creation.cylinder(size.radius, size.length, sections=48))]
    scale = np.eye(4)
    if geometry.mesh.scale is not None:
        scale[[0, 1, 2], [0, 1, 2]] = geometry.mesh.scale
    return [shape.moved(scale) for shape in loaded[geometry.mesh.filename]]


def _load(name: str, link: str, finder: MeshFinder) -> tuple[MeshFile, list[Shape]]:
    """What is in the file of a mesh, metres."""
    file, how = finder.find(name)
    if file is None:
        return MeshFile(name, link, None, problem=how), []
    problem = "no triangles in it"
    shapes: list[Shape] = []
    try:
        if file.stat().st_size > MAX_BYTES:
            problem = f"it has over {MAX_BYTES // 1_000_000} MB"
        else:
            with warnings.catch_warnings(action="ignore"), np.errstate(all="ignore"):
                shapes = list(_scene_shapes(trimesh.load_scene(file)))
    except Exception:  # each of trimesh's many readers fails in its own ways, with its own words
        problem = f"the file is broken, or no {file.suffix[1:].upper()}"
    return MeshFile(name, link, file, how, "" if shapes else problem), shapes


def _scene_shapes(scene: trimesh.Scene) -> Iterator[Shape]:
    unit = 1.0 if scene.units is None else trimesh.units.unit_conversion(scene.units, "meters")
    if not 0 < unit < np.inf:
        unit = 1.0
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        if (
            isinstance(mesh, trimesh.Trimesh)
            and len(mesh.faces)
            and np.abs(mesh.bounds).max() < LARGEST
        ):
            yield _shape(mesh).moved(np.diag([unit, unit, unit, 1.0]) @ transform)


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
