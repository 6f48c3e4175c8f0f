"""A board in the scene: a picture that one can click and drag on, with a puck before it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import viser
import viser.transforms
from numpy.typing import NDArray

from ..stage import Place
from .plot import Board

PUCK_RADIUS = 0.016  # metres
PUCK_COLOR = (255, 184, 28)
PUCK_RIM_COLOR = (20, 20, 20)
PUCK_AHEAD = 0.012
REDRAW_SECONDS = 0.12  # at least, between two pictures
JPEG_QUALITY = 90  # a PNG of this size takes ten times as long to pack

# Values that a picture depends on. States share them while nothing changes them.
Inputs = tuple[object, ...]

# Gestures are numbered over all boards and sessions, so that no two are taken for one.
_gestures = itertools.count(1)


@dataclass(frozen=True)
class Touch:
    """A person's hand on a board: where it is in the board's data coordinates."""

    kind: Literal["click", "start", "drag", "end"]
    x: float
    y: float
    gesture: int
    shift: bool


class BoardView:
    """Owns the picture and the puck; what a touch means is the caller's.

    Args:
        first: the picture to begin with; inputs: what it was drawn from.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        name: str,
        place: Place,
        first: Board,
        inputs: Inputs,
        clock: Callable[[], float],
    ) -> None:
        self.place, self.frame = place, first.frame
        self._clock = clock
        self._drawn_from, self._next_redraw = inputs, 0.0
        self._gesture = 0
        axes = np.stack([place.right, -place.up, -place.normal], axis=1)  # rows go downwards
        turn = viser.transforms.SO3.from_matrix(axes).wxyz
        self._image = scene.add_image(
            f"/boards/{name}",
            first.picture,
            place.size,
            place.size,
            format="jpeg",
            jpeg_quality=JPEG_QUALITY,
            cast_shadow=False,
            receive_shadow=False,
            wxyz=turn,
            position=place.center,
        )
        self._puck = scene.add_frame(f"/boards/{name}-puck", show_axes=False, visible=False)
        # A cylinder stands along z; turned like the board it is a disc that lies flat on it.
        self._discs = [
            scene.add_cylinder(
                f"/boards/{name}-puck/{part}",
                radius,
                height,
                color=color,
                wxyz=turn,
                material="toon3",
                cast_shadow=False,
                receive_shadow=False,
            )
            for part, radius, height, color in (
                ("rim", PUCK_RADIUS * 1.3, 0.010, PUCK_RIM_COLOR),
                ("disc", PUCK_RADIUS, 0.016, PUCK_COLOR),
            )
        ]

    def on_touch(self, touched: Callable[[Touch], None]) -> None:
        """Have every touch reported; on viser's event loop, so `touched` only hands on."""
        self._touched = touched
        for handle in (self._image, *self._discs):
            handle.on_drag("left")(self._on_drag)
            handle.on_drag("left", modifier="shift")(self._on_drag)
        self._image.on_click(self._on_click)

    def refresh(self, inputs: Inputs, draw: Callable[[], Board]) -> None:
        """Draw the picture anew where its inputs changed, though not at every step of a drag.

        The puck moves at once; the picture behind it may lag, and catches up with a later call.
        """
        if inputs == self._drawn_from or self._clock() < self._next_redraw:
            return
        self._drawn_from = inputs
        self.show_picture(draw())
        self._next_redraw = self._clock() + REDRAW_SECONDS

    def show_picture(self, board: Board) -> None:
        self.frame = board.frame
        self._image.image = board.picture

    def show_puck(self, x: float, y: float) -> None:
        """Put the puck at data coordinates; off the picture it waits at the rim."""
        at = self.puck_position(x, y)
        if not self._puck.visible:
            self._puck.visible = True
        if not np.allclose(at, self._puck.position, atol=1e-6):
            self._puck.position = at

    @property
    def puck(self) -> NDArray[np.float64]:
        """World position of the puck as it stands."""
        return np.asarray(self._puck.position)

    def puck_position(self, x: float, y: float) -> NDArray[np.float64]:
        """World position of the puck for data coordinates."""
        at = self.frame.to_board(self.frame.clamp([x, y]), self.place.size, self.place.size)
        return self.place.at(float(at[0]), float(at[1]), PUCK_AHEAD)

    async def _on_drag(self, event: viser.SceneNodeDragEvent[Any]) -> None:
        if event.phase == "start":
            self._gesture = next(_gestures)
        kind: Literal["start", "drag", "end"] = "drag" if event.phase == "update" else event.phase
        # viser reports the pointer on a plane that faces the camera, not on the board.
        origin = np.asarray(event.client.camera.position)
        self._touch(kind, origin, np.asarray(event.end_position), event.modifier == "shift")

    async def _on_click(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        self._gesture = next(_gestures)
        origin = np.asarray(event.ray_origin)
        self._touch("click", origin, origin + np.asarray(event.ray_direction), False)

    def _touch(
        self,
        kind: Literal["click", "start", "drag", "end"],
        origin: NDArray[np.float64],
        through: NDArray[np.float64],
        shift: bool,
    ) -> None:
        at = self.place.hit(origin, through)
        if at is None:
            return
        x, y = self.frame.from_board(at, self.place.size, self.place.size)
        if math.isfinite(x) and math.isfinite(y):
            self._touched(Touch(kind, float(x), float(y), self._gesture, shift))
