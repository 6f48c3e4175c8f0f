"""A robot in a viser scene: built once, then a frame only assigns the rotations that changed."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import viser
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .description import Robot
from .kinematics import JointPoses, joint_poses
from .meshes import Shape, to_glb
from .pepper import EYE_LEDS

# Below what a screen shows (0.1 mm at 1 m); a joint of a motion often rests like that.
TOLERANCE = 1e-4
EYE_LINKS = tuple(f"{side}_eye_led_{led}" for side in "rl" for led in range(EYE_LEDS))
EYE_GLOW = (0.28, 0.68, 1.0)  # of eyes that nothing colours
EYE_DARK = 0.17  # an LED that is off is a grey cap, not a hole


class RobotView:
    """One robot in one scene; several may stand side by side under roots of their own.

    Writes are not grouped: wrap `show` in the server's or client's `atomic()`.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        robot: Robot,
        root: str = "/robot",
        *,
        position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self.robot = robot
        self._root = scene.add_frame(root, show_axes=False, position=position)
        rest = joint_poses(robot, (), np.zeros((1, 0)))
        self._wxyz = rest.wxyz[0].copy()  # (K, 4) and (K, 3) as the browser has them
        self._position = rest.position[0].copy()
        names: list[str] = []
        self._frames: list[viser.FrameHandle] = []
        for k, frame in enumerate(robot.tree.frames):
            parent = root if frame.parent < 0 else names[frame.parent]
            names.append(f"{parent}/{frame.joint.replace('/', '_')}")
            self._frames.append(
                scene.add_frame(
                    names[k], show_axes=False, wxyz=self._wxyz[k], position=self._position[k]
                )
            )
        for index, glb in _glbs(robot).items():
            parent = root if index < 0 else names[index]
            # no shadows on it: shadow maps speckle curved shells
            scene.add_glb(f"{parent}/shape", glb, cast_shadow=True, receive_shadow=False)
        self._eyes = self._add_eyes(scene, names)

    def _add_eyes(self, scene: viser.SceneApi, names: list[str]) -> viser.BatchedMeshHandle | None:
        """The LED segments as one node, so that all colours change with one message."""
        tree = self.robot.tree
        segments = {s.link: s for s in self.robot.shapes if s.link in EYE_LINKS}
        if len(segments) < len(EYE_LINKS):
            return None
        carrier = tree.links[EYE_LINKS[0]][0]
        places = np.stack([tree.links[link][1] for link in EYE_LINKS])  # (16, 4, 4) on the head
        mesh = segments[EYE_LINKS[0]].mesh
        relative = places @ np.linalg.inv(places[0])
        return scene.add_batched_meshes_simple(
            f"{names[carrier]}/eyes",
            np.asarray(mesh.vertices, dtype=np.float32),
            np.asarray(mesh.faces, dtype=np.uint32),
            batched_wxyzs=Rotation.from_matrix(relative[:, :3, :3]).as_quat(
                canonical=True, scalar_first=True
            ),
            batched_positions=relative[:, :3, 3],
            batched_colors=_eye_rgb(np.tile(EYE_GLOW, (2, EYE_LEDS, 1))),
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
        )

    def set_eye_colors(self, colors: NDArray[np.floating] | None) -> None:
        """Colour the LEDs around the eyes, where the robot has any.

        Args:
            colors: (2, 8, 3) right and left eye, LED as in `robot.eyes`, RGB from 0 to 1; None for
                the glow at rest.
        """
        if self._eyes is None:
            return
        # viser sends an array only when it differs from the last
        self._eyes.batched_colors = _eye_rgb(
            np.tile(EYE_GLOW, (2, EYE_LEDS, 1)) if colors is None else colors
        )

    @property
    def has_eyes(self) -> bool:
        """Whether `set_eye_colors` shows anything."""
        return self._eyes is not None

    def show(self, poses: JointPoses, frame: int) -> None:
        """Move to one frame of a motion; only what changed since the last is sent."""
        wxyz, position = poses.wxyz[frame], poses.position[frame]
        turned = np.abs(wxyz - self._wxyz).max(axis=1, initial=0.0) > TOLERANCE
        for k in np.flatnonzero(turned):
            self._frames[k].wxyz = wxyz[k]
            self._wxyz[k] = wxyz[k]
        moved = np.abs(position - self._position).max(axis=1, initial=0.0) > TOLERANCE
        for k in np.flatnonzero(moved):
            self._frames[k].position = position[k]
            self._position[k] = position[k]

    def remove(self) -> None:
        """Take the robot out of the scene, with everything below its root."""
        self._root.remove()


@lru_cache(maxsize=16)  # every browser session builds the same robot
def _glbs(robot: Robot) -> dict[int, bytes]:
    """One GLB for each moving frame that carries shapes; -1 is the base."""
    shapes: dict[int, list[Shape]] = {}
    for shape in robot.shapes:
        if shape.link not in EYE_LINKS:
            shapes.setdefault(shape.frame, []).append(shape)
    return {index: to_glb(group) for index, group in sorted(shapes.items())}


def _eye_rgb(colors: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(2, 8, 3) intensities as the (16, 3) colours that are shown."""
    lit = EYE_DARK + (1 - EYE_DARK) * np.clip(np.asarray(colors, dtype=np.float64), 0, 1)
    return np.round(255 * lit.reshape(-1, 3)).astype(np.uint8)
