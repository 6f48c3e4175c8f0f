"""The lines that say in words what the landscape board shows."""

from __future__ import annotations

import viser

from ...state.picture import Picture
from ..words import target_label, window_label
from .text import text_lines, write


class ReadoutPanel:
    """The landscape's three numbers, its window, and what it is compared with."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._text = gui.add_html("")

    def show(self, picture: Picture) -> None:
        write(self._text, text_lines(readout(picture)))


def readout(picture: Picture) -> str:
    landscape = picture.landscape
    if landscape is None:
        return "Landscape …"
    values = landscape[1]
    rows, columns = values.correlation.shape
    stage = f"{columns}×{rows} complete" if picture.landscape_complete else "coarse"
    return (
        f"Landscape {stage}: mean {values.mean:.3f}, area {values.area:.3f}, "
        f"roughness {values.roughness:.4f}; window {window_label(picture)}; "
        f"target: {target_label(picture)}"
    )
