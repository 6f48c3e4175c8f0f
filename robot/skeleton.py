"""What stands in for shapes that are not there: a ball at every joint, a bar to the next one."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.transformations import translation_matrix

from .meshes import Shape, painted
from .tree import KinematicTree

COLOR = (0.95, 0.6, 0.2, 1.0)  # no robot of shells looks like it
BALL, BAR, AXIS = 0.02, 0.007, 0.12  # radii, and the length of an axis; of the robot's extent
SHORT = 0.15  # of that extent; shorter bones, as of fingers, are thinner, too
THINNEST = 0.2
LONE = 1.0  # metres; for a robot that is one point


def skeleton(
    tree: KinematicTree, bare: Collection[str], shapes: Iterable[Shape]
) -> tuple[Shape, ...]:
    """A ball at each of these links, a rod along the axis that moves it, and bars to the next ones.

    Args:
        bare: links without a shape.
        shapes: what there is of the robot; with the joints it says how large all this has to be.
    """
    extent = _extent(tree, shapes)
    axes = {frame.link: frame.axis for frame in tree.frames}
    ball = painted(trimesh.creation.icosphere(2, BALL * extent), COLOR)
    bar = painted(trimesh.creation.cylinder(BAR * extent, 1.0, sections=12), COLOR)
    above = {frame.link: float(np.linalg.norm(frame.origin[:3, 3])) for frame in tree.frames}
    out = []
    for link in bare:
        frame, pose = tree.links[link]
        here = pose[:3, 3]
        ends = [(here, there) for there in tree.joined[link]]
        bones = [above.get(link, 0.0), *(float(np.linalg.norm(end - here)) for _, end in ends)]
        longest = max(bones) or SHORT * extent
        thin = float(np.clip(longest / (SHORT * extent), THINNEST, 1.0))
        drawn = [ball.moved(translation_matrix(here) @ _scaled(thin, thin))]
        if link in axes:
            reach = AXIS / 2 * thin * extent * axes[link]
            ends.append((-reach, reach))
        for start, end in ends:
            if np.linalg.norm(end - start) > BALL * thin * extent:  # else the ball covers it
                drawn.append(bar.moved(_along(start, end, thin)))
        out += [replace(shape, frame=frame, link=link) for shape in drawn]
    return tuple(out)


def _scaled(across: float, along: float) -> NDArray[np.float64]:
    return np.diag([across, across, along, 1.0])


def _along(
    start: NDArray[np.float64], end: NDArray[np.float64], thin: float
) -> NDArray[np.float64]:
    """(4, 4): from a bar of 1 m along z around the origin to a thin one between two points."""
    length = float(np.linalg.norm(end - start))
    turned = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], (end - start) / length)
    placed: NDArray[np.float64] = translation_matrix((start + end) / 2) @ turned
    return placed @ _scaled(thin, length)


def _extent(tree: KinematicTree, shapes: Iterable[Shape]) -> float:
    """The largest side of the box around joints and shapes, metres."""
    points: list[NDArray[np.float64]] = [np.zeros((1, 3)), tree.rest_poses[:, :3, 3]]
    for shape in shapes:
        pose = np.eye(4) if shape.frame < 0 else tree.rest_poses[shape.frame]
        points.append(shape.mesh.bounds @ pose[:3, :3].T + pose[:3, 3])
    return float(np.ptp(np.concatenate(points), axis=0).max()) or LONE
