"""The PB map in the scene: learned mu on two principal components, puck, a recognition's path."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import viser

from ...state import intents as do
from ...state.facts import Array
from ...state.picture import Picture
from ..stage import Place
from .board import BoardView, Inputs, Touch
from .drawing import (
    Board,
    PlotFrame,
    PointStyle,
    RecognitionPath,
    axis_names,
    draw_map,
    map_frame,
    style_points,
)
from .paths import recognition_path

CLICK_RADIUS = 0.025  # of the board's width: a click this near to a point selects it
WIDENING = 1.3  # a path that leaves the frame widens it in steps of this factor


class MapView:
    """Draws the map and turns touches into intents."""

    def __init__(
        self,
        scene: viser.SceneApi,
        place: Place,
        picture: Picture,
        send: Callable[[do.Intent], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._send, self._shown = send, picture
        self._frames: dict[tuple[int, tuple[int, ...], int], PlotFrame] = {}
        self._styles: dict[tuple[int, str], PointStyle] = {}
        self._grabbed: tuple[Array, Array] | None = None  # pointer and hidden coordinates at start
        first, inputs = self._draw(picture), self._inputs(picture)
        self.board = BoardView(scene, "map", place, first, inputs, clock)
        self.board.on_touch(self._touched)

    def show(self, picture: Picture) -> None:
        self._shown = picture
        self.board.refresh(self._inputs(picture), lambda: self._draw(picture))
        self.board.show_puck(*self._puck(picture))

    @staticmethod
    def _inputs(picture: Picture) -> Inputs:
        document = picture.document
        return (
            picture.active,
            picture.choice.latent,
            document.map_axes,
            document.colouring,
            document.run,
            0 if picture.trace is None else picture.trace.iterations,
        )

    @staticmethod
    def _puck(picture: Picture) -> tuple[float, float]:
        coordinates = picture.model.latent_map.project(picture.choice.latent.mu)
        drawn = [float(coordinates[axis]) for axis in picture.document.map_axes]
        return drawn[0], drawn[1] if len(drawn) > 1 else 0.0

    # --- the picture ---
    def _draw(self, picture: Picture) -> Board:
        facts, latent = picture.model, picture.choice.latent
        axes, latent_map = picture.document.map_axes, facts.latent_map
        points = latent_map.points[:, list(axes)]
        path = recognition_path(picture, lambda mu: latent_map.project(mu)[..., list(axes)])
        x_label, y_label = axis_names(latent_map.points, axes)
        puck = self._puck(picture)
        return draw_map(
            points,
            frame=self._frame(picture, points, path),
            style=self._style(picture),
            names=facts.motions,
            selected=latent.motion,
            off_plane=latent_map.off_plane(latent.mu, axes) if facts.pb_dim > 2 else None,
            near=puck,
            ellipse=_square(latent_map.ellipse(latent.sigma, axes)) if facts.stochastic else None,
            ellipse_center=puck,
            extrapolation=latent_map.extrapolation(latent.mu),
            path=path,
            x_label=x_label,
            y_label=y_label,
            subtitle=facts.name,
        )

    def _frame(self, picture: Picture, points: Array, path: RecognitionPath | None) -> PlotFrame:
        """One frame a model and pair of axes, widened in steps for a path that leaves it."""
        steps = 0
        middle = points.mean(axis=0)
        if path is not None:
            apart = np.abs(np.asarray(path.mu) - middle)
            reach = float(apart[np.isfinite(apart)].max(initial=0.0))  # a run may have diverged
            own = max(float(np.abs(points - middle).max()), 1e-9)
            steps = max(0, int(np.ceil(np.log(max(reach / own, 1.0)) / np.log(WIDENING))))
        key = (picture.active, picture.document.map_axes, steps)
        if key not in self._frames:
            wide = middle + (points - middle) * WIDENING**steps
            self._frames[key] = map_frame(
                points, include=wide, one_dimensional=points.shape[1] == 1
            )
        return self._frames[key]

    def _style(self, picture: Picture) -> PointStyle:
        colouring, facts = picture.document.colouring, picture.model
        key = (picture.active, colouring)
        if key not in self._styles:
            labels = [facts.labels.get(name) for name in facts.motions]
            if colouring == "class":
                classes = [one.behavior_class if one else "" for one in labels]
                self._styles[key] = style_points("class", classes=classes)
            else:
                values = [getattr(one, colouring) if one else None for one in labels]
                self._styles[key] = style_points(colouring, values=values)
        return self._styles[key]

    # --- touches (viser's event loop: only hand on) ---
    def _touched(self, touch: Touch) -> None:
        picture = self._shown
        if touch.kind == "click" and self._select_near(touch, picture):
            return
        if touch.shift:
            self._move_hidden(touch, picture)
            return
        axes = picture.document.map_axes
        to = self.board.frame.clamp([touch.x, touch.y])[: len(axes)]
        self._send(do.MoveOnMap(picture.active, axes, tuple(to.tolist()), touch.gesture))

    def _select_near(self, touch: Touch, picture: Picture) -> bool:
        """Select the learned motion under a click, if there is one."""
        points = picture.model.latent_map.points[:, list(picture.document.map_axes)]
        points = np.pad(points, ((0, 0), (0, 2 - points.shape[1])))
        frame = self.board.frame
        apart = np.linalg.norm(frame.to_uv(points) - frame.to_uv([touch.x, touch.y]), axis=-1)
        if apart.min() > CLICK_RADIUS:
            return False
        self._send(do.SelectMotion(int(apart.argmin())))
        return True

    def _move_hidden(self, touch: Touch, picture: Picture) -> None:
        """With Shift, the pointer's way moves the two components after the drawn ones."""
        facts, drawn = picture.model, picture.document.map_axes
        hidden = tuple(axis for axis in range(facts.pb_dim) if axis not in drawn)[:2]
        if not hidden:
            return
        pointer = np.array([touch.x, touch.y])
        if touch.kind == "start" or self._grabbed is None:
            coordinates = facts.latent_map.project(picture.choice.latent.mu)
            self._grabbed = (pointer, coordinates[list(hidden)])
        start, coordinates = self._grabbed
        to = coordinates + (pointer - start)[: len(hidden)]
        self._send(do.MoveOnMap(picture.active, hidden, tuple(to.tolist()), touch.gesture))
        if touch.kind == "end":
            self._grabbed = None


def _square(covariance: Array) -> Array:
    """(2, 2) from (2, 2) or (1, 1)."""
    return np.pad(covariance, (0, 2 - len(covariance)))
