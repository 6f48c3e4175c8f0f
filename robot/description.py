"""A robot from its URDF: the shipped Pepper, any other file, or a package of descriptions."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import yourdfpy

from ..core.errors import InputError
from .mesh_files import MeshFile, MeshFinder, mesh_warnings
from .meshes import Shape, load_shapes
from .openings import openings
from .pepper import PEPPER_URDF
from .skeleton import skeleton
from .tree import MOVING_TYPES, KinematicTree, build_tree
from .urdf_file import read_urdf

DESCRIPTIONS_EXTRA = "robots"  # the optional extra that brings robot_descriptions


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot description, ready to be moved and shown; never changed after loading.

    joints: the actuated ones, in the order of the URDF; mimics follow theirs.
    limits: lower and upper position, radians (metres for a prismatic joint), infinite where the
        URDF gives none. velocity_limits: radians (metres) a second, infinite where it gives none.
    openings: joints that are no angles, see `openings.py`.
    warnings: what is not as the URDF says, one plain line each.
    shapes: what is seen of it; a skeleton of its joints where meshes are missing.
    meshes: the mesh files that it names, found or not.
    """

    name: str
    joints: tuple[str, ...]
    limits: dict[str, tuple[float, float]]
    velocity_limits: dict[str, float]
    openings: frozenset[str]
    warnings: tuple[str, ...]
    tree: KinematicTree
    shapes: tuple[Shape, ...]
    meshes: tuple[MeshFile, ...] = ()

    @property
    def missing_meshes(self) -> tuple[str, ...]:
        """As the description names them: nothing of these is shown."""
        return tuple(mesh.name for mesh in self.meshes if mesh.problem)

    def limited(self, joint: str) -> bool:
        """Whether it is a joint of this robot and has any limit."""
        limits = (*self.limits.get(joint, ()), self.velocity_limits.get(joint, np.inf))
        return not np.isinf(limits).all()

    def neutral(self, joint: str) -> float:
        """Where a joint rests that nothing moves: 0, or the nearest value within its limits."""
        lower, upper = self.limits[joint]
        return min(max(0.0, lower), upper)


@dataclass(frozen=True)
class JointMatch:
    """Which joint of a robot goes with which column of a model's motions.

    columns: robot joint -> column. missing: joints of the model that the robot lacks, so that they
    are not seen. unmoved: joints of the robot that the model does not move.
    """

    columns: dict[str, int]
    missing: tuple[str, ...]
    unmoved: tuple[str, ...]


def match_joints(robot: Robot, joints: tuple[str, ...]) -> JointMatch:
    """Match a model's joints with a robot's, by name."""
    return JointMatch(
        {joint: column for column, joint in enumerate(joints) if joint in robot.limits},
        missing=tuple(joint for joint in joints if joint not in robot.limits),
        unmoved=tuple(joint for joint in robot.joints if joint not in joints),
    )


def load_robot(spec: str) -> Robot:
    """Load a robot.

    Args:
        spec: `pepper` (the shipped one), the path of a `.urdf` file, or `NAME_description` of the
            package robot_descriptions, which downloads it once.

    Raises:
        InputError: no such robot, or a file that is no robot description.
    """
    if spec == "pepper":
        return _load(PEPPER_URDF, spec)
    path = Path(spec).expanduser()
    if path.suffix.lower() == ".urdf" or path.is_file():
        return _load(path, path.stem)
    if spec.endswith("_description") and spec.isidentifier():
        return _load(_described(spec), spec.removesuffix("_description"))
    raise InputError(
        f"no robot {spec!r}; give pepper, the path of a .urdf file, or a name that ends in "
        "_description"
    )


