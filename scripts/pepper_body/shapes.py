"""Surfaces from a few parameters: lofts, lathes, cuts, colours. Metres, z up, x ahead.

A body is a list of `Surface`s. Seams between colours run along the zero line of a field on the
surface, so that two shells meet without a gap.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

Array = NDArray[np.float64]
# Of the edges across a shape: a renderer in software takes time for each triangle, and at the size
# of a screen nobody sees more of them.
DETAIL = 0.62
Field = Callable[[Array], Array]  # (n, 3) points -> (n,) values


@dataclass(frozen=True)
class Surface:
    """Triangles of one colour; vertices and unit normals (n, 3), faces (m, 3)."""

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    color: str

    def moved(self, matrix: Array) -> Surface:
        """By a rigid motion or a mirror (4, 4)."""
        linear = matrix[:3, :3]
        faces = self.faces[:, ::-1] if np.linalg.det(linear) < 0 else self.faces
        return replace(
            self,
            vertices=self.vertices @ linear.T + matrix[:3, 3],
            normals=self.normals @ linear.T,
            faces=faces,
        )

    def painted(self, field: Field, color: str) -> list[Surface]:
        """Two surfaces: where the field is negative in another colour, the rest as it is."""
        values = field(self.vertices)
        inside = _part(self, values)
        outside = _part(self, -values)
        return [s for s in (replace(inside, color=color), outside) if len(s.faces)]

    def with_panels(self, *panels: tuple[Field, str]) -> list[Surface]:
        """Painted one panel after the other, each on what still has the first colour."""
        parts = [self]
        for field, color in panels:
            first = [part for part in parts if part.color == self.color]
            parts = [part for part in parts if part.color != self.color]
            parts += [piece for part in first for piece in part.painted(field, color)]
        return parts


def _part(surface: Surface, values: Array) -> Surface:
    """The part with values < 0, triangles cut along the zero line."""
    points = np.hstack([surface.vertices, surface.normals, values[:, None]])  # (n, 7)
    triangles = points[surface.faces]  # (m, 3, 7)
    below = triangles[:, :, 6] < 0
    count = below.sum(axis=1)
    pieces = [triangles[count == 3]]
    for kept in (1, 2):
        chosen = triangles[count == kept]
        odd = below[count == kept] if kept == 1 else ~below[count == kept]
        first = odd.argmax(axis=1)  # the corner that is alone on its side
        order = (first[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(chosen, order[:, :, None], axis=1), 1, 0)
        ab, ac = _zero(a, b), _zero(a, c)
        if kept == 1:
            pieces.append(np.stack([a, ab, ac], axis=1))
        else:
            pieces += [np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)]
    corners = np.concatenate(pieces).reshape(-1, 7)
    unique, index = np.unique(np.round(corners[:, :6], 7), axis=0, return_inverse=True)
    faces = index.reshape(-1, 3)
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return replace(
        surface, vertices=unique[:, :3], normals=_unit(unique[:, 3:]), faces=faces[distinct]
    )


def _zero(a: Array, b: Array) -> Array:
    span = a[:, 6] - b[:, 6]
    t = a[:, 6] / np.where(np.abs(span) < 1e-15, 1.0, span)
    return a + t[:, None] * (b - a)


def _unit(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths < 1e-12, 1.0, lengths)


def surface(mesh: trimesh.Trimesh, color: str, crease: float = 40.0) -> Surface:
    """A mesh with normals that are smooth where faces meet at less than `crease` degrees."""
    smooth = trimesh.graph.smooth_shade(mesh, angle=np.radians(crease), facet_minarea=None)
    return Surface(
        np.array(smooth.vertices),
        _unit(np.array(smooth.vertex_normals)),
        np.array(smooth.faces),
        color,
    )


# Curves across a body, and bodies through curves.


def fine(edges: int) -> int:
    """As many edges as the robot is drawn with; even, for what is the same on both sides."""
    return max(2 * round(DETAIL * edges / 2), 6)


def superellipse(
    ahead: float, behind: float, side: float, center: float = 0.0, power: float = 2.0,
    sides: int = 48,
) -> Array:  # fmt: skip
    """A closed curve (sides, 2), symmetric in y; a power above 2 is boxier than an ellipse."""
    t = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    cos, sin = np.cos(t), np.sin(t)
    x = np.where(cos > 0, ahead, behind) * np.sign(cos) * np.abs(cos) ** (2 / power)
    return np.column_stack([center + x, side * np.sign(sin) * np.abs(sin) ** (2 / power)])


def rounded_hull(circles: Sequence[tuple[float, float, float]], sides: int = 72) -> Array:
    """The smooth closed curve (sides, 2) around circles (x, y, radius), even from y = 0."""
    normal = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    directions = np.column_stack([np.cos(normal), np.sin(normal)])
    support = np.stack([directions @ np.array(c[:2]) + c[2] for c in circles])
    height = np.log(np.exp(support * 120).sum(axis=0)) / 120 - np.log(len(circles)) / 120 / 2
    slope = np.gradient(np.r_[height[-1], height, height[0]], normal[1])[1:-1]
    tangents = np.column_stack([-directions[:, 1], directions[:, 0]])
    curve = height[:, None] * directions + slope[:, None] * tangents
    closed = np.vstack([curve, curve[:1]])
    length = np.r_[0, np.linalg.norm(np.diff(closed, axis=0), axis=1).cumsum()]
    at = np.linspace(0, length[-1], fine(sides), endpoint=False)
    return np.column_stack([np.interp(at, length, closed[:, i]) for i in (0, 1)])


def loft(rings: Sequence[Array]) -> trimesh.Trimesh:
    """A closed solid through rings (n, 3) that all run the same way round."""
    n = len(rings[0])
    ends = np.array([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    vertices = np.concatenate([*rings, ends])
    i = np.arange(n)
    j = (i + 1) % n
    first, last = len(vertices) - 2, len(vertices) - 1
    faces = [np.column_stack([np.full(n, first), j, i])]
    for start in range(0, (len(rings) - 1) * n, n):
        above = start + n
        faces.append(np.column_stack([start + i, start + j, above + j]))
        faces.append(np.column_stack([start + i, above + j, above + i]))
    top = (len(rings) - 1) * n
    faces.append(np.column_stack([np.full(n, last), top + i, top + j]))
    mesh = trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
    mesh.update_faces(mesh.nondegenerate_faces(height=1e-9))
    if mesh.volume < 0:  # the rings ran the other way round
        mesh.invert()
    return mesh


def through(stations: ArrayLike, count: int) -> Array:
    """Smooth values (count, k) through a table of stations (s, k), by their running distance.

    The first two columns (height and size, say) measure the distance.
    """
    table = np.asarray(stations, dtype=np.float64)
    steps = np.linalg.norm(np.diff(table[:, :3], axis=0), axis=1)
    at = np.r_[0, np.maximum(steps, 1e-6).cumsum()]
    return np.asarray(PchipInterpolator(at, table)(np.linspace(0, at[-1], count)))


def body(
    stations: ArrayLike, rings: int = 32, sides: int = 48, power: float = 2.0
) -> trimesh.Trimesh:
    """A solid through stations (z, ahead, behind, side, center) of superellipses."""
    rings, sides = fine(rings), fine(sides)
    return loft(
        [
            np.column_stack([
                superellipse(ahead, behind, side, center, power, sides), np.full(sides, z)
            ])
            for z, ahead, behind, side, center in through(stations, rings)
        ]
    )  # fmt: skip


def lathe(profile: ArrayLike, rings: int | None = None, sides: int = 40) -> trimesh.Trimesh:
    """A solid of revolution about z through (radius, z), upwards; smoothed with `rings`."""
    line = np.asarray(profile, dtype=np.float64)
    sides = fine(sides)
    if rings is not None:
        line = through(np.column_stack([line, np.zeros(len(line))]), fine(rings))[:, :2]
    t = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    circle = np.column_stack([np.cos(t), np.sin(t)])
    return loft([np.column_stack([max(r, 1e-6) * circle, np.full(sides, z)]) for r, z in line])


def sphere(radius: float, at: ArrayLike = (0, 0, 0), detail: int = 2) -> trimesh.Trimesh:
    return trimesh.creation.icosphere(detail, radius).apply_translation(at)


def cylinder(
    axis: str, radius: float, half: float, at: ArrayLike = (0, 0, 0), sections: int = 64
) -> trimesh.Trimesh:
    """A cylinder about the named axis through `at`."""
    mesh = trimesh.creation.cylinder(radius, 2 * half, sections=fine(sections))
    return mesh.apply_transform(ALONG[axis]).apply_translation(at)


def box(size: ArrayLike, at: ArrayLike = (0, 0, 0)) -> trimesh.Trimesh:
    return trimesh.creation.box(size).apply_translation(at)


def slab(half_y: float, half_z: float, depth: float, bevel: float, power: float) -> trimesh.Trimesh:
    """A plate with round corners, from x = 0 to `depth`; the higher the power, the sharper."""
    sides = fine(64)
    curve = superellipse(1, 1, 1, power=power, sides=sides)
    rings = []
    for x, inset in ((0.0, bevel), (bevel, 0.0), (depth - bevel, 0.0), (depth, bevel)):
        y, z = curve[:, 0] * (half_y - inset), curve[:, 1] * (half_z - inset)
        rings.append(np.column_stack([np.full(sides, x), y, z]))
    return loft(rings)


def cut(solid: trimesh.Trimesh, *others: trimesh.Trimesh) -> trimesh.Trimesh:
    """The solid less the others."""
    return trimesh.boolean.difference([solid, *others], engine="manifold")


def turned(axis: str, degrees: float, at: ArrayLike = (0, 0, 0)) -> Array:
    """(4, 4) turn about an axis, then a shift."""
    direction = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}[axis]
    matrix = trimesh.transformations.rotation_matrix(np.radians(degrees), direction)
    matrix[:3, 3] = at
    return np.asarray(matrix)


# Turns that take the z axis to another one, the rest in cyclic order.
ALONG = {
    "x": np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=np.float64),
    "y": np.array([[0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1]], dtype=np.float64),
    "z": np.eye(4),
}
MIRROR_Y = np.diag([1.0, -1.0, 1.0, 1.0])
