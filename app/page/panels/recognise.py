"""The Recognise panel: a motion comes in, and the belief (mu, sigma) travels to explain it."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from importlib.resources.abc import Traversable

import numpy as np
import viser

from ...state import intents as do
from ...state.document import AppState, ModelFacts, Recognition, RecognitionTrace
from ..uploads import UploadReader
from .bound import Bound, on_click
from .text import text_lines, write

Send = Callable[[do.Intent], None]
CHOOSE = "choose …"
INITS = {
    "learned: best of the learned μ": "learned",
    "baseline: μ = 0": "baseline",
    "random: best of 100 draws": "random",
}
INIT_LABELS = {value: label for label, value in INITS.items()}


class RecognisePanel:
    """Upload or choose a target, start, watch, cancel, scrub."""

    def __init__(self, gui: viser.GuiApi, facts: tuple[ModelFacts, ...], send: Send) -> None:
        self._facts = facts
        self._active = 0
        self._reader = UploadReader(send)
        self._upload = gui.add_upload_button(
            "Upload a motion",
            icon=viser.Icon.UPLOAD,
            hint="CSV, or what was exported as JSON or NAOqi script",
            mime_type=".csv,.json,.py,text/csv,text/plain",
        )
        self._upload.on_upload(self._uploaded)
        self._examples = example_files()
        self._example = Bound(
            gui.add_dropdown("Example", [CHOOSE, *self._examples]), self._choose_example
        )
        self._target = gui.add_html("")
        self._init = Bound(
            gui.add_dropdown("Warm start", list(INITS)),
            lambda label: send(do.SetRecognitionOption("init", INITS[label])),
        )
        self._observed = Bound(
            gui.add_slider(
                "Observed", 0.1, 1.0, 0.05, 0.8, hint="the first part; the rest is foretold"
            ),
            lambda value: send(do.SetRecognitionOption("observed", value)),
        )
        self._iterations = Bound(
            gui.add_slider("Iterations", 10, 300, 10, 100),
            lambda value: send(do.SetRecognitionOption("iterations", value)),
        )
        self._trials = Bound(
            gui.add_slider("Trials", 1, 10, 1, 1, hint="independent runs in one batch"),
            lambda value: send(do.SetRecognitionOption("trials", value)),
        )
        self._start = gui.add_button("Start", icon=viser.Icon.PLAYER_PLAY, color="blue")
        on_click(self._start, lambda: send(do.StartRecognition()))
        self._cancel = gui.add_button("Cancel", icon=viser.Icon.PLAYER_STOP, visible=False)
        on_click(self._cancel, lambda: send(do.CancelRecognition()))
        self._forget = gui.add_button("Forget the target", icon=viser.Icon.X, visible=False)
        on_click(self._forget, lambda: send(do.ClearTarget()))
        self._progress = gui.add_progress_bar(0.0, visible=False)
        self._status = gui.add_html("")
        shown = gui.add_slider(
            "Iteration", 1, 2, 1, 1, visible=False, hint="look at each belief again"
        )
        trial = gui.add_slider("Trial", 1, 2, 1, 1, visible=False)
        self._shown = Bound(
            shown, lambda value: send(do.ScrubRecognition(value - 1, trial.value - 1))
        )
        self._trial = Bound(
            trial, lambda value: send(do.ScrubRecognition(shown.value - 1, value - 1))
        )
        self._loss = gui.add_uplot(
            (np.array([0.0, 1.0]), np.array([0.0, 0.0]), np.array([0.0, 0.0])),
            (
                {"label": "iteration"},
                {"label": "loss", "stroke": "#1f77b4", "width": 2},
                {"label": "prediction error", "stroke": "#ff7f0e", "width": 1, "dash": (4, 4)},
            ),
            scales={"x": {"time": False}, "y": {"distr": 3}},
            height=170,
            visible=False,
        )
        self._drawn: RecognitionTrace | None = None
        self._drawn_trial = -1

    # --- what a person does (viser's event loop: only hand on) ---
    async def _uploaded(self, event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        file = event.target.value
        content, file.content = file.content, b""  # the handle keeps the file: not its bytes, too
        self._reader.read(file.name, lambda: content, self._facts[self._active])

    def _choose_example(self, name: str) -> None:
        if name in self._examples:
            load = self._examples[name].read_bytes
            self._reader.read(f"{name}.csv", load, self._facts[self._active])

    # --- what the state says ---
    def show(self, state: AppState) -> None:
        self._active = state.active
        recognition = state.recognition
        self._show_settings(recognition)
        running = recognition.status == "running"
        self._assign(self._start, visible=not running, disabled=recognition.target is None)
        self._assign(self._cancel, visible=running)
        self._assign(self._forget, visible=recognition.target is not None and not running)
        trace = recognition.trace
        self._assign(self._progress, visible=running)
        if running:
            done = 0 if trace is None else trace.iterations
            self._assign(self._progress, value=100.0 * done / recognition.planned)
        self._show_scrub(recognition)
        write(self._status, text_lines(status_line(recognition)))
        self._show_loss(recognition)

    def _show_settings(self, recognition: Recognition) -> None:
        self._init.show(INIT_LABELS[recognition.init])
        self._observed.show(recognition.observed)
        self._iterations.show(recognition.iterations)
        self._trials.show(recognition.trials)
        target = recognition.target
        if target is None:
            content = "No target yet."
            self._example.show(CHOOSE)
        else:
            content = f"Target: {target.name}, {len(target)} frames at {target.fps:g} Hz"
            self._example.show(target.name if target.name in self._examples else CHOOSE)
        write(self._target, text_lines(content))

    def _show_scrub(self, recognition: Recognition) -> None:
        trace = recognition.trace
        ready = trace is not None and recognition.status != "running"
        self._assign(self._shown.handle, visible=ready)
        self._assign(
            self._trial.handle, visible=ready and trace is not None and trace.loss.shape[1] > 1
        )
        if trace is None or not ready:
            return
        self._assign(self._shown.handle, max=max(trace.iterations, 2))
        self._assign(self._trial.handle, max=max(trace.loss.shape[1], 2))
        self._shown.show(recognition.iteration + 1)
        self._trial.show(recognition.trial + 1)

    def _show_loss(self, recognition: Recognition) -> None:
        trace = recognition.trace
        if trace is self._drawn and recognition.trial == self._drawn_trial:
            return
        self._drawn, self._drawn_trial = trace, recognition.trial
        self._assign(self._loss, visible=trace is not None)
        if trace is not None and trace.iterations > 1:
            trial = recognition.trial
            self._loss.data = (
                np.arange(1.0, trace.iterations + 1),
                trace.loss[:, trial],
                np.maximum(trace.prediction_error[:, trial], 1e-9),
            )

    @staticmethod
    def _assign(handle: object, **values: object) -> None:
        for name, value in values.items():
            if getattr(handle, name) != value:
                setattr(handle, name, value)


def example_files() -> dict[str, Traversable]:
    """The example motions that ship with the package, by name."""
    folder = files("rnnpb_explorer.static") / "examples"
    if not folder.is_dir():
        return {}
    found = sorted((file for file in folder.iterdir() if file.name.endswith(".csv")), key=str)
    return {file.name.removesuffix(".csv"): file for file in found}


def status_line(recognition: Recognition) -> str:
    """One line on the run, in words."""
    trace = recognition.trace
    done = 0 if trace is None else trace.iterations
    if recognition.status == "running":
        best = "" if trace is None else f", best loss {trace.loss.min():.5f}"
        return f"Recognition running: iteration {done} of {recognition.planned}{best}"
    words = {
        "idle": "",
        "finished": "Recognition done",
        "cancelled": f"Recognition cancelled after {done} iterations",
        "failed": "Recognition failed",
    }
    return ": ".join(part for part in (words[recognition.status], recognition.message) if part)