def _described(name: str) -> Path:
    """The URDF of a description in the package robot_descriptions, downloaded if need be."""
    try:
        importlib.import_module("robot_descriptions")
    except ImportError as error:
        raise InputError(
            f"{name} comes from the package robot_descriptions; install it with "
            f"pip install 'rnnpb-explorer[{DESCRIPTIONS_EXTRA}]', or give the path of a .urdf file"
        ) from error
    try:
        module = importlib.import_module(f"robot_descriptions.{name}")
    except ModuleNotFoundError as error:
        raise InputError(f"robot_descriptions has no {name}; its README lists the names") from error
    except Exception as error:  # git's own errors: no network, no git, no space
        last = (str(error).strip().splitlines() or [type(error).__name__])[-1]
        reason = last.strip().removeprefix("stderr: ").strip("' ")
        raise InputError(
            f"{name} could not be downloaded ({reason}); it needs git and a network the first "
            "time, or give the path of a .urdf file"
        ) from error
    path = getattr(module, "URDF_PATH", None)
    if path is None:
        raise InputError(f"{name} of robot_descriptions has no URDF")
    return Path(path)


def _load(path: Path, name: str) -> Robot:
    root, warnings = read_urdf(path)
    # Without scene: yourdfpy's own would need every mesh to be there and whole.
    urdf = yourdfpy.URDF.load(
        BytesIO(ElementTree.tostring(root)), build_scene_graph=False, load_meshes=False
    )
    base = _base_link(urdf, path)
    tree, more = build_tree(urdf, base)
    warnings += more
    loose = [link.name for link in urdf.robot.links if link.name not in tree.links]
    if loose:
        warnings.append(f"not joined to {base}, so left out: {some_names(loose)}")
    shapes, meshes, more = load_shapes(urdf, tree, MeshFinder(path))
    warnings += more
    warnings += mesh_warnings(meshes)
    shapes += skeleton(tree, _bare(urdf, tree, shapes), shapes)
    moving = [
        joint
        for joint in urdf.robot.joints
        if joint.type in MOVING_TYPES and joint.mimic is None and joint.parent in tree.links
    ]
    return Robot(
        name,
        tuple(joint.name for joint in moving),
        {joint.name: _limits(joint) for joint in moving},
        {joint.name: _velocity_limit(joint) for joint in moving},
        openings(root),
        tuple(warnings),
        tree,
        shapes,
        meshes,
    )


def _bare(urdf: yourdfpy.URDF, tree: KinematicTree, shapes: tuple[Shape, ...]) -> list[str]:
    """Links of which nothing is seen that should be; all, where nothing of the robot is seen."""
    seen = {shape.link for shape in shapes}
    return [
        link.name
        for link in urdf.robot.links
        if link.name in tree.links and link.name not in seen and (link.visuals or not seen)
    ]


def _base_link(urdf: yourdfpy.URDF, path: Path) -> str:
    """The link that carries the others: of several without a parent, the one with most below it."""
    links = [link.name for link in urdf.robot.links]
    children: dict[str, list[str]] = {}
    parents: dict[str, str] = {}
    for joint in urdf.robot.joints:
        if joint.child in parents:
            raise InputError(f"{path}, joint {joint.name}: link {joint.child} has a parent already")
        parents[joint.child] = joint.parent
        children.setdefault(joint.parent, []).append(joint.child)
    roots = [link for link in links if link not in parents]
    if not roots:
        raise InputError(f"{path} has no base link: its joints run in a circle")

    def below(root: str) -> int:
        found = [root]
        for link in found:
            found += children.get(link, [])
        return len(found)

    return str(max(roots, key=below))


def some_names(names: Sequence[str], most: int = 6) -> str:
    """Names with commas between, and how many more there are."""
    rest = len(names) - most
    return ", ".join(names[:most]) + (f" and {rest} more" if rest > 0 else "")


def _limits(joint: yourdfpy.Joint) -> tuple[float, float]:
    limit = joint.limit
    if joint.type == "continuous" or limit is None:
        return (-np.inf, np.inf)
    lower = -np.inf if limit.lower is None else float(limit.lower)
    upper = np.inf if limit.upper is None else float(limit.upper)
    return (lower, upper) if lower <= upper else (upper, lower)


def _velocity_limit(joint: yourdfpy.Joint) -> float:
    """Descriptions write 0 where they do not know."""
    velocity = joint.limit.velocity if joint.limit is not None else None
    return float(velocity) if velocity else np.inf
