"""The panels: what a person's hand on a widget asks for, and what the widgets say of a picture."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from html import escape
from itertools import combinations
from queue import Queue
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser

from rnnpb_explorer.app.page import uploads
from rnnpb_explorer.app.page.examples import examples
from rnnpb_explorer.app.page.panels.bound import HELD_SECONDS, Bound, on_click
from rnnpb_explorer.app.page.panels.explore import PAGE, ExplorePanel
from rnnpb_explorer.app.page.panels.help import TEXT
from rnnpb_explorer.app.page.panels.recognise import RecognisePanel
from rnnpb_explorer.app.page.panels.view import PCA, ViewPanel, axes_label, parse_axes
from rnnpb_explorer.app.page.uploads import CODE_SUFFIX, Upload, read_upload
from rnnpb_explorer.app.page.words import run_line, target_label, window_label
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.statecode import encode
from rnnpb_explorer.core.motion import format_motion
from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS
from rnnpb_explorer.robot.reading import SUFFIXES

from ..app_states import (
    FACTS,
    MU,
    ONE_DIMENSION,
    TWELVE_DIMENSIONS,
    hand_on,
    make_facts,
    make_target,
    make_trace,
    target_motion,
)
from .pictures import Clock, after, answered, broke_off, came_to, open_screen
from .widgets import hand, labelled

ROBOT = load_robot("pepper")
TIMEOUT = 20.0  # seconds until a test that hangs has failed; nothing waits for it otherwise


def offers(facts: Facts) -> tuple[str, ...]:
    return tuple(one.name for one in facts)


LARGEST = (make_facts(128, "vast"),)
DETERMINISTIC = (make_facts(name="plain", stochastic=False),)
ALL_SIZES = pytest.mark.parametrize(
    "facts",
    [ONE_DIMENSION, FACTS, DETERMINISTIC, TWELVE_DIMENSIONS, LARGEST],
    ids=["D1", "D3", "deterministic", "D12", "D128"],
)


# --- a widget whose value belongs to the state ---
def bound(gui: viser.GuiApi) -> tuple[Bound, list[float], Clock]:
    changed: list[float] = []
    clock = Clock()
    slider = gui.add_slider("x", 0.0, 1.0, 0.01, 0.5)
    return Bound(slider, changed.append, clock), changed, clock


def test_a_person_is_reported_once(gui: viser.GuiApi) -> None:
    widget, changed, _ = bound(gui)
    hand(widget.handle, 0.75)
    assert changed == [0.75]


def test_the_apps_own_hand_is_not_reported(gui: viser.GuiApi) -> None:
    widget, changed, _ = bound(gui)
    widget.show(0.25)
    assert widget.handle.value == 0.25
    event = SimpleNamespace(client=None, client_id=None, target=widget.handle)
    hand_on(widget._on_update(event))  # type: ignore[arg-type]
    assert changed == []


def test_a_widget_in_a_persons_hand_is_left_alone(gui: viser.GuiApi) -> None:
    widget, _, clock = bound(gui)
    hand(widget.handle, 0.75)
    widget.show(0.5)  # a state from a moment ago
    assert widget.handle.value == 0.75
    clock.now += 0.9 * HELD_SECONDS
    widget.show(0.5)
    assert widget.handle.value == 0.75
    clock.now += 0.2 * HELD_SECONDS
    widget.show(0.5)
    assert widget.handle.value == 0.5


def test_a_persons_value_is_not_overwritten_before_it_is_heard_of(gui: viser.GuiApi) -> None:
    widget, changed, _ = bound(gui)
    widget.handle._impl.value = 0.75  # what viser does first; its callbacks come later
    widget.show(0.5)
    hand(widget.handle, widget.handle.value)
    assert changed == [0.75]


def test_a_dropdown_shows_the_state_when_what_it_offers_has_changed(gui: viser.GuiApi) -> None:
    dropdown = gui.add_dropdown("x", ["a", "b"], initial_value="b")
    widget = Bound(dropdown, lambda _: None)
    widget.offer(("c", "d"))
    assert dropdown.value == "c"
    widget.offer(("a", "b"))
    widget.show("b")
    assert dropdown.value == "b"


def test_a_value_that_stands_there_is_not_written_again(gui: viser.GuiApi) -> None:
    written: list[object] = []

    class Handle:
        def on_update(self, _: object) -> None: ...
        @property
        def value(self) -> float:
            return 0.5

        @value.setter
        def value(self, value: float) -> None:
            written.append(value)

    Bound(Handle(), lambda _: None).show(0.5)
    assert written == []


def test_a_button_tells_of_a_persons_press_alone(gui: viser.GuiApi) -> None:
    presses: list[int] = []
    button = gui.add_button("press")
    on_click(button, lambda: presses.append(1))
    hand(button)
    assert presses == [1]


# --- explore ---
@ALL_SIZES
def test_every_dimension_has_sliders_page_by_page(gui: viser.GuiApi, facts: Facts) -> None:
    sent: list[do.Intent] = []
    picture = open_screen(facts)
    panel = ExplorePanel(gui, facts, offers(facts), sent.append)
    panel.show(picture)
    dim = facts[0].pb_dim
    for first in range(0, dim, PAGE):
        if dim > PAGE:
            sent.clear()
            hand(labelled(gui, "Dimensions"), f"{first + 1}–{min(first + PAGE, dim)}")
            assert sent == [do.ShowSliders(first)]
            panel.show(after(picture, do.ShowSliders(first)))
        for index in range(first, min(first + PAGE, dim)):
            slider = labelled(gui, f"μ {index + 1}")
            assert slider.value == pytest.approx(facts[0].mu[0, index])
            assert slider.min <= slider.value <= slider.max
            sent.clear()
            hand(slider, 0.125)
            assert sent == [do.SetMu(index, 0.125)]
            if facts[0].stochastic:
                sent.clear()
                hand(labelled(gui, f"σ {index + 1}"), 0.25)
                assert sent == [do.SetSigma(index, 0.25)]


def test_a_motion_chosen_by_name_is_the_active_models_one(gui: viser.GuiApi) -> None:
    facts = (FACTS[0], make_facts(2, "other", ("bow", "jump", "wave")))
    sent: list[do.Intent] = []
    panel = ExplorePanel(gui, facts, offers(facts), sent.append)
    for index, motion in ((1, 2), (0, 0)):
        panel.show(after(open_screen(facts), do.SelectModel(index)))
        sent.clear()
        hand(labelled(gui, "Motion"), "wave")
        assert sent == [do.SelectMotion(motion)]


def test_a_deterministic_model_has_no_sigma(gui: viser.GuiApi) -> None:
    ExplorePanel(gui, DETERMINISTIC, offers(DETERMINISTIC), lambda _: None).show(
        open_screen(DETERMINISTIC)
    )
    labels = [getattr(h, "label", "") for h in gui._gui_input_handle_from_uuid.values()]
    assert "μ 1" in labels
    assert not any(str(label).startswith("σ") for label in labels)


@pytest.mark.parametrize("value", [19.9, -20.0, 7.3, 1e6, -5e5])
def test_a_slider_widens_for_a_value_beyond_its_end(gui: viser.GuiApi, value: float) -> None:
    panel = ExplorePanel(gui, FACTS, offers(FACTS), lambda _: None)
    panel.show(open_screen())
    panel.show(after(open_screen(), do.SetMu(0, value)))
    slider = labelled(gui, "μ 1")
    assert slider.value == pytest.approx(value)
    assert slider.min <= value <= slider.max


def test_the_buttons_ask_for_what_they_say(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    ExplorePanel(gui, FACTS, offers(FACTS), sent.append).show(open_screen())
    for label, word in (
        *(("Go to", "Reset"), ("Go to", "Random"), ("Go to", "Undo")),
        *(("Noise ε", "New"), ("Noise ε", "None")),
    ):
        hand(labelled(gui, label), word)
    assert sent == [
        do.ResetLatent(),
        do.RandomiseLatent(),
        do.Undo(),
        do.NewNoise(),
        do.ClearNoise(),
    ]


def test_far_from_everything_learnt_the_panel_says_so(gui: viser.GuiApi) -> None:
    panel = ExplorePanel(gui, FACTS, offers(FACTS), lambda _: None)
    panel.show(open_screen())
    assert "Extrapolating" not in panel._note.content
    panel.show(after(open_screen(), do.SetMu(0, 15.0)))
    assert "Extrapolating" in panel._note.content


# --- view ---
@pytest.mark.parametrize("letter", ["PC", "μ"])
def test_a_label_of_axes_says_which_they_are(letter: str) -> None:
    for axes in [(0,), *combinations(range(12), 2), (127, 3)]:
        assert parse_axes(axes_label(letter, axes)) == axes


@ALL_SIZES
def test_the_view_panel_offers_only_axes_that_there_are(gui: viser.GuiApi, facts: Facts) -> None:
    sent: list[do.Intent] = []
    panel = ViewPanel(gui, sent.append)
    picture = open_screen(facts)
    panel.show(picture)
    for bound_ in (panel._map_axes, panel._axes):
        for option in bound_.handle.options:
            sent.clear()
            hand(bound_.handle, option)
            moved = after(picture, *sent).document
            shown = moved.map_axes if bound_ is panel._map_axes else moved.landscape_axes
            assert shown == ("pca" if option == PCA else parse_axes(option))


def test_axes_beyond_those_offered_are_shown_all_the_same(gui: viser.GuiApi) -> None:
    """A state code may hold them."""
    panel = ViewPanel(gui, lambda _: None)
    picture = after(open_screen(LARGEST), do.SetMapAxes((20, 99)))
    panel.show(after(picture, do.SetLandscapeAxes((100, 2))))
    for bound_, label in ((panel._map_axes, "PC21, PC100"), (panel._axes, "μ101, μ3")):
        assert bound_.handle.value == label
        assert label in bound_.handle.options


def test_the_view_panel_asks_for_the_code_and_restores_it(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    panel = ViewPanel(gui, sent.append)
    panel.show(open_screen())
    hand(labelled(gui, "Show the code of this screen"))
    assert labelled(gui, "Code").value == ""  # viser's event loop writes no widget
    panel.show_code("rnnpb2-x")
    assert labelled(gui, "Code").value == "rnnpb2-x"
    hand(labelled(gui, "Restore from the code"))
    hand(labelled(gui, "Code"), "rnnpb2-other")
    panel.show(open_screen())
    assert labelled(gui, "Code").value == "rnnpb2-other"  # shown once for each press
    hand(labelled(gui, "Restore from the code"))
    assert sent == [do.ShowCode(), do.RestoreCode("rnnpb2-x"), do.RestoreCode("rnnpb2-other")]


def test_the_motion_on_the_screen_can_be_downloaded(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    ViewPanel(gui, sent.append)
    hand(labelled(gui, "Download the motion (CSV)"))
    assert sent == [do.DownloadMotion()]


# --- recognise ---
def before_a_run() -> Picture:
    return after(open_screen(), do.SetTarget(make_target()))


def started(iterations: int, trials: int) -> Picture:
    return after(
        before_a_run(),
        do.SetRecognitionOption("iterations", iterations),
        do.SetRecognitionOption("trials", trials),
        do.StartRecognition(),
    )


def in_a_run(trials: int = 2, of: int = 20) -> Picture:
    """Five iterations of a run, which ends after `of`."""
    trace = make_trace(np.linspace(0, 1, 6 * trials * 3).reshape(6, trials, 3))
    return came_to(started(of, trials), trace)


def after_a_run(trials: int = 2) -> Picture:
    return in_a_run(trials, of=5)


def test_without_a_target_nothing_can_be_started(gui: viser.GuiApi) -> None:
    panel = RecognisePanel(gui, FACTS, ROBOT, lambda _: None)
    panel.show(open_screen())
    assert labelled(gui, "Start").disabled
    panel.show(before_a_run())
    assert not labelled(gui, "Start").disabled
    assert "given" in panel._target.content


def test_during_a_run_it_can_be_cancelled_and_its_progress_is_seen(gui: viser.GuiApi) -> None:
    panel = RecognisePanel(gui, FACTS, ROBOT, lambda _: None)
    panel.show(in_a_run())
    assert not labelled(gui, "Start").visible
    assert labelled(gui, "Cancel").visible
    assert not labelled(gui, "Iteration").visible
    assert panel._progress.visible
    assert panel._progress.value == pytest.approx(25.0)  # 5 of 20
    reset = after(in_a_run(), do.SetRecognitionOption("iterations", 1))  # of the next run
    panel.show(reset)
    assert panel._progress.value == pytest.approx(25.0)
    assert "of 20" in run_line(reset)
    panel.show(after(in_a_run(), do.CancelRecognition()))
    assert labelled(gui, "Start").visible
    assert not labelled(gui, "Cancel").visible
    assert not panel._progress.visible


def test_after_a_run_its_iterations_can_be_scrubbed(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    panel = RecognisePanel(gui, FACTS, ROBOT, sent.append)
    picture = after_a_run()
    panel.show(picture)
    iteration, trial = labelled(gui, "Iteration"), labelled(gui, "Trial")
    assert iteration.visible
    assert trial.visible
    assert (iteration.max, trial.max) == (5, 2)
    assert picture.trace is not None
    best = picture.trace.best
    assert (iteration.value, trial.value) == (best[0] + 1, best[1] + 1)
    hand(iteration, 3)
    hand(trial, 1)
    assert sent == [do.ScrubRecognition(2, best[1]), do.ScrubRecognition(2, 0)]


def test_after_a_cancelled_run_the_sliders_say_what_is_on_the_screen(gui: viser.GuiApi) -> None:
    path = np.linspace(0, 1, 5 * 2 * 3).reshape(5, 2, 3)
    loss = np.array([[0.9, 0.8], [0.5, 0.1], [0.6, 0.7], [0.4, 0.3]])  # the best: 2 of trial 2
    trace = make_trace(path, loss=loss)
    panel = RecognisePanel(gui, FACTS, ROBOT, lambda _: None)
    panel.show(after(came_to(started(20, 2), trace), do.CancelRecognition()))
    assert (labelled(gui, "Iteration").value, labelled(gui, "Trial").value) == (4, 1)
    panel.show(came_to(started(4, 2), trace))
    assert (labelled(gui, "Iteration").value, labelled(gui, "Trial").value) == (2, 2)


def test_one_trial_needs_no_choice_of_trials(gui: viser.GuiApi) -> None:
    RecognisePanel(gui, FACTS, ROBOT, lambda _: None).show(after_a_run(trials=1))
    assert not labelled(gui, "Trial").visible


def test_the_settings_ask_for_what_they_say(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    panel = RecognisePanel(gui, FACTS, ROBOT, sent.append)
    panel.show(before_a_run())
    hand(labelled(gui, "Observed"), 0.5)
    hand(labelled(gui, "Iterations"), 40)
    hand(labelled(gui, "Trials"), 3)
    for option in labelled(gui, "Warm start").options:
        hand(labelled(gui, "Warm start"), option)
    for button in ("Start", "Cancel", "Forget the target"):
        hand(labelled(gui, button))
    options = [i for i in sent if isinstance(i, do.SetRecognitionOption)]
    assert [(option.name, option.value) for option in options] == [
        ("observed", 0.5),
        ("iterations", 40),
        ("trials", 3),
        ("init", "learned"),
        ("init", "baseline"),
        ("init", "random"),
    ]
    assert sent[-3:] == [do.StartRecognition(), do.CancelRecognition(), do.ClearTarget()]


def test_the_examples_that_ship_are_targets(
    gui: viser.GuiApi, monkeypatch: pytest.MonkeyPatch
) -> None:
    facts = (make_facts(joints=PEPPER_JOINTS),)
    sent: Queue[do.Intent] = Queue()
    panel = RecognisePanel(gui, facts, ROBOT, sent.put)
    panel.show(open_screen(facts))
    for name in [example.name for example in examples()]:
        hand(labelled(gui, "Example"), name)
        hidden = sent.get(timeout=TIMEOUT)
        assert isinstance(hidden, do.SetRecognitionOption)
        assert hidden.name == "joints"
        intent = sent.get(timeout=TIMEOUT)
        assert isinstance(intent, do.SetTarget)
        assert intent.target.name == name
        assert isinstance(sent.get(timeout=TIMEOUT), do.ShowFile)
        told = sent.get(timeout=TIMEOUT)
        assert isinstance(told, do.Say)
        assert told.good
    monkeypatch.setattr(panel._reader, "read", None)
    hand(labelled(gui, "Example"), "choose …")  # nothing is read


def test_an_example_chosen_while_an_upload_is_read_stays_chosen(
    gui: viser.GuiApi, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, chosen = threading.Event(), threading.Event()

    def read(upload: uploads.Upload, content: bytes, robot: Robot) -> tuple[do.Intent, ...]:
        begun.set()
        assert chosen.wait(TIMEOUT)
        return (do.Say(upload.name),)

    monkeypatch.setattr(uploads, "read_upload", read)
    sent: Queue[do.Intent] = Queue()
    panel = RecognisePanel(gui, FACTS, ROBOT, sent.put)
    upload = panel._upload
    hand(upload, viser.UploadedFile("large.csv", b"..."))
    assert begun.wait(TIMEOUT)
    assert upload.value.content == b""
    name = examples()[0].name
    hand(labelled(gui, "Example"), name)
    chosen.set()
    assert isinstance(sent.get(timeout=TIMEOUT), do.SetRecognitionOption)
    assert sent.get(timeout=TIMEOUT) == do.Say(f"{name}.csv")
    assert sent.empty()


def test_a_state_code_can_be_chosen_among_the_files(gui: viser.GuiApi) -> None:
    """One that is too long for a line is saved as one."""
    sent: Queue[do.Intent] = Queue()
    panel = RecognisePanel(gui, FACTS, ROBOT, sent.put)
    assert CODE_SUFFIX in panel._upload._impl.props.mime_type.split(",")  # type: ignore[attr-defined]
    code = encode(after(open_screen(), do.SetTarget(make_target())).document)
    hand(panel._upload, viser.UploadedFile(f"screen{CODE_SUFFIX}", code.encode()))
    assert sent.get(timeout=TIMEOUT) == do.RestoreCode(code)


def test_the_status_says_how_far_the_run_is() -> None:
    assert run_line(before_a_run()) == ""
    assert "iteration 5 of 20, lowest loss 0.1" in run_line(in_a_run())
    cancelled = after(in_a_run(), do.CancelRecognition())
    assert run_line(cancelled) == "Cancelled after 5 iterations"
    assert run_line(after_a_run()).startswith("Best: iteration 5 of trial 2, loss 0.1")


def test_a_loss_without_prediction_can_be_drawn(gui: viser.GuiApi) -> None:
    panel = RecognisePanel(gui, FACTS, ROBOT, lambda _: None)
    picture = after_a_run()
    assert picture.trace is not None
    picture.trace.prediction_error[:] = math.nan
    panel.show(picture)
    assert len(panel._curves._loss.data[0]) == 5


# --- any panel ---
@pytest.mark.parametrize("name", ["<style>body{display:none}", "*a*", "![a](b.png)", "<b>&amp;"])
def test_names_from_anywhere_stay_text(
    gui: viser.GuiApi, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """viser's markdown renders raw HTML, so it must not hold any of them."""
    markdown, html = record(monkeypatch, gui, "add_markdown"), record(monkeypatch, gui, "add_html")
    joints = tuple(f"{name}{number}" for number in range(5))
    named = target_motion(joints=joints)
    data = (named, None, None, None)
    names = (name, "bow", "rest", "nod")
    facts = (make_facts(name=name, names=names, joints=joints, data=data),)
    panels: list[Any] = [
        RecognisePanel(gui, facts, ROBOT, lambda _: None),
        ExplorePanel(gui, facts, offers(facts), lambda _: None),
        ViewPanel(gui, lambda _: None),
    ]
    content = format_motion(named).encode()
    upload, *_ = read_upload(Upload(f"{name}.csv", lambda: content, facts[0]), content, ROBOT)
    assert isinstance(upload, do.SetTarget)
    uploaded = after(open_screen(facts), upload)
    running = after(uploaded, do.StartRecognition())
    for picture in (answered(uploaded), broke_off(running, f"cell {name}")):
        for panel in panels:
            panel.show(picture)
        assert not any(name in handle.content for handle in markdown)
        written = "".join(handle.content for handle in html)
        assert escape(name) in written
        assert "<style>" not in written
        assert "<b>" not in written


