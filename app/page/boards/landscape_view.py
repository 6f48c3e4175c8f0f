"""The correlation landscape (Fig. 4) in the scene, with the puck and a recognition's path."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import viser

from ....core.windows import Landscape
from ...state import intents as do
from ...state.facts import Array
from ...state.picture import Picture
from ...state.planes import landscape_plane, on_landscape
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
        picture: Picture,
        send: Callable[[do.Intent], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._send = send
        self._drawn: tuple[int, tuple[str, ...]] = (0, ())  # model and axes that are drawn
        first, inputs = self._draw(picture), self._inputs(picture)
        self.board = BoardView(scene, "landscape", place, first, inputs, clock)
        self.board.on_touch(self._touched)

    def show(self, picture: Picture) -> None:
        self.board.refresh(self._inputs(picture), lambda: self._draw(picture))
        where = on_landscape(picture.model, picture.document, picture.choice.latent.mu)
        self.board.show_puck(float(where[0]), float(where[1]) if len(where) > 1 else 0.0)

    @staticmethod
    def _inputs(picture: Picture) -> Inputs:
        return (
            picture.active,
            picture.landscape,
            picture.landscape_complete,
            picture.choice.latent.motion,
            picture.document.run,
            0 if picture.trace is None else picture.trace.iterations,
        )

    def _draw(self, picture: Picture) -> Board:
        facts, document = picture.model, picture.document
        if picture.landscape is None:
            where = landscape_plane(facts, document, picture.choice)
            labels, values = where.labels, _unknown(where.middle, where.radius)
        else:
            work, values = picture.landscape
            labels = work.labels
        values = replace(values, complete=picture.landscape_complete)
        self._drawn = (picture.active, labels)
        learned = on_landscape(facts, document, facts.mu[picture.choice.latent.motion])
        return draw_landscape(
            values,
            x_label=labels[0],
            y_label=labels[1] if len(labels) > 1 else None,
            window=window_label(picture),
            note=f"target: {target_label(picture)}",
            learned=(float(learned[0]), float(learned[1]) if len(learned) > 1 else 0.0),
            path=recognition_path(picture, lambda mu: on_landscape(facts, document, mu)),
        )

    def _touched(self, touch: Touch) -> None:
        model, labels = self._drawn
        to = (touch.x, touch.y)[: len(labels)]
        self._send(do.MoveOnLandscape(model, labels, to, touch.gesture))


def _unknown(middle: Array, radius: float) -> Landscape:
    """What stands on the board until the first landscape is there: zeros, marked as coarse."""
    x = middle[0] + radius * np.linspace(-1, 1, 20)
    y = middle[1] + radius * np.linspace(-1, 1, 20) if len(middle) > 1 else np.zeros(1)
    return Landscape(np.zeros((len(y), len(x)), dtype=np.float32), x, y, complete=False)
