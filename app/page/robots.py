"""The robots of one page: one a model, and one more for the motion within the limits.

The first one's nodes stand in the server's scene and are shared by all pages; the browser copies
them for the others, and poses them all (`static/web/robots.js`).
"""

from __future__ import annotations

import viser

from ...robot.description import Robot
from ..state.facts import Facts
from ..state.picture import Picture
from .robot_nodes import robot_shown
from .shown import RobotsShown
from .stage import Vector

ROOT = "/robot"
LABEL_ABOVE = 0.1  # metres above the robot's head


def robots_shown(
    robot: Robot, facts: Facts, spots: tuple[Vector, ...], limited_of: int | None
) -> RobotsShown:
    """All robots of a page.

    Args:
        spots: where they stand.
        limited_of: the model whose motion the last one shows within the limits, if there is one.
    """
    models = [*range(len(facts)), *([] if limited_of is None else [limited_of])]
    return RobotsShown(
        tuple(
            robot_shown(
                robot,
                facts[model].joints,
                ROOT,
                spot=spot.tolist(),
                copy_of=None if number == 0 else 0,
            )
            for number, (model, spot) in enumerate(zip(models, spots, strict=False))
        )
    )


class RobotNames:
    """What stands above each robot.

    Args:
        height: metres, of the robot.
    """

    def __init__(self, scene: viser.SceneApi, height: float) -> None:
        self._scene, self._height = scene, height + LABEL_ABOVE
        self._labels: dict[int, viser.LabelHandle] = {}

    def show(self, picture: Picture, spots: tuple[Vector, ...]) -> None:
        names = robot_names(picture)
        for spot in set(self._labels) - set(range(len(names))):
            self._labels.pop(spot).remove()
        for spot, name in enumerate(names):
            if spot not in self._labels:
                x, y, _ = spots[spot].tolist()
                self._labels[spot] = self._scene.add_label(
                    f"/names/{spot}",
                    name,
                    position=(x, y, self._height),
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
