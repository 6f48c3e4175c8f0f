"""The lines that say in words what the landscape board shows."""

from __future__ import annotations

import viser

from ...state.document import AppState, ModelFacts
from ..words import target_label, window_label
from .text import text_lines, write


class ReadoutPanel:
    """The landscape's three numbers, its window, and what it is compared with."""

    def __init__(self, gui: viser.GuiApi, facts: tuple[ModelFacts, ...]) -> None:
        self._facts = facts
        self._text = gui.add_html("")

    def show(self, state: AppState) -> None:
        write(self._text, text_lines(readout(self._facts[state.active], state)))


def readout(facts: ModelFacts, state: AppState) -> str:
    landscape = state.current.landscape
    if landscape is None:
        return "Landscape …"
    values = landscape.values
    rows, columns = values.correlation.shape
    current = landscape.request == state.current.landscape_request
    stage = f"{columns}×{rows} complete" if values.complete and current else "coarse"
    return (
        f"Landscape {stage}: mean {values.mean:.3f}, area {values.area:.3f}, "
        f"roughness {values.roughness:.4f}; window {window_label(facts, state)}; "
        f"target: {target_label(facts, state)}"
    )
