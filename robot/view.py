"""A robot in a viser scene: built once, then a frame only assigns the rotations that changed."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import viser

from .description import Robot
from .kinematics import JointPoses, joint_poses
from .meshes import Rgb, to_glb

# Below what a screen shows (0.1 mm at 1 m); a joint of a motion often rests like that.
TOLERANCE = 1e-4


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
        wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0),
        tint: Rgb | None = None,
        opacity: float | None = None,
    ) -> None:
        self.robot = robot
        self._root = scene.add_frame(root, show_axes=False, position=position, wxyz=wxyz)
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
        for index, glb in _glbs(robot, tint, opacity).items():
            parent = root if index < 0 else names[index]
            scene.add_glb(f"{parent}/shape", glb, cast_shadow=opacity is None)

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

    @property
    def visible(self) -> bool:
        return self._root.visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._root.visible = visible

    def remove(self) -> None:
        """Take the robot out of the scene, with everything below its root."""
        self._root.remove()


@lru_cache(maxsize=16)  # every browser session builds the same robot
def _glbs(robot: Robot, tint: Rgb | None, opacity: float | None) -> dict[int, bytes]:
    """One GLB for each moving frame that carries shapes; -1 is the base."""
    carriers = sorted({shape.frame for shape in robot.shapes})
    return {
        index: to_glb([s for s in robot.shapes if s.frame == index], tint, opacity)
        for index in carriers
    }


def setup_stage(scene: viser.SceneApi) -> None:
    """Floor and lights."""
    scene.configure_default_lights(cast_shadow=True)
    scene.add_box(
        "/stage/floor", color=(235, 235, 238), dimensions=(8.0, 8.0, 0.02),
        position=(0.0, 0.0, -0.01), cast_shadow=False,
    )  # fmt: skip
