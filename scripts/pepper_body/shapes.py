"""Solids from a few parameters: lathes, lofts, capsules. Metres, z up."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray


def sphere(
    radius: float, at: ArrayLike = (0, 0, 0), stretch: ArrayLike = (1, 1, 1), detail: int = 3
) -> trimesh.Trimesh:
    mesh = trimesh.creation.icosphere(detail, radius)
    mesh.apply_scale(stretch)
    return mesh.apply_translation(at)


def capsule(start: ArrayLike, end: ArrayLike, radius: float) -> trimesh.Trimesh:
    a, b = np.asarray(start, float), np.asarray(end, float)
    mesh = trimesh.creation.capsule(np.linalg.norm(b - a), radius, count=(16, 24))
    mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], b - a))
    return mesh.apply_translation(a)


def loft(sections: list[tuple[float, NDArray[np.float64]]], sides: int = 48) -> trimesh.Trimesh:
    """A closed solid through closed horizontal curves (z, (sides, 2)), from below to above."""
    rings = [np.column_stack([curve, np.full(len(curve), z)]) for z, curve in sections]
    n = len(rings[0])
    vertices = np.concatenate([*rings, [rings[0].mean(0)], [rings[-1].mean(0)]])
    i = np.arange(n)
    j = (i + 1) % n
    faces = [np.column_stack([np.full(n, len(vertices) - 2), j, i])]
    for r in range(len(rings) - 1):
        a, b = r * n, (r + 1) * n
        faces += [np.column_stack([a + i, a + j, b + j]), np.column_stack([a + i, b + j, b + i])]
    top = (len(rings) - 1) * n
    faces.append(np.column_stack([np.full(n, len(vertices) - 1), top + i, top + j]))
    return trimesh.Trimesh(vertices, np.concatenate(faces))


def ellipse(
    rx: float, ry: float, at: tuple[float, float] = (0, 0), sides: int = 48
) -> NDArray[np.float64]:
    t = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    return np.column_stack([at[0] + rx * np.cos(t), at[1] + ry * np.sin(t)])
