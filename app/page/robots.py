"""The robots of one browser's scene: one a model, and one more for the limited motion."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from ...robot.description import Robot
from ...robot.kinematics import JointPoses, joint_poses
from ...robot.view import RobotView
from ..state.facts import Facts
from ..state.picture import Picture
from ..state.wanted import eyes_of
from .stage import Vector

LABEL_ABOVE = 0.1  # metres above the robot's head
Positions = NDArray[np.float32]


class Robots:
    """Poses, names and eye colours of all robots.

    Args:
        spots: where they stand; the last one is for the limited motion.
        height: metres, of the robot.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        robot: Robot,
        facts: Facts,
        spots: tuple[Vector, ...],
        height: float,
    ) -> None:
        self._scene, self._robot, self._facts = scene, robot, facts
        self._spots, self._label_height = spots, height + LABEL_ABOVE
        self._views = [self._add(i) for i in range(len(facts))]
        self._limited: RobotView | None = None
        self._poses: dict[int, tuple[Positions, JointPoses]] = {}  # by spot
        self._labels: dict[int, viser.LabelHandle] = {}

    def _add(self, spot: int) -> RobotView:
        x, y, z = self._spots[spot].tolist()
        return RobotView(self._scene, self._robot, f"/robot-{spot}", position=(x, y, z))

    @property
    def have_eyes(self) -> bool:
        """Whether colours of eyes can be seen."""
        return self._views[0].has_eyes

    def show(self, picture: Picture) -> None:
        for index, view in enumerate(self._views):
            motion = picture.motion(index)
            if motion is not None:
                self._move(index, view, motion, picture.frame(index), index)
            self._colour_eyes(view, picture, index)
        self._show_limited(picture)
        self._show_names(picture)

    def _show_limited(self, picture: Picture) -> None:
        spot = len(self._facts)
        if not picture.document.side_by_side:
            if self._limited is not None:
                self._limited.remove()
                self._limited = None
            return
        if self._limited is None:
            self._limited = self._add(spot)
        checked = picture.checked
        if checked is not None and checked.limited is not None:
            frame = picture.frame_of(len(checked.limited))
            self._move(spot, self._limited, checked.limited, frame, picture.active)
        self._colour_eyes(self._limited, picture, picture.active)

    def _move(
        self, spot: int, view: RobotView, positions: Positions, frame: int, model: int
    ) -> None:
        known = self._poses.get(spot)
        if known is None or known[0] is not positions:
            poses = joint_poses(self._robot, self._facts[model].joints, positions)
            self._poses[spot] = known = (positions, poses)
        view.show(known[1], frame)

    def _colour_eyes(self, view: RobotView, picture: Picture, index: int) -> None:
        wanted = picture.document.eyes
        track = eyes_of(self._facts, picture.document, index) if wanted else None
        view.set_eye_colors(None if track is None else track[picture.frame_of(len(track))])

    def _show_names(self, picture: Picture) -> None:
        names = robot_names(picture)
        for spot in set(self._labels) - set(range(len(names))):
            self._labels.pop(spot).remove()
        for spot, name in enumerate(names):
            if spot not in self._labels:
                x, y, _ = self._spots[spot].tolist()
                self._labels[spot] = self._scene.add_label(
                    f"/names/{spot}",
                    name,
                    position=(x, y, self._label_height),
                    font_size_mode="scene",
                    font_scene_height=0.06,
                    anchor="bottom-center",
                )
            elif self._labels[spot].text != name:
                self._labels[spot].text = name


def robot_names(picture: Picture) -> list[str]:
    """What stands above each robot; a lone one needs no name."""
    side_by_side = picture.document.side_by_side
    if len(picture.facts) == 1:
        return ["raw", "limited"] if side_by_side else []
    names = [one.name for one in picture.facts]
    if side_by_side:
        active = names[picture.active]
        names[picture.active] = f"{active}, raw"
        names.append(f"{active}, limited")
    return names
