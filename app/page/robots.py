"""The robots of one page: one a model, one for the motion within the limits, one for the target.

The first one's nodes stand in the server's scene and are shared by all pages; the browser copies
them for the others, and poses them all (`static/web/robots.js`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import viser

from ...robot.description import Robot
from ..state.facts import Facts
from ..state.picture import Picture
from ..state.wanted import given_target
from .robot_nodes import robot_shown
from .shown import RobotsShown
from .stage import Vector

ROOT = "/robot"
LABEL_ABOVE = 0.1  # metres above the robot's head


@dataclass(frozen=True)
class Part:
    """What one robot of a page plays."""

    model: int
    motion: Literal["generated", "limited", "target"] = "generated"


def cast_of(picture: Picture) -> tuple[Part, ...]:
    """All robots of a page: one a model, then what the active one is compared with."""
    document, active = picture.document, picture.active
    parts = [Part(model) for model in range(len(picture.facts))]
    if document.side_by_side:
        parts.append(Part(active, "limited"))
    if document.show_target and given_target(picture.facts, document, active) is not None:
        parts.append(Part(active, "target"))
    return tuple(parts)


def robots_shown(
    robot: Robot, facts: Facts, spots: tuple[Vector, ...], cast: tuple[Part, ...]
) -> RobotsShown:
    """All robots of a page.

    Args:
        spots: where they stand.
    """
    return RobotsShown(
        tuple(
            robot_shown(
                robot,
                facts[part.model].joints,
                ROOT,
                spot=spot.tolist(),
                copy_of=None if number == 0 else 0,
            )
            for number, (part, spot) in enumerate(zip(cast, spots, strict=True))
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
    cast = cast_of(picture)
    if len(cast) == 1:
        return []
    both = picture.document.side_by_side
    names = []
    for part in cast:
        name = picture.facts[part.model].name
        if part.motion == "target":
            names.append("target")
            continue
        if both and part.model == picture.active:
            name += ", limited" if part.motion == "limited" else ", raw"
        if picture.document.ghosts and not picture.facts[part.model].stochastic:
            name += ": no σ, no samples"
        names.append(name)
    return names