def record(monkeypatch: pytest.MonkeyPatch, gui: viser.GuiApi, name: str) -> list[Any]:
    """What a method of the gui makes from now on."""
    made: list[Any] = []
    make = getattr(gui, name)

    def making(*args: Any, **options: Any) -> Any:
        made.append(make(*args, **options))
        return made[-1]

    monkeypatch.setattr(gui, name, making)
    return made


def test_a_hand_that_is_quicker_than_the_app_finds_every_widget_ready(
    gui: viser.GuiApi, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A person may be at a widget while the ones after it are being made."""
    hasty: list[str] = []
    for kind, register in (
        (viser.GuiInputHandle, "on_update"),
        (viser.GuiButtonHandle, "on_click"),
        (viser.GuiButtonGroupHandle, "on_click"),
        (viser.GuiUploadButtonHandle, "on_upload"),
    ):
        monkeypatch.setattr(kind, register, at_once(getattr(kind, register), hasty))
    picture, sent = open_screen(), Queue[do.Intent]()
    for panel in (
        ExplorePanel(gui, FACTS, offers(FACTS), sent.put),
        RecognisePanel(gui, FACTS, ROBOT, sent.put),
        ViewPanel(gui, sent.put),
    ):
        panel.show(picture)
    assert {"Upload a motion", "Iteration", "Trial", "Code"} <= set(hasty)


def at_once(register: Callable[..., Any], hasty: list[str]) -> Callable[..., Any]:
    """To register a callback of a widget, with a person's hand on it that very moment."""

    def registered(handle: Any, callback: Callable[..., Any]) -> Any:
        result = register(handle, callback)
        hasty.append(handle.label)
        if isinstance(handle, viser.GuiUploadButtonHandle):
            handle._impl.value = viser.UploadedFile("hasty.csv", b"")
        hand_on(callback(SimpleNamespace(client=object(), client_id=0, target=handle)))
        return result

    return registered


def test_the_help_speaks_of_the_screen_as_it_is() -> None:
    for suffix, word in {".csv": "CSV", ".json": "JSON", ".py": "NAOqi script"}.items():
        assert suffix in SUFFIXES
        assert word in TEXT


# --- words ---
def test_the_target_is_called_by_its_name() -> None:
    assert target_label(open_screen()) == "wave (own reconstruction, σ = 0)"
    data = (make_facts(data=(target_motion(), None, None, None)),)
    assert target_label(open_screen(data)) == "wave (data)"
    picture = before_a_run()
    assert target_label(picture) == "given"
    picture = after(picture, do.SetUseTarget(False))
    assert target_label(picture) == "wave (own reconstruction, σ = 0)"


def test_the_window_is_called_by_its_width() -> None:
    assert window_label(open_screen()) == "±1"
    relative = after(open_screen(), do.SetWindow("sd"))
    assert window_label(relative) == f"±0.7 sd (±{0.7 * MU.std(axis=0, ddof=1).mean():.2f})"
