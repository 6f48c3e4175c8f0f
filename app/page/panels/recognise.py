"""The Recognise panel: a motion comes in, and the belief (mu, sigma) travels to explain it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.resources import files
from importlib.resources.abc import Traversable

import numpy as np
import viser

from ....robot.description import Robot
from ....robot.reading import SUFFIXES, Hands, Said, Unit
from ...state import intents as do
from ...state.document import MAX_ITERATIONS, MAX_TRIALS, MIN_OBSERVED, Document
from ...state.facts import Facts
from ...state.on_recognition import shown_iteration
from ...state.picture import Picture
from ...state.results import RecognitionTrace
from ..uploads import CODE_SUFFIX, Upload, UploadReader
from .bound import Bound, on_click
from .text import text_lines, write

Send = Callable[[do.Intent], None]
CHOOSE = "choose …"
ONLY = "the only one"
UNITS: dict[str, Unit | None] = {
    "as the values say": None,
    "radians": "radians",
    "degrees": "degrees",
}
HANDS: dict[str, Hands | None] = {
    "as the values say": None,
    "from 0 to 1": "share",
    "per cent": "percent",
    "degrees": "degrees",
}
INITS = {
    "learned: best of the learned μ": "learned",
    "baseline: μ = 0": "baseline",
    "random: best of 100 draws": "random",
}
INIT_LABELS = {value: label for label, value in INITS.items()}


class RecognisePanel:
    """Upload or choose a target, start, watch, cancel, scrub."""

    def __init__(self, gui: viser.GuiApi, facts: Facts, robot: Robot, send: Send) -> None:
        self._facts = facts
        self._active = 0
        self._reader = UploadReader(robot, send)
        self._upload = gui.add_upload_button(
            "Upload a motion",
            icon=viser.Icon.UPLOAD,
            hint="a table of joint angles, an export, an animation; or a state code as a file",
            mime_type=",".join([*SUFFIXES, CODE_SUFFIX, "text/csv", "text/plain"]),
        )
        self._add_file(gui)
        self._upload.on_upload(self._uploaded)
        self._examples = example_files()
        self._example = Bound(
            gui.add_dropdown("Example", [CHOOSE, *self._examples]), self._choose_example
        )
        self._target = gui.add_html("")
        self._show_target = Bound(
            gui.add_checkbox("Show the target", True, hint="on a robot of its own", visible=False),
            lambda value: send(do.SetShowTarget(value)),
        )
        self._revealed = Bound(
            gui.add_checkbox(
                "Reveal the rest",
                False,
                hint="what the target does after the observed part",
                visible=False,
            ),
            lambda value: send(do.SetRevealed(value)),
        )
        self._init = Bound(
            gui.add_dropdown("Warm start", list(INITS)),
            lambda label: send(do.SetRecognitionOption("init", INITS[label])),
        )
        self._observed = Bound(
            gui.add_slider(
                "Observed",
                MIN_OBSERVED,
                1.0,
                0.05,
                0.8,
                hint="the first part; the rest is foretold",
            ),
            lambda value: send(do.SetRecognitionOption("observed", value)),
        )
        self._iterations = Bound(
            gui.add_slider("Iterations", 1, MAX_ITERATIONS, 1, 100),
            lambda value: send(do.SetRecognitionOption("iterations", value)),
        )
        self._trials = Bound(
            gui.add_slider("Trials", 1, MAX_TRIALS, 1, 1, hint="independent runs in one batch"),
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
        self._drawn: object = None  # the run, its iterations and trial that the curve shows

    def _add_file(self, gui: viser.GuiApi) -> None:
        """What a person may say of the file: it holds for the last one, and for the next."""
        motions = gui.add_dropdown("Motion in it", [ONLY], visible=False)
        with gui.add_folder("File", expand_by_default=False):
            self._unit = gui.add_dropdown("Angles", list(UNITS))
            self._hands = gui.add_dropdown("Hands", list(HANDS))
            self._rate = gui.add_number(
                "Rate, Hz", 0.0, min=0.0, max=10_000.0, step=0.1, hint="0: as the file says"
            )
        self._motions = Bound(motions, lambda _: self._again())
        for handle in (self._unit, self._hands, self._rate):
            Bound(handle, lambda _: self._again())

    def show_file(self, file: do.ShowFile) -> None:
        """Offer the motions of a file."""
        self._motions.offer(file.motions or (ONLY,))
        self._assign(self._motions.handle, visible=len(file.motions) > 1)

    # --- what a person does (viser's event loop: only hand on) ---
    def _read(self, upload: Upload, motion: str | None = None) -> None:
        said = Said(self._rate.value or None, UNITS[self._unit.value], HANDS[self._hands.value])
        self._reader.read(replace(upload, said=said, motion=motion))

    def _again(self) -> None:
        """Read the last file once more, with what is said of it now."""
        last = self._reader.last
        if last is not None:
            motion = self._motions.handle.value
            self._read(last, None if motion == ONLY else motion)

    async def _uploaded(self, event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        file = event.target.value
        content, file.content = file.content, b""  # the handle keeps the file: not its bytes, too
        self._read(Upload(file.name, lambda: content, self._facts[self._active]))

    def _choose_example(self, name: str) -> None:
        if name in self._examples:
            load = self._examples[name].read_bytes
            self._read(Upload(f"{name}.csv", load, self._facts[self._active]))

    # --- what the state says ---
    def show(self, picture: Picture) -> None:
        self._active = picture.active
        document = picture.document
        self._show_settings(document)
        run, running = document.run, document.running
        self._assign(self._start, visible=not running, disabled=document.target is None)
        self._assign(self._cancel, visible=running)
        self._assign(self._forget, visible=document.target is not None and not running)
        self._assign(self._progress, visible=running)
        if run is not None and running:
            self._assign(self._progress, value=100.0 * run.done / run.settings.iterations)
        self._show_scrub(picture)
        write(self._status, text_lines(status_line(picture)))
        self._show_loss(picture)

    def _show_settings(self, document: Document) -> None:
        settings, target = document.recognition, document.target
        self._init.show(INIT_LABELS[settings.init])
        self._observed.show(settings.observed)
        self._iterations.show(settings.iterations)
        self._trials.show(settings.trials)
        if target is None:
            content = "No target yet."
            self._example.show(CHOOSE)
        else:
            content = f"Target: {target.name}, {len(target)} frames at {target.fps:g} Hz"
            self._example.show(target.name if target.name in self._examples else CHOOSE)
        write(self._target, text_lines(content))
        for bound, value in (
            (self._show_target, document.show_target),
            (self._revealed, document.revealed),
        ):
            self._assign(bound.handle, visible=target is not None)
            bound.show(value)

    def _show_scrub(self, picture: Picture) -> None:
        run, trace = picture.document.run, picture.trace
        ready = run is not None and run.settled and trace is not None and trace.iterations > 0
        trials = trace.loss.shape[1] if trace is not None else 1
        self._assign(self._shown.handle, visible=ready)
        self._assign(self._trial.handle, visible=ready and trials > 1)
        if run is None or trace is None or not ready:
            return
        self._assign(self._shown.handle, max=max(trace.iterations, 2))
        self._assign(self._trial.handle, max=max(trials, 2))
        self._shown.show(shown_iteration(run, trace) + 1)
        self._trial.show(run.trial + 1)

    def _show_loss(self, picture: Picture) -> None:
        run, trace = picture.document.run, picture.trace
        trial = 0 if run is None else run.trial
        drawn = None if run is None or trace is None else (run.seed, trace.iterations, trial)
        if drawn == self._drawn:
            return
        self._drawn = drawn
        self._assign(self._loss, visible=trace is not None)
        if trace is not None and trace.iterations > 1:
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


def status_line(picture: Picture) -> str:
    """One line on the run, in words."""
    run, trace = picture.document.run, picture.trace
    if run is None:
        return ""
    if picture.run_status == "running":
        best = "" if trace is None else f", best loss {np.nanmin(trace.loss):.5f}"
        return f"Recognition running: iteration {run.done} of {run.settings.iterations}{best}"
    if picture.run_status == "failed":
        return f"Recognition failed: {picture.run_failure}"
    if picture.run_status == "cancelled":
        return f"Recognition cancelled after {run.done} iterations"
    return "Recognition done" + (f": {best_line(trace)}" if trace is not None else "")


def best_line(trace: RecognitionTrace) -> str:
    iteration, trial = trace.best
    predicted = trace.prediction_error[iteration, trial]
    parts = [
        f"best iterate: {iteration + 1} of trial {trial + 1}",
        f"loss {trace.loss[iteration, trial]:.5f}",
        f"prediction error {predicted:.5f}"
        if np.isfinite(predicted)
        else "nothing left to predict",
    ]
    return ", ".join(parts)
