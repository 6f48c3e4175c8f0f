"""Two ways from the selected motion to another: at a step, before and after the cliff, as one."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ....core.walk import STEPS
from ...state import intents as do
from ...state.picture import Picture
from ..bridge import place_html
from ..words import way_line
from .bound import Bound, assign, on_click
from .text import text_lines, write

Send = Callable[[do.Intent], None]

NO_GOAL = "choose …"
CURVE_HEIGHT = 132  # pixels


class WaysPart:
    """A part of the Explore panel, in the order in which one uses it."""

    def __init__(self, gui: viser.GuiApi, motions: tuple[str, ...], send: Send) -> None:
        self._send = send
        self._steepest = 0
        self._goal = Bound(
            gui.add_dropdown(
                "Way to", [NO_GOAL, *motions], hint="from the selected motion to another"
            ),
            lambda name: send(do.SetGoal("" if name == NO_GOAL else name)),
        )
        self._curve = gui.add_html("")
        self._step = Bound(
            gui.add_slider("Step", 0, STEPS, 1, 0, visible=False, hint="of the way"),
            lambda step: send(do.WalkTo(int(step))),
        )
        self._cliff = gui.add_button_group(
            "Steepest", ("Before", "After"), hint="where the motion changes most", visible=False
        )
        on_click(self._cliff, self._jump)
        self._morph = Bound(
            gui.add_checkbox(
                "As one motion", False, visible=False, hint="the PB moves while the motion plays"
            ),
            lambda on: send(do.WalkTo("morph" if on else None)),
        )
        self._take = gui.add_button(
            "Download it (CSV)", visible=False, icon=viser.Icon.DOWNLOAD, hint="as it is played"
        )
        on_click(self._take, lambda: send(do.DownloadMotion()))
        self._line = gui.add_html("")

    def _jump(self) -> None:
        """To the step before the steepest change, or to the one after it."""
        self._send(do.WalkTo(self._steepest + (self._cliff.value == "After")))

    def show(self, picture: Picture) -> None:
        document, motions = picture.document, picture.model.motions
        self._goal.offer([NO_GOAL, *motions])
        self._goal.show(document.goal if document.goal in motions else NO_GOAL)
        ways, wanted = picture.ways(picture.active), picture.ways_wanted
        if ways is not None:
            self._steepest = ways.straight.steepest
        write(self._curve, place_html("steps", CURVE_HEIGHT) if wanted else "")
        write(self._line, text_lines(way_line(picture)) if wanted else "")
        for bound in (self._step, self._morph):
            assign(bound.handle, visible=wanted)
        assign(self._cliff, visible=ways is not None)
        assign(self._take, visible=wanted and document.walk == "morph")
        self._step.show(document.walk if isinstance(document.walk, int) else 0)
        self._morph.show(document.walk == "morph")
