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
            scene.add_glb(
                f"{parent}/shape",
                glb,
                cast_shadow=opacity is None,
                receive_shadow=False,  # shadow maps speckle curved shells
            )

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


BACKDROP = (214, 219, 226)


def setup_stage(scene: viser.SceneApi) -> None:
    """A floor and soft studio light: white shells keep their shape, the floor gets one shadow."""
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map("studio", environment_intensity=0.15)
    scene.set_background_image(np.full((2, 2, 3), BACKDROP, dtype=np.uint8), format="png")
    scene.configure_fog(near=5.0, far=13.0, color=(172, 179, 190))
    scene.add_light_hemisphere(
        "/stage/sky", sky_color=(255, 255, 255), ground_color=(165, 170, 182), intensity=0.85
    )
    scene.add_light_spot(
        "/stage/key",
        position=(3.2, 2.2, 4.5),
        direction=(-3.2, -2.2, -3.9),
        angle=0.8,
        penumbra=1.0,
        decay=0.0,
        intensity=2.1,
        cast_shadow=True,
    )
    scene.add_light_spot(
        "/stage/rim",
        position=(-3.0, -2.5, 2.5),
        direction=(3.0, 2.5, -1.8),
        angle=0.6,
        penumbra=1.0,
        decay=0.0,
        intensity=0.8,
    )
    scene.add_box(
        "/stage/floor",
        color=(206, 212, 220),
        dimensions=(40.0, 40.0, 0.02),
        position=(0.0, 0.0, -0.01),
        cast_shadow=False,
    )
