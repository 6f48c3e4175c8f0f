"""The PB map in the scene: learned mu on two principal components, puck, a recognition's path."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import viser

from ...state import intents as do
from ...state.document import AppState, Array, ModelFacts
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
        facts: tuple[ModelFacts, ...],
        state: AppState,
        send: Callable[[do.Intent], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._facts, self._send = facts, send
        self._state = state
        self._frames: dict[tuple[int, tuple[int, ...], int], PlotFrame] = {}
        self._styles: dict[tuple[int, str], PointStyle] = {}
        self._grabbed: tuple[Array, Array] | None = None  # pointer and hidden coordinates at start
        first, inputs = self._picture(state), self._inputs(state)
        self.board = BoardView(scene, "map", place, first, inputs, clock)
        self.board.on_touch(self._touched)

    def show(self, state: AppState) -> None:
        self._state = state
        self.board.refresh(self._inputs(state), lambda: self._picture(state))
        self.board.show_puck(*self._puck(state))

    @staticmethod
    def _inputs(state: AppState) -> Inputs:
        recognition = state.recognition
        return (
            state.active,
            state.current.latent,
            state.map_axes,
            state.colouring,
            recognition.trace,
            recognition.trial,
            recognition.shown,
        )

    def _puck(self, state: AppState) -> tuple[float, float]:
        coordinates = self._facts[state.active].latent_map.project(state.current.latent.mu)
        drawn = [float(coordinates[axis]) for axis in state.map_axes]
        return drawn[0], drawn[1] if len(drawn) > 1 else 0.0

    # --- the picture ---
    def _picture(self, state: AppState) -> Board:
        facts = self._facts[state.active]
        axes, latent, latent_map = state.map_axes, state.current.latent, facts.latent_map
        points = latent_map.points[:, list(axes)]
        path = recognition_path(state, lambda mu: latent_map.project(mu)[..., list(axes)])
        x_label, y_label = axis_names(latent_map.points, axes)
        puck = self._puck(state)
        return draw_map(
            points,
            frame=self._frame(state, points, path),
            style=self._style(state),
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

    def _frame(self, state: AppState, points: Array, path: RecognitionPath | None) -> PlotFrame:
        """One frame a model and pair of axes, widened in steps for a path that leaves it."""
        steps = 0
        middle = points.mean(axis=0)
        if path is not None:
            apart = np.abs(np.asarray(path.mu) - middle)
            reach = float(apart[np.isfinite(apart)].max(initial=0.0))  # a run may have diverged
            own = max(float(np.abs(points - middle).max()), 1e-9)
            steps = max(0, int(np.ceil(np.log(max(reach / own, 1.0)) / np.log(WIDENING))))
        key = (state.active, state.map_axes, steps)
        if key not in self._frames:
            wide = middle + (points - middle) * WIDENING**steps
            self._frames[key] = map_frame(
                points, include=wide, one_dimensional=points.shape[1] == 1
            )
        return self._frames[key]

    def _style(self, state: AppState) -> PointStyle:
        key = (state.active, state.colouring)
        if key not in self._styles:
            facts = self._facts[state.active]
            labels = [facts.labels.get(name) for name in facts.motions]
            if state.colouring == "class":
                classes = [one.behavior_class if one else "" for one in labels]
                self._styles[key] = style_points("class", classes=classes)
            else:
                values = [getattr(one, state.colouring) if one else None for one in labels]
                self._styles[key] = style_points(state.colouring, values=values)
        return self._styles[key]

    # --- touches (viser's event loop: only hand on) ---
    def _touched(self, touch: Touch) -> None:
        state = self._state
        if touch.kind == "click" and self._select_near(touch, state):
            return
        if touch.shift:
            self._move_hidden(touch, state)
            return
        to = self.board.frame.clamp([touch.x, touch.y])[: len(state.map_axes)]
        self._send(do.MoveOnMap(state.map_axes, tuple(to.tolist()), touch.gesture))

    def _select_near(self, touch: Touch, state: AppState) -> bool:
        """Select the learned motion under a click, if there is one."""
        points = self._facts[state.active].latent_map.points[:, list(state.map_axes)]
        points = np.pad(points, ((0, 0), (0, 2 - points.shape[1])))
        frame = self.board.frame
        apart = np.linalg.norm(frame.to_uv(points) - frame.to_uv([touch.x, touch.y]), axis=-1)
        if apart.min() > CLICK_RADIUS:
            return False
        self._send(do.SelectMotion(int(apart.argmin())))
        return True

    def _move_hidden(self, touch: Touch, state: AppState) -> None:
        """With Shift, the pointer's way moves the two components after the drawn ones."""
        facts = self._facts[state.active]
        hidden = tuple(axis for axis in range(facts.pb_dim) if axis not in state.map_axes)[:2]
        if not hidden:
            return
        pointer = np.array([touch.x, touch.y])
        if touch.kind == "start" or self._grabbed is None:
            coordinates = facts.latent_map.project(state.current.latent.mu)
            self._grabbed = (pointer, coordinates[list(hidden)])
        start, coordinates = self._grabbed
        to = coordinates + (pointer - start)[: len(hidden)]
        self._send(do.MoveOnMap(hidden, tuple(to.tolist()), touch.gesture))
        if touch.kind == "end":
            self._grabbed = None


def _square(covariance: Array) -> Array:
    """(2, 2) from (2, 2) or (1, 1)."""
    return np.pad(covariance, (0, 2 - len(covariance)))
