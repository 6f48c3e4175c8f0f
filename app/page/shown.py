"""What a page shows: each of these goes down as one message, and the newest of its kind wins.

The browser's side is `static/web/messages.js`, under the same names. Arrays travel as float32,
int32 or uint8, rows first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from msgspec import Struct, to_builtins
from numpy.typing import NDArray

from ..state.document import Zoom

Array = NDArray[Any]
Colouring = Literal["class", "valence", "arousal"]


@dataclass(frozen=True, eq=False)
class Shown:
    """One thing that the page shows."""

    @property
    def key(self) -> str:
        """Of messages with equal keys that were not sent yet, only the last is."""
        return type(self).__name__


@dataclass(frozen=True, eq=False, kw_only=True)
class OnBoards(Shown):
    """On a pair of boards. slot: which, of two side by side."""

    slot: int = 0

    @property
    def key(self) -> str:
        name = type(self).__name__
        return f"{name} {self.slot}" if self.slot else name


@dataclass(frozen=True, eq=False)
class RobotShown:
    """A robot of K moving nodes; position in metres, angles in radians.

    name: what it is called.
    root: scene node that carries it. copy_of: index of the robot whose nodes it copies, None where
        it has nodes of its own; a copy has no root in viser's scene.
    nodes: (K,) scene nodes that move, or those of the robot that it copies.
    rest_wxyz, rest_position: (K, 4), (K, 3) pose in the parent's frame at joint position 0.
    axes: (K, 3) unit vectors in the node's frame. sliding: (K,) whether the joint is prismatic.
    columns: (K,) column of the motion that moves the node, -1 for none; factors, offsets: (K,) the
        joint's position is factor * column + offset (a mimic joint's own).
    spot: (3,) where its root stands.
    eyes: scene nodes of the eyes' segments, in the order of the colours.
    """

    name: str
    root: str
    nodes: tuple[str, ...]
    rest_wxyz: Array
    rest_position: Array
    axes: Array
    sliding: Array
    columns: Array
    factors: Array
    offsets: Array
    spot: Array
    eyes: tuple[str, ...] = ()
    copy_of: int | None = None


@dataclass(frozen=True, eq=False)
class RobotsShown(Shown):
    """All robots of the page, once and when one comes or goes."""

    robots: tuple[RobotShown, ...]


@dataclass(frozen=True, eq=False)
class MotionShown(Shown):
    """A robot's motion; the phase of playback stays where it is.

    robot: index among the robots. number: of the motion, for whoever waits for it.
    angles: (T, J) radians. fps: frames a second.
    eyes: (T, 3 * segments) uint8 RGB. ghosts: (K, T, J) shown translucent around it. samples: these
    are samples of one belief, whose envelope is a band.
    ends: whether the robot is gone after its last frame, instead of resting there.
    slot: of the boards whose model generated it; None for other motions.
    """

    robot: int
    number: int
    angles: Array
    fps: float
    eyes: Array | None = None
    ghosts: Array | None = None
    samples: bool = False
    ends: bool = False
    slot: int | None = None

    @property
    def key(self) -> str:
        return f"MotionShown {self.robot}"


@dataclass(frozen=True, eq=False)
class PlaybackShown(Shown):
    """How playback is to go on; a page that has shown this `number` already takes no notice, so
    that what a person does there is not undone by an echo."""

    number: int
    playing: bool
    frame: float
    speed: float
    loop: bool


@dataclass(frozen=True, eq=False)
class MapShown(OnBoards):
    """The map without the puck: all that changes with the model, the axes, the colours.

    model: which one it is of. title: its name. axes: the one or two components that are drawn.
    hidden_axes: at most two that the toggle moves along. axis_labels: of the axes, then of the
    hidden ones.
    points: (N, 2); the second coordinate is 0 where one component is drawn. names: (N,).
    classes: (N,) behaviour classes, '' for none. values: (N,) valence or arousal from 0 to 1, NaN
    for none. selected: index of a motion. extent: (4,) left, right, bottom, top of the whole map.
    pairs: of boards that are shown, 2 where two models are side by side.
    added: (A, 2) points of a person's own, added_names: (A,), added_index: (A,) what to ask for.
    """

    model: int
    title: str
    axes: tuple[int, ...]
    hidden_axes: tuple[int, ...]
    axis_labels: tuple[str, ...]
    points: Array
    names: tuple[str, ...]
    colouring: Colouring
    classes: tuple[str, ...]
    values: Array | None
    selected: int | None
    extent: Array
    pairs: int
    added: Array
    added_names: tuple[str, ...]
    added_index: Array


@dataclass(frozen=True, eq=False)
class PuckShown(OnBoards):
    """Where the puck is, on both boards.

    on_map: (2,). on_landscape: (2,) in its axes. hidden: (H,) along the map's hidden axes.
    covariance: (2, 2) of N(mu, sigma^2) on the map. off_plane: (N,) distance of each learned point
    from the slice that is drawn. extrapolation: distance to the nearest learned point in units of
    their spacing. heard: the greatest `number` of a MoveOnMap or MoveOnLandscape that is in it; an
    older word on the puck does not move it out of the hand.
    """

    on_map: Array
    on_landscape: Array | None
    hidden: Array
    covariance: Array | None = None
    off_plane: Array | None = None
    extrapolation: float | None = None
    heard: int | None = None


@dataclass(frozen=True, eq=False)
class LandscapeShown(OnBoards):
    """correlation: (R, C), row = second axis, both ascending; one row where there is one axis.

    x, y: (C,), (R,) centres of the cells; a coarse stage may have fewer and unevenly spread ones,
    the page interpolates. extent: (4,) left, right, bottom, top of the complete landscape's cells.
    window, target: in words. learned: (M, 2) learned points in the window, learned_index: (M,)
    which motions they are.
    """

    model: int
    correlation: Array
    x: Array
    y: Array
    extent: Array
    complete: bool
    axis_labels: tuple[str, ...]
    window: str
    target: str
    mean: float
    area: float
    roughness: float
    learned: Array | None = None
    learned_index: Array | None = None


@dataclass(frozen=True, eq=False)
class PathShown(OnBoards):
    """A recognition's way: S iterates and M sampled PBs; without any of them nothing is drawn.

    on_map, on_landscape: (S, 2). radii: (S,) sigma in the units of the boards.
    samples_on_map, samples_on_landscape: (M, 2). shown: the iterate up to which it is drawn.
    early: (M,) whether mu jumped to a sample. others_on_map: (K - 1, S, 2) other trials' ways.
    """

    on_map: Array | None
    on_landscape: Array | None
    radii: Array
    samples_on_map: Array | None = None
    samples_on_landscape: Array | None = None
    shown: int = 0
    early: Array | None = None
    others_on_map: Array | None = None


@dataclass(frozen=True, eq=False)
class WaysShown(OnBoards):
    """Two ways from one motion to another, S steps each; nothing where `straight` is None.

    title: of the model. straight, shortest: (S + 1, 2) on the map. changes, shortest_changes: (S,)
    degrees that the motion changes in each step. steepest: of the straight line, from 0. at: the
    step at which the models stand. shares: (T,) how far along a morph is in each frame, 0 to 1.
    """

    title: str
    straight: Array | None = None
    shortest: Array | None = None
    changes: Array | None = None
    shortest_changes: Array | None = None
    steepest: int = 0
    at: int | None = None
    shares: Array | None = None


@dataclass(frozen=True, eq=False)
class CloudShown(OnBoards):
    """The belief over M entries of a codebook while S kept frames come in; nothing where M is 0.

    frames: (S,) the last frame in each. places: (M, 2) on the map. weights: (S, M) uint8, shares of
    the belief, as roots, so that one sees the small ones, 255 for each row's largest. entropy: (S,)
    bits. modes: (G, 2) what it is torn between at the end; mass: (G,) share of the belief; near:
    (G,) the learned motion that is nearest. entries: that were compared.
    """

    frames: Array
    places: Array
    weights: Array
    entropy: Array
    modes: Array
    mass: Array
    near: tuple[str, ...]
    entries: int


@dataclass(frozen=True, eq=False)
class CurvesShown(Shown):
    """What the time bar draws beside the motions of the models on the boards.

    names: (J,) joints. models: (M,) what the curves of each slot are called. columns: (M, J) where
    these joints are in each slot's motion. joint: the one that is drawn, None for all. reference:
    (T', J) dashed, NaN where it is hidden. unseen: (J,) whether a joint is inferred, not observed.
    low, high: (T, J) a band; None takes that of the motion's samples. observed: share of the
    reference that was observed, None without a handle for it.
    active: the slot that all else is of.
    """

    names: tuple[str, ...]
    models: tuple[str, ...]
    columns: Array
    joint: int | None = None
    reference: Array | None = None
    low: Array | None = None
    high: Array | None = None
    unseen: Array | None = None
    observed: float | None = None
    active: int = 0


@dataclass(frozen=True, eq=False)
class LookShown(Shown):
    """Where to look: the boards' zoom, None for the whole; the open tab, '' for the first."""

    map: Zoom | None
    landscape: Zoom | None
    map_2: Zoom | None
    landscape_2: Zoom | None
    tab: str


@dataclass(frozen=True)
class PresenceShown(Shown):
    """Whether this page presents or follows.

    role: 'presents', 'follows' or ''. secret: of who presents, for the tab to keep. code: for the
    link. followers: pages. there: whether somebody presents. free: this page has let go.
    """

    role: str
    secret: str | None
    code: str
    followers: int
    there: bool
    free: bool


@dataclass(frozen=True, eq=False)
class DocumentShown(Shown):
    """The document written down, for the tab to keep and to bring back with its next Hello."""

    text: str


def wire(value: Any) -> Any:
    """A value as the page gets it: dataclasses as dicts, arrays with their shapes."""
    if isinstance(value, np.ndarray):
        return {"shape": list(value.shape), "data": np.ascontiguousarray(_narrow(value)).ravel()}
    if isinstance(value, Struct):
        return to_builtins(value)
    if isinstance(value, tuple):
        return [wire(one) for one in value]
    if hasattr(value, "__dataclass_fields__"):
        return {name: wire(getattr(value, name)) for name in value.__dataclass_fields__}
    return value


def _narrow(array: Array) -> Array:
    """The little-endian type that the page reads numbers of this kind as."""
    kinds = {"f": "<f4", "i": "<i4", "u": "<i4", "b": "|u1"}
    return array if array.dtype == np.uint8 else array.astype(kinds[array.dtype.kind])
