"""The correlation landscape (Fig. 4) in the scene, with the puck and a recognition's path."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import viser

from ....core.windows import Landscape
from ...state import intents as do
from ...state.document import AppState, Array, ModelFacts
from ...state.slices import landscape_slice, on_landscape
from ..stage import Place
from ..words import target_label, window_label
from .board import BoardView, Inputs, Touch
from .drawing import Board, draw_landscape
from .paths import recognition_path


class LandscapeView:
    """Draws the newest landscape and turns touches into intents."""

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
        self._axes = len(landscape_slice(facts[state.active], state, state.current).labels)
        first, inputs = self._picture(state), self._inputs(state)
        self.board = BoardView(scene, "landscape", place, first, inputs, clock)
        self.board.on_touch(self._touched)

    def show(self, state: AppState) -> None:
        facts = self._facts[state.active]
        self.board.refresh(self._inputs(state), lambda: self._picture(state))
        where = on_landscape(facts, state, state.current.latent.mu)
        self._axes = len(where)
        self.board.show_puck(float(where[0]), float(where[1]) if len(where) > 1 else 0.0)

    @staticmethod
    def _inputs(state: AppState) -> Inputs:
        recognition = state.recognition
        return (
            state.active,
            state.current.landscape,
            state.current.latent.motion,
            recognition.trace,
            recognition.trial,
            recognition.shown,
        )

    def _picture(self, state: AppState) -> Board:
        facts, model = self._facts[state.active], state.current
        where = landscape_slice(facts, state, model)
        computed = model.landscape
        values = _unknown(where.middle, where.radius) if computed is None else computed.values
        learned = on_landscape(facts, state, facts.mu[model.latent.motion])
        return draw_landscape(
            values,
            x_label=where.labels[0],
            y_label=where.labels[1] if len(where.labels) > 1 else None,
            window=window_label(facts, state),
            note=f"target: {target_label(facts, state)}",
            learned=(float(learned[0]), float(learned[1]) if len(learned) > 1 else 0.0),
            path=recognition_path(state, lambda mu: on_landscape(facts, state, mu)),
        )

    def _touched(self, touch: Touch) -> None:
        self._send(do.MoveOnLandscape((touch.x, touch.y)[: self._axes], touch.gesture))


def _unknown(middle: Array, radius: float) -> Landscape:
    """What stands on the board until the first landscape is there: zeros, marked as coarse."""
    x = middle[0] + radius * np.linspace(-1, 1, 20)
    y = middle[1] + radius * np.linspace(-1, 1, 20) if len(middle) > 1 else np.zeros(1)
    return Landscape(np.zeros((len(y), len(x)), dtype=np.float32), x, y, complete=False)
