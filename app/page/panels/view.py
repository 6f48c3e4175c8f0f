"""The View panel: what the boards show, and the code that restores the screen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations

import viser

from ....core.windows import Window
from ...state import intents as do
from ...state.document import Colouring
from ...state.picture import Picture
from ...state.wanted import eyes_of
from .bound import Bound, on_click

Send = Callable[[do.Intent], None]

WINDOWS: dict[str, Window] = {
    "±1, as in the paper's Fig. 4": "absolute",
    "±0.7 sd of the learned μ": "sd",
}
COLOURINGS: dict[str, Colouring] = {
    "behaviour class": "class",
    "valence": "valence",
    "arousal": "arousal",
}
PCA = "plane of the map"
MAX_AXES = 8  # 28 pairs are enough to choose from
IN_A_CODE = (
    "A code restores this screen, an uploaded motion and its recognition included, wherever the "
    "same models are loaded. A long one is saved as a file."
)


class ViewPanel:
    """Axes, window, colours, target; download; state code."""

    def __init__(
        self,
        gui: viser.GuiApi,
        send: Send,
        *,
        has_eyes: bool = False,
    ) -> None:
        with gui.add_folder("PB map"):
            self._colouring = Bound(
                gui.add_dropdown("Colour", list(COLOURINGS)),
                lambda label: send(do.SetColouring(COLOURINGS[label])),
            )
            self._map_axes = Bound(
                gui.add_dropdown("Axes", ["PC1, PC2"]),
                lambda label: send(do.SetMapAxes(parse_axes(label))),
            )
        with gui.add_folder("Landscape"):
            self._window = Bound(
                gui.add_dropdown("Window", list(WINDOWS)),
                lambda label: send(do.SetWindow(WINDOWS[label])),
            )
            self._axes = Bound(
                gui.add_dropdown("Axes", ["μ1, μ2"]),
                lambda label: send(
                    do.SetLandscapeAxes("pca" if label == PCA else parse_axes(label))
                ),
            )
            self._use_target = Bound(
                gui.add_checkbox(
                    "Uploaded target", True, hint="compare with it where there is one"
                ),
                lambda value: send(do.SetUseTarget(value)),
            )
        self._ghosts = Bound(
            gui.add_checkbox(
                "Uncertainty", False, hint="samples from N(μ, σ²) around the robot; their band"
            ),
            lambda value: send(do.SetGhosts(value)),
        )
        self._has_eyes = has_eyes
        self._eyes = Bound(
            gui.add_checkbox(
                "Eye colours", True, visible=False, hint="the LEDs as recorded with the motion"
            ),
            lambda value: send(do.SetEyes(value)),
        )
        on_click(gui.add_button("Reset the view", hint="R"), lambda: send(do.ResetView()))
        download = gui.add_button(
            "Download the motion (CSV)", icon=viser.Icon.DOWNLOAD, hint="as it is on the screen"
        )
        on_click(download, lambda: send(do.DownloadMotion()))
        present = gui.add_button(
            "Present this page", icon=viser.Icon.SCREEN_SHARE, hint="others follow it by a link"
        )
        on_click(present, lambda: send(do.PresentPage()))
        with gui.add_folder("State code"):
            self._text = Bound(gui.add_text("Code", ""), lambda _: None)
            on_click(gui.add_button("Show the code of this screen"), lambda: send(do.ShowCode()))
            on_click(
                gui.add_button("Restore from the code"),
                lambda: send(do.RestoreCode(self._text.handle.value)),
            )
            gui.add_markdown(IN_A_CODE)

    def show_code(self, code: str) -> None:
        self._text.handle.value = code

    def show(self, picture: Picture) -> None:
        document = picture.document
        dims = min(picture.model.pb_dim, MAX_AXES)
        pairs: list[tuple[int, ...]] = [*combinations(range(dims), 2)] or [(0,)]
        axes = document.landscape_axes
        shown = (
            axes_label("PC", document.map_axes),
            PCA if axes == "pca" else axes_label("μ", axes),
        )
        self._options(self._map_axes, [axes_label("PC", pair) for pair in pairs], shown[0])
        self._options(self._axes, [*(axes_label("μ", pair) for pair in pairs), PCA], shown[1])
        self._colouring.show(_key(COLOURINGS, document.colouring))
        self._window.show(_key(WINDOWS, document.window))
        self._map_axes.show(shown[0])
        self._axes.show(shown[1])
        self._use_target.show(document.use_target)
        self._ghosts.show(document.ghosts)
        self._eyes.show(document.eyes)
        track = self._has_eyes and eyes_of(picture.facts, document, picture.active) is not None
        if self._eyes.handle.visible != track:
            self._eyes.handle.visible = track

    @staticmethod
    def _options(bound: Bound, options: list[str], shown: str) -> None:
        """Offer these, and what is shown: a state code may hold axes that are not offered."""
        bound.offer(options if shown in options else (*options, shown))


def axes_label(letter: str, axes: tuple[int, ...]) -> str:
    return ", ".join(f"{letter}{axis + 1}" for axis in axes)


def parse_axes(label: str) -> tuple[int, ...]:
    """The axes of a label that `axes_label` made."""
    return tuple(int(part.strip().lstrip("PCμ")) - 1 for part in label.split(","))


def _key(labels: Mapping[str, str], value: str) -> str:
    return next(label for label, known in labels.items() if known == value)
