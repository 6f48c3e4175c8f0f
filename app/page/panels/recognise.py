"""The Recognise panel: a motion comes in, and the belief (mu, sigma) travels to explain it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import viser

from ....core.belief import LEAST_SCALE
from ....core.recognition_run import Method
from ....robot.description import Robot
from ....robot.reading import NOTHING_SAID, SUFFIXES, Hands, Said, Unit
from ...state import intents as do
from ...state.document import MAX_ITERATIONS, MAX_TRIALS, MIN_OBSERVED, Document
from ...state.facts import Facts
from ...state.on_recognition import shown_iteration
from ...state.picture import Picture
from ...state.wanted import most_iterations
from ..examples import examples
from ..uploads import CODE_SUFFIX, Upload, UploadReader
from ..words import (
    belief_lines,
    joints_line,
    minimised_line,
    nearest_line,
    run_line,
    verdict_lines,
)
from .bound import Bound, assign, on_click
from .curves import RunCurves
from .joints import JointsFolder
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
METHODS: dict[str, Method] = {
    "global: codebook, then Gauss-Newton": "global",
    "live: while the motion plays": "live",
    "as published: sampling and Adam": "paper",
}
METHOD_LABELS = {value: label for label, value in METHODS.items()}
INITS = {
    "learned: best of the learned μ": "learned",
    "baseline: μ = 0": "baseline",
    "random: best of 100 draws": "random",
}
INIT_LABELS = {value: label for label, value in INITS.items()}
BETAS = ("off", "1e-6", "1e-4", "1e-3", "1e-2", "0.1", "1")
MOST_DEGREES = 30.0  # of the error scale's slider


class RecognisePanel:
    """Upload or choose a target, start, watch, pause, scrub, take away."""

    def __init__(self, gui: viser.GuiApi, facts: Facts, robot: Robot, send: Send) -> None:
        self._facts, self._send = facts, send
        self._paused = False
        self._active = 0
        self._said = NOTHING_SAID  # of the file
        self._target_name = ""
        self._reader = UploadReader(robot, send)
        self._examples = {example.name: example for example in examples()}
        self._add_target(gui)
        self._method = self._option(gui.add_dropdown("Method", list(METHODS)), "method", METHODS)
        self._add_run(gui)
        with gui.add_folder("What is observed, and how"):
            self._add_settings(gui)
        self._add_belief(gui)
        with gui.add_folder("Panels of Fig. 5", expand_by_default=False):
            self._curves = RunCurves(gui)
        self._add_take_away(gui)
        self._add_file(gui)

    # --- building ---
    def _add_target(self, gui: viser.GuiApi) -> None:
        self._upload = gui.add_upload_button(
            "Upload a motion",
            icon=viser.Icon.UPLOAD,
            hint="a table of joint angles, an export, an animation; or a state code as a file",
            mime_type=",".join([*SUFFIXES, CODE_SUFFIX, "text/csv", "text/plain"]),
        )
        self._upload.on_upload(self._uploaded)
        motions = gui.add_dropdown("Motion in it", [ONLY], visible=False)
        self._motions = Bound(motions, lambda _: self._again())
        self._example = Bound(
            gui.add_dropdown("Example", [CHOOSE, *self._examples]), self._choose_example
        )
        self._target = gui.add_html("")
        self._show_target = Bound(
            gui.add_checkbox("Show the target", True, hint="on a robot of its own", visible=False),
            lambda value: self._send(do.SetShowTarget(value)),
        )
        self._revealed = Bound(
            gui.add_checkbox(
                "Reveal the rest",
                False,
                hint="what the target does after the observed part, and with hidden joints",
                visible=False,
            ),
            lambda value: self._send(do.SetRevealed(value)),
        )

    def _add_file(self, gui: viser.GuiApi) -> None:
        """What a person may say of the file: it holds for the last one, and for the next."""
        with gui.add_folder("File", expand_by_default=False):
            self._unit = gui.add_dropdown("Angles", list(UNITS))
            self._hands = gui.add_dropdown("Hands", list(HANDS))
            self._rate = gui.add_number(
                "Rate, Hz", 0.0, min=0.0, max=10_000.0, step=0.1, hint="0: as the file says"
            )
        for handle in (self._unit, self._hands, self._rate):
            Bound(handle, lambda _: self._say())

    def _add_settings(self, gui: viser.GuiApi) -> None:
        observed = gui.add_slider(
            "Observed", MIN_OBSERVED, 1.0, 0.05, 0.8, hint="the first part; the rest is foretold"
        )
        self._observed = self._option(observed, "observed")
        self._joints = JointsFolder(gui, self._send)
        self._init = self._option(gui.add_dropdown("Warm start", list(INITS)), "init", INITS)
        self._iterations = self._option(
            gui.add_slider("Iterations", 1, MAX_ITERATIONS, 1, 100), "iterations"
        )
        self._trials = self._option(
            gui.add_slider("Trials", 1, MAX_TRIALS, 1, 1, hint="independent runs in one batch"),
            "trials",
        )
        self._beta = Bound(
            gui.add_dropdown(
                "KL term, β", list(BETAS), hint="the pull of the prior while recognising"
            ),
            lambda label: self._send(do.SetRecognitionOption("beta", _beta(label))),
        )
        self._slow = self._option(
            gui.add_checkbox(
                "Slow enough to watch", False, hint="two or three iterations a second"
            ),
            "slow",
        )

    def _option(self, handle: Any, name: Any, labels: Mapping[str, str] | None = None) -> Bound:
        """A widget that sets one of the next run's settings."""
        return Bound(
            handle,
            lambda value: self._send(
                do.SetRecognitionOption(name, labels[value] if labels else value)
            ),
        )

    def _add_run(self, gui: viser.GuiApi) -> None:
        send = self._send
        self._minimised = gui.add_html("")
        self._start = gui.add_button("Start", icon=viser.Icon.PLAYER_PLAY, color="blue")
        on_click(self._start, lambda: send(do.StartRecognition()))
        self._pause = gui.add_button("Pause the run", icon=viser.Icon.PLAYER_PAUSE, visible=False)
        on_click(self._pause, lambda: send(do.PauseRecognition(not self._paused)))
        self._step = gui.add_button(
            "One step", icon=viser.Icon.PLAYER_SKIP_FORWARD, visible=False, hint="one iteration"
        )
        on_click(self._step, lambda: send(do.StepRecognition()))
        self._cancel = gui.add_button("Cancel", icon=viser.Icon.PLAYER_STOP, visible=False)
        on_click(self._cancel, lambda: send(do.CancelRecognition()))
        self._forget = gui.add_button(
            "Forget the target", icon=viser.Icon.X, color="gray", visible=False
        )
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

    def _add_belief(self, gui: viser.GuiApi) -> None:
        send = self._send
        with gui.add_folder("Belief"):
            self._cloud = Bound(
                gui.add_checkbox(
                    "Cloud on the map", True, hint="Bayes' rule over a codebook, frame by frame"
                ),
                lambda value: send(do.SetCloud(value)),
            )
            self._explanations = Bound(
                gui.add_checkbox(
                    "Explanations as ghosts", True, hint="where more than one remains at the end"
                ),
                lambda value: send(do.SetExplanations(value)),
            )
            self._scale = Bound(
                gui.add_slider(
                    "Error scale, °",
                    round(np.rad2deg(LEAST_SCALE), 1),
                    MOST_DEGREES,
                    0.1,
                    5.7,
                    hint="how far off a right explanation may be: small, and the belief is sure",
                ),
                lambda value: send(do.SetErrorScale(float(np.deg2rad(value)))),
            )
            self._belief = gui.add_html("")

    def _add_take_away(self, gui: viser.GuiApi) -> None:
        send = self._send
        with gui.add_folder("Take it away", expand_by_default=False):
            for label, hint, intent in (
                ("Motion (CSV)", "as it is on the screen", do.DownloadMotion()),
                ("Belief path (CSV)", "a row an iteration", do.TakeAwayRun("path")),
                ("All of it (NPZ)", "arrays for numpy", do.TakeAwayRun("arrays")),
                ("Figure (PNG)", "like Fig. 5 of the paper", do.TakeAwayRun("png")),
                ("Figure (SVG)", "like Fig. 5 of the paper", do.TakeAwayRun("svg")),
            ):
                on_click(gui.add_button(label, hint=hint), partial(send, intent))
            add = gui.add_button("Add to the map", hint="μ and σ as a point of its own")
            on_click(add, lambda: send(do.AddToMap(self._target_name or "my point")))
            self._remove = gui.add_button("Take my points away", visible=False)
            on_click(self._remove, lambda: send(do.RemoveAdded()))

    def show_file(self, file: do.ShowFile) -> None:
        """Offer the motions of a file."""
        self._motions.offer(file.motions or (ONLY,))
        assign(self._motions.handle, visible=len(file.motions) > 1)

    # --- what a person does (viser's event loop: only hand on) ---
    def _read(self, upload: Upload, motion: str | None = None) -> None:
        self._reader.read(replace(upload, said=self._said, motion=motion))

    def _say(self) -> None:
        rate = self._rate.value or None
        self._said = Said(rate, UNITS[self._unit.value], HANDS[self._hands.value])
        self._again()

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
        example = self._examples.get(name)
        if example is None:
            return
        facts = self._facts[self._active]
        joints = example.observed_joints(facts.joints)
        self._send(do.SetRecognitionOption("joints", joints))
        self._read(Upload(f"{name}.csv", example.read, facts))

    # --- what the state says ---
    def show(self, picture: Picture) -> None:
        self._active, self._facts = picture.active, picture.facts
        document = picture.document
        self._show_target_of(document)
        self._show_settings(picture)
        self._show_run(picture)
        self._show_belief(picture)
        self._curves.show(picture)
        own = any(added.model == picture.active for added in document.added)
        assign(self._remove, visible=own)

    def _show_target_of(self, document: Document) -> None:
        target = document.target
        lines = ["No target yet."]
        shown = CHOOSE
        if target is not None:
            lines = [f"Target: {target.name}, {len(target)} frames at {target.fps:g} Hz"]
            example = self._examples.get(target.name)
            if example is not None:
                shown = target.name
                lines.append(example.look_for)
        self._target_name = "" if target is None else target.name
        self._example.show(shown)
        write(self._target, text_lines(*lines))
        for bound, value in (
            (self._show_target, document.show_target),
            (self._revealed, document.revealed),
        ):
            assign(bound.handle, visible=target is not None)
            bound.show(value)

    def _show_settings(self, picture: Picture) -> None:
        settings = picture.document.recognition
        paper, live = settings.method == "paper", settings.method == "live"
        self._method.show(METHOD_LABELS[settings.method])
        self._observed.show(settings.observed)
        self._init.show(INIT_LABELS[settings.init])
        self._iterations.show(settings.iterations)
        self._trials.show(settings.trials)
        self._slow.show(settings.slow)
        self._beta.offer(
            BETAS if _label(settings.beta) in BETAS else (*BETAS, _label(settings.beta))
        )
        self._beta.show(_label(settings.beta))
        for bound in (self._init, self._iterations, self._trials):
            assign(bound.handle, visible=paper)
        assign(self._beta.handle, visible=not live and picture.model.stochastic)
        assign(self._slow.handle, visible=not live)
        self._joints.show(picture)
        lines = [joints_line(picture.document, picture.model), minimised_line(picture)]
        write(self._minimised, text_lines(*lines))

    def _show_run(self, picture: Picture) -> None:
        document = picture.document
        run, running = document.run, document.running
        self._paused = run is not None and run.paused
        assign(self._start, visible=not running, disabled=document.target is None)
        for handle in (self._pause, self._cancel):
            assign(handle, visible=running)
        assign(self._pause, label="Go on with the run" if self._paused else "Pause the run")
        assign(self._step, visible=running and self._paused)
        assign(self._forget, visible=document.target is not None and not running)
        assign(self._progress, visible=running)
        if run is not None and running:
            most = max(most_iterations(document, run.settings), 1)
            assign(self._progress, value=100.0 * min(run.done / most, 1.0))
        lines = [run_line(picture), *verdict_lines(picture)]
        if run is not None and not running:
            lines.append(nearest_line(picture))
        write(self._status, text_lines(*lines))
        self._show_scrub(picture)

    def _show_scrub(self, picture: Picture) -> None:
        run, trace = picture.document.run, picture.trace
        ready = run is not None and run.settled and trace is not None and trace.iterations > 0
        trials = trace.loss.shape[1] if trace is not None else 1
        assign(self._shown.handle, visible=ready)
        assign(self._trial.handle, visible=ready and trials > 1)
        if run is None or trace is None or not ready:
            return
        assign(self._shown.handle, max=max(trace.iterations, 2))
        assign(self._trial.handle, max=max(trials, 2))
        self._shown.show(shown_iteration(run, trace) + 1)
        self._trial.show(min(run.trial, trials - 1) + 1)

    def _show_belief(self, picture: Picture) -> None:
        document = picture.document
        self._cloud.show(document.cloud)
        self._explanations.show(document.explanations)
        self._scale.show(round(float(np.rad2deg(document.error_scale)), 1))
        write(self._belief, text_lines(*belief_lines(picture)))


def _beta(label: str) -> float:
    return 0.0 if label == "off" else float(label)


def _label(beta: float) -> str:
    """The one of BETAS that means the same, or the number."""
    same = (label for label in BETAS if _beta(label) == beta)
    return next(same, f"{beta:g}")
