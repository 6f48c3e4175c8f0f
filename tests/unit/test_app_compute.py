"""The computations behind the screen, on a real, tiny network."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event

import numpy as np
import pytest
import torch
from arm import write_arm

from rnnpb_explorer.app.engine import compute
from rnnpb_explorer.app.engine.compute import Computations
from rnnpb_explorer.app.page.server import ServerOptions, describe_models
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import (
    AppState,
    ExportOptions,
    ModelFacts,
    initial_state,
)
from rnnpb_explorer.app.state.transitions import opening_work
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.core.correlation import landscape
from rnnpb_explorer.core.errors import Cancelled, InputError
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.core.recognition import recognize
from rnnpb_explorer.core.recognition_run import RecognitionConfig, RecognitionStep
from rnnpb_explorer.robot.description import load_robot
from rnnpb_explorer.robot.importing import import_motion
from rnnpb_explorer.robot.safety import check_motion

with TemporaryDirectory() as folder:
    ARM = load_robot(str(write_arm(Path(folder))))


class Undisturbed(Event):
    """Nothing newer ever comes; the wait for a rest is over at once."""

    def wait(self, timeout: float | None = None) -> bool:
        return False


def set_event() -> Event:
    event = Event()
    event.set()
    return event


def one_dimensional() -> RNNPB:
    config = ModelConfig(num_joints=2, pb_dim=1, hidden_size=8, num_motions=2)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        return RNNPB(config, ModelInfo(joints=("a", "b"))).eval().requires_grad_(False)


def motion_work(**changes: object) -> do.GenerateWork:
    work = do.GenerateWork(
        model=0, request=7, pb=np.array([0.1, -0.2, 0.3]), steps=12, motion=1, target=None
    )
    return replace(work, **changes)  # type: ignore[arg-type]


def landscape_work(**changes: object) -> do.LandscapeWork:
    work = do.LandscapeWork(
        model=0,
        request=8,
        center=np.array([0.1, -0.2, 0.3]),
        directions=np.eye(3)[:2],
        zero=np.zeros(3),
        radius=1.0,
        target=None,
        motion=1,
    )
    return replace(work, **changes)  # type: ignore[arg-type]


def recognise_work(model: RNNPB, **changes: object) -> do.RecogniseWork:
    work = do.RecogniseWork(
        model=0,
        request=9,
        target=model.reconstruct(1).numpy(),
        observed=0.7,
        init="baseline",
        iterations=4,
        trials=2,
        seed=3,
    )
    return replace(work, **changes)  # type: ignore[arg-type]


# --- motions ---
def test_a_motion_and_the_reconstruction_that_it_is_compared_with(tiny_model: RNNPB) -> None:
    ready, _ = Computations((tiny_model,), ARM).generate(motion_work(), Event())
    assert isinstance(ready, do.MotionReady)
    assert (ready.model, ready.request) == (0, 7)
    expected = tiny_model.generate(torch.tensor([[0.1, -0.2, 0.3]]), 12)[0].numpy()
    np.testing.assert_allclose(ready.positions, expected, atol=1e-6)
    reconstruction = tiny_model.generate(tiny_model.mu[1:2], 12)[0].numpy()
    np.testing.assert_allclose(ready.reference, reconstruction, atol=1e-6)
    assert type(ready.positions) is type(ready.reference) is np.ndarray
    assert ready.positions.dtype == np.float32


def test_a_target_is_its_own_reference(tiny_model: RNNPB) -> None:
    target = np.ones((9, 5), dtype=np.float32)
    work = motion_work(target=target, steps=9)
    ready, _ = Computations((tiny_model,), ARM).generate(work, Event())
    assert isinstance(ready, do.MotionReady)
    assert ready.reference is target
    assert ready.positions.shape == (9, 5)


def test_each_work_names_its_model(tiny_model: RNNPB) -> None:
    computations = Computations((tiny_model, one_dimensional()), ARM)
    work = motion_work(model=1, pb=np.array([0.5]))
    ready, _ = computations.generate(work, Event())
    assert isinstance(ready, do.MotionReady)
    assert ready.model == 1
    assert ready.positions.shape == (12, 2)


def wild() -> np.ndarray:
    """(12, 5) that break limits of the arm."""
    return np.linspace(0, 4, 60, dtype=np.float32).reshape(12, 5)


def test_after_a_motion_comes_what_it_asks_of_the_robot(tiny_model: RNNPB) -> None:
    """The motion itself never waits for it; it is limited only where that is to be seen."""
    for limited in (False, True):
        far = motion_work(pb=np.array([4.0, -4.0, 4.0]), limited=limited)
        ready, checked = Computations((tiny_model,), ARM).generate(far, Event())
        assert isinstance(ready, do.MotionReady)
        assert isinstance(checked, do.MotionChecked)
        assert (checked.model, checked.checked.request) == (0, 7)
        motion = Motion("", tiny_model.info.joints, ready.positions, tiny_model.info.fps)
        assert checked.checked.report == check_motion(motion, ARM)
        assert checked.checked.report.unchecked == ("e",)
        positions = checked.checked.limited
        assert (positions is not None) == limited
        if positions is not None:
            assert check_motion(replace(motion, positions=positions), ARM).light == "green"


@pytest.mark.parametrize("beyond", [False, True])
def test_an_export_is_within_the_limits_unless_one_insists(tiny_model: RNNPB, beyond: bool) -> None:
    options = ExportOptions("json", beyond_limits=beyond)
    work = do.ExportWork(0, 5, "wave ../../tiny", wild(), options)
    (ready,) = Computations((tiny_model,), ARM).export(work, Event())
    assert isinstance(ready, do.ExportReady)
    assert (ready.request, ready.file_name) == (5, "wave_.._.._tiny.json")
    motion = import_motion(
        ready.content.encode(), ".json", ("a", "b", "c"), name="", source="x", fps=20.0
    )
    assert (check_motion(motion, ARM).light == "green") != beyond
    assert ("beyond the limits" in ready.summary) == beyond
    assert ("limited: " in ready.summary) != beyond


def test_a_download_is_the_file_of_the_motion_itself(tiny_model: RNNPB) -> None:
    work = do.ExportWork(0, 5, "wave", wild(), ExportOptions("csv", beyond_limits=True))
    (ready,) = Computations((tiny_model,), ARM).export(work, Event())
    assert isinstance(ready, do.ExportReady)
    motion = Motion("wave", tiny_model.info.joints, wild(), tiny_model.info.fps)
    assert ready.content == format_motion(motion)


def test_a_robot_without_naoqi_gets_no_script(tiny_model: RNNPB) -> None:
    work = do.ExportWork(0, 5, "wave", wild(), ExportOptions("naoqi"))
    with pytest.raises(InputError, match="NAOqi on Pepper has no joint a"):
        list(Computations((tiny_model,), ARM).export(work, Event()))


# --- landscapes ---
def test_a_landscape_comes_coarse_and_then_complete(tiny_model: RNNPB) -> None:
    computations = Computations((tiny_model,), ARM)
    stages = list(computations.landscape(landscape_work(), Undisturbed()))
    assert all(isinstance(stage, do.LandscapeReady) for stage in stages)
    coarse, complete = (stage.landscape for stage in stages if isinstance(stage, do.LandscapeReady))
    assert (coarse.request, complete.request) == (8, 8)
    assert (coarse.values.complete, complete.values.complete) == (False, True)
    target = tiny_model.reconstruct(1).numpy()
    expected = landscape(tiny_model, target, [0.1, -0.2, 0.3], axes=(0, 1), radius=1.0)
    np.testing.assert_allclose(complete.values.correlation, expected.correlation, atol=1e-6)
    np.testing.assert_allclose(complete.values.x, np.linspace(-0.9, 1.1, 20))
    np.testing.assert_allclose(complete.values.y, np.linspace(-1.2, 0.8, 20))


def test_the_landscape_of_a_target_is_compared_with_it(tiny_model: RNNPB) -> None:
    target = tiny_model.reconstruct(2).numpy()
    work = landscape_work(target=target)
    *_, last = Computations((tiny_model,), ARM).landscape(work, Undisturbed())
    assert isinstance(last, do.LandscapeReady)
    expected = landscape(tiny_model, target, work.center, axes=(0, 1))
    np.testing.assert_allclose(last.landscape.values.correlation, expected.correlation, atol=1e-6)


def test_the_axes_count_from_where_they_are_zero(tiny_model: RNNPB) -> None:
    work = landscape_work(zero=np.array([1.0, 2.0, 3.0]), radius=0.5)
    *_, last = Computations((tiny_model,), ARM).landscape(work, Undisturbed())
    assert isinstance(last, do.LandscapeReady)
    np.testing.assert_allclose(last.landscape.values.x, -0.9 + np.linspace(-0.5, 0.5, 20))
    np.testing.assert_allclose(last.landscape.values.y, -2.2 + np.linspace(-0.5, 0.5, 20))


def test_one_dimension_has_a_line_for_a_landscape() -> None:
    work = landscape_work(center=np.array([0.2]), directions=np.eye(1), zero=np.zeros(1), motion=0)
    *_, last = Computations((one_dimensional(),), ARM).landscape(work, Undisturbed())
    assert isinstance(last, do.LandscapeReady)
    assert last.landscape.values.correlation.shape == (1, 20)


def test_newer_work_gets_the_coarse_landscape_and_no_more(tiny_model: RNNPB) -> None:
    """A drag brings newer work all the time; without the coarse stage nothing would ever show."""
    stages = list(Computations((tiny_model,), ARM).landscape(landscape_work(), set_event()))
    assert len(stages) == 1
    assert isinstance(stages[0], do.LandscapeReady)
    assert not stages[0].landscape.values.complete


def test_newer_work_that_comes_in_the_rest_stops_the_complete_landscape(
    tiny_model: RNNPB,
) -> None:
    cancelled = Event()
    stages = Computations((tiny_model,), ARM).landscape(landscape_work(), cancelled)
    assert next(stages) is not None
    cancelled.set()
    assert list(stages) == []


# --- recognition ---
def test_every_iteration_is_reported_and_then_the_end(tiny_model: RNNPB) -> None:
    computations = Computations((tiny_model,), ARM)
    *steps, end = computations.recognise(recognise_work(tiny_model), Event())
    assert end == do.RecognitionFinished(9)
    traces = [step.trace for step in steps if isinstance(step, do.RecognitionStepped)]
    assert [trace.iterations for trace in traces] == [1, 2, 3, 4]
    last = traces[-1]
    assert last.mu.shape == last.sigma.shape == (5, 2, 3)
    assert last.pb.shape == (4, 2, 3)
    assert last.loss.shape == last.prediction_error.shape == last.early_update.shape == (4, 2)
    for earlier in traces[:-1]:
        np.testing.assert_array_equal(earlier.loss, last.loss[: earlier.iterations])
        np.testing.assert_array_equal(earlier.mu, last.mu[: earlier.iterations + 1])


def test_the_trace_is_what_core_recognises(tiny_model: RNNPB) -> None:
    work = recognise_work(tiny_model)
    *_, stepped, _ = Computations((tiny_model,), ARM).recognise(work, Event())
    assert isinstance(stepped, do.RecognitionStepped)
    config = RecognitionConfig(init="baseline", observed=0.7, iterations=4, trials=2, seed=3)
    steps = list(recognize(tiny_model, work.target, config))
    for index, step in enumerate(steps):
        np.testing.assert_array_equal(stepped.trace.mu[index], step.mu)
        np.testing.assert_array_equal(stepped.trace.pb[index], step.pb)
        np.testing.assert_array_equal(stepped.trace.loss[index], step.loss)
        np.testing.assert_array_equal(stepped.trace.early_update[index], step.early_update)
    np.testing.assert_array_equal(stepped.trace.mu[-1], steps[-1].mu_next)
    np.testing.assert_array_equal(stepped.trace.sigma[-1], steps[-1].sigma_next)


def test_a_cancelled_recognition_ends_without_an_end(tiny_model: RNNPB) -> None:
    cancelled = Event()
    steps = Computations((tiny_model,), ARM).recognise(recognise_work(tiny_model), cancelled)
    assert isinstance(next(steps), do.RecognitionStepped)
    cancelled.set()
    with pytest.raises(Cancelled):
        next(steps)


def test_a_warm_start_is_cancelled_before_it_has_generated_anything(
    tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch
) -> None:
    work = recognise_work(tiny_model, init="random")
    monkeypatch.setattr(tiny_model, "generate", None)
    with pytest.raises(Cancelled):
        next(Computations((tiny_model,), ARM).recognise(work, set_event()))


def test_a_run_keeps_one_path_and_no_motions(
    tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch
) -> None:
    outputs: list[weakref.ref[np.ndarray]] = []

    def watched(*args: object, **options: object) -> Iterator[RecognitionStep]:
        for step in recognize(*args, **options):  # type: ignore[arg-type]
            outputs.append(weakref.ref(step.output))
            yield step

    monkeypatch.setattr(compute, "recognize", watched)
    traces = []
    for one in Computations((tiny_model,), ARM).recognise(recognise_work(tiny_model), Event()):
        if isinstance(one, do.RecognitionStepped):
            traces.append(one.trace)
            assert [output() for output in outputs[:-1]] == [None] * (len(traces) - 1)
    assert len(traces) == 4
    for name in ("mu", "sigma", "pb", "loss", "prediction_error", "early_update"):
        assert np.shares_memory(getattr(traces[0], name), getattr(traces[-1], name)), name


@pytest.mark.parametrize("name", ["mu", "sigma", "pb", "loss", "mu_next", "sigma_next"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_run_that_is_no_longer_finite_fails_and_leaves_what_was(
    tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch, name: str, value: float
) -> None:
    def diverging(*args: object, **options: object) -> Iterator[RecognitionStep]:
        for step in recognize(*args, **options):  # type: ignore[arg-type]
            values = getattr(step, name).copy()
            values[1] = value
            yield replace(step, **{name: values}) if step.iteration == 2 else step

    monkeypatch.setattr(compute, "recognize", diverging)
    facts = describe_models((tiny_model,), ServerOptions(checkpoints=("tiny.pt",)))
    state = settle(facts, tiny_model, *opening_work(facts, initial_state(facts)))
    target = Motion("given", tiny_model.info.joints, tiny_model.reconstruct(1).numpy(), 20.0)
    for intent in (
        do.SetTarget(target),
        do.SetRecognitionOption("trials", 2),
        do.StartRecognition(),
    ):
        state = settle(facts, tiny_model, *update(facts, state, intent))
    recognition = state.recognition
    assert recognition.status == "failed"
    assert recognition.message.endswith("of trial 2 is not finite in iteration 3")
    assert state.notice is not None
    assert state.notice.text == recognition.message
    assert recognition.trace is not None
    assert recognition.trace.iterations == 2
    np.testing.assert_array_equal(state.current.latent.mu, recognition.trace.mu[1, 0])


def test_a_model_that_generates_no_numbers_recognises_nothing(tiny_model: RNNPB) -> None:
    work = recognise_work(tiny_model)
    tiny_model.weight_out *= 1e30
    (end,) = Computations((tiny_model,), ARM).recognise(work, Event())
    assert end == do.WorkFailed(
        "recognition", 9, "the loss of trial 1 is not finite in iteration 1"
    )


def test_a_target_too_short_to_observe_is_bad_input(tiny_model: RNNPB) -> None:
    work = recognise_work(tiny_model, target=np.zeros((2, 5), np.float32), observed=0.1)
    with pytest.raises(InputError):
        list(Computations((tiny_model,), ARM).recognise(work, Event()))


# --- state, computation and state again ---
def settle(
    facts: tuple[ModelFacts, ...], model: RNNPB, state: AppState, works: tuple[do.Work, ...]
) -> AppState:
    """Do all work and what it leads to, as the session does with its lanes."""
    computations = Computations((model,), ARM)
    while works:
        work, *rest = works
        works = tuple(rest)
        results: dict[type, Callable[..., object]] = {
            do.GenerateWork: computations.generate,
            do.LandscapeWork: computations.landscape,
            do.RecogniseWork: computations.recognise,
        }
        if isinstance(work, do.CancelRecogniseWork):
            continue
        for intent in results[type(work)](work, Undisturbed()):  # type: ignore[attr-defined]
            state, more = update(facts, state, intent)
            works += more
    return state


def test_a_screen_of_real_parts_from_opening_to_recognition(tiny_model: RNNPB) -> None:
    facts = describe_models((tiny_model,), ServerOptions(checkpoints=("tiny.pt",)))
    assert facts[0].name == "tiny"
    state = settle(facts, tiny_model, *opening_work(facts, initial_state(facts)))
    assert state.current.motion is not None
    assert state.current.motion.positions.shape == (12, 5)
    np.testing.assert_allclose(
        state.current.motion.positions, state.current.motion.reference, atol=1e-6
    )
    assert state.current.landscape is not None
    assert state.current.landscape.values.complete
    assert state.current.landscape.values.correlation.max() > 0.9  # the middle is the target

    target = Motion("given", tiny_model.info.joints, tiny_model.reconstruct(2).numpy(), 20.0)
    state = settle(facts, tiny_model, *update(facts, state, do.SetTarget(target)))
    state = update(facts, state, do.SetRecognitionOption("iterations", 5))[0]
    state = settle(facts, tiny_model, *update(facts, state, do.StartRecognition()))
    assert state.recognition.status == "finished"
    trace = state.recognition.trace
    assert trace is not None
    assert trace.iterations == 5
    # `learned` starts where the target comes from, and the robot shows the best PB found.
    np.testing.assert_allclose(trace.mu[0, 0], facts[0].mu[2], atol=1e-6)
    iteration, trial = trace.best
    np.testing.assert_allclose(state.current.latent.pb, trace.pb[iteration, trial], atol=1e-5)
    shown = state.current.motion
    assert shown is not None
    observed = int(0.8 * len(target))
    error = np.square(shown.positions - target.positions)[:observed].mean()
    assert error == pytest.approx(trace.loss[iteration, trial], rel=1e-3)
    assert state.current.landscape is not None
    assert state.current.landscape.request == state.current.landscape_request
