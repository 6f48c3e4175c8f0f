"""What the engine computes is what the core computes, in pieces; on real networks."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import torch
from arm import write_arm
from numpy.typing import NDArray

from rnnpb_explorer.app.engine import recognitions
from rnnpb_explorer.app.engine.engine import Delivered, Delivery, Engine, Failed
from rnnpb_explorer.app.engine.generation import FEWEST, OVERHEAD, PIECE
from rnnpb_explorer.app.state.document import MAX_PB, ExportOptions, target_of_motion
from rnnpb_explorer.app.state.results import (
    ExportedFile,
    LandscapeResult,
    MotionResult,
    RecognitionTrace,
)
from rnnpb_explorer.app.state.work import (
    ExportWork,
    LandscapeWork,
    MotionWork,
    RecogniseWork,
    Slot,
    Vector,
    Work,
)
from rnnpb_explorer.core.correlation import landscape, landscape_stages
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.core.recognition import recognition_pieces, recognize
from rnnpb_explorer.core.recognition_run import RecognitionConfig, RecognitionStep
from rnnpb_explorer.core.walk import morph
from rnnpb_explorer.robot.description import load_robot
from rnnpb_explorer.robot.reading import read_motions
from rnnpb_explorer.robot.safety import check_motion

with TemporaryDirectory() as folder:
    ARM = load_robot(str(write_arm(Path(folder))))

PLACES = ("one", "two")  # names of models
TIMEOUT = 60.0  # seconds until a test that hangs has failed
MOTION: Slot = ("motion", 0)
LANDSCAPE: Slot = ("landscape", 0)
RECOGNITION: Slot = ("recognition", 0)
EXPORT: Slot = ("export", 0)
Data = Sequence[Sequence[Motion | None]]
Generated = list[tuple[int, int]]


class Desk:
    """An engine without threads, its clock, and a page of it."""

    def __init__(self, *models: RNNPB, data: Data | None = None, workers: int = 0) -> None:
        self.now = 0.0
        data = data or [[None] * model.config.num_motions for model in models]
        self.engine = Engine(
            dict(zip(PLACES, models, strict=False)),
            dict(zip(PLACES, data, strict=False)),
            ARM,
            workers,
            clock=lambda: self.now,
        )
        self.told: list[Delivery] = []
        self.page = self.engine.open(self.told.append)

    def open(self) -> tuple[Callable[[dict[Slot, Work]], None], list[Delivery]]:
        told: list[Delivery] = []
        return self.engine.open(told.append).want, told

    def run(self) -> None:
        while self.engine.run_one():
            pass

    def results(self, work: Work, slot: Slot = MOTION) -> list[object]:
        """All stages of a work, whatever it has to wait for."""
        self.page.want({slot: work})
        self.run()
        self.now += 1.0
        self.run()
        stages = [one for one in self.told if isinstance(one, Delivered) and one.work == work]
        assert [one.done for one in stages] == [False] * (len(stages) - 1) + [True]
        assert {one.slot for one in stages} == {slot}
        return [one.result for one in stages]


def one_dimensional() -> RNNPB:
    config = ModelConfig(num_joints=2, pb_dim=1, hidden_size=8, num_motions=2)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        return RNNPB(config, ModelInfo(joints=("a", "b"))).eval().requires_grad_(False)


@pytest.fixture
def generated(monkeypatch: pytest.MonkeyPatch) -> Generated:
    """(sequences, frames) of every piece of generation."""
    calls: Generated = []
    in_parts = RNNPB.generate_in_parts

    def counted(model: RNNPB, pb: torch.Tensor, steps: int, at_once: int) -> Iterator[torch.Tensor]:
        for part in in_parts(model, pb, steps, at_once):
            calls.append((len(pb), part.shape[1]))
            yield part

    monkeypatch.setattr(RNNPB, "generate_in_parts", counted)
    return calls


def expected_motion(model: RNNPB, pb: Sequence[float], steps: int) -> NDArray[np.float32]:
    motion: NDArray[np.float32] = model.generate(torch.tensor([pb]), steps)[0].numpy()
    return motion


WAVE = MotionWork("one", (0.1, -0.2, 0.3), 12)


# --- motions ---
def test_a_motion(tiny_model: RNNPB) -> None:
    (result,) = Desk(tiny_model).results(WAVE)
    assert isinstance(result, MotionResult)
    assert result.check is None
    np.testing.assert_allclose(
        result.positions, expected_motion(tiny_model, WAVE.pb, 12), atol=1e-6
    )
    assert type(result.positions) is np.ndarray
    assert result.positions.dtype == np.float32


def test_each_work_names_its_model(tiny_model: RNNPB) -> None:
    (result,) = Desk(tiny_model, one_dimensional()).results(MotionWork("two", (0.5,), 12))
    assert isinstance(result, MotionResult)
    assert result.positions.shape == (12, 2)


@pytest.mark.parametrize("limited", [False, True])
def test_after_a_motion_comes_what_it_asks_of_the_robot(tiny_model: RNNPB, limited: bool) -> None:
    """The motion itself never waits for it; it is limited only where that is to be seen."""
    far = MotionWork("one", (4.0, -4.0, 4.0), 12, check="limited" if limited else "report")
    first, second = Desk(tiny_model).results(far)
    assert isinstance(first, MotionResult)
    assert isinstance(second, MotionResult)
    assert first.check is None
    assert second.positions is first.positions
    assert second.check is not None
    motion = Motion("", tiny_model.info.joints, first.positions, tiny_model.info.fps)
    assert second.check.report == check_motion(motion, ARM)
    assert second.check.report.unchecked == ("d", "e")
    positions = second.check.limited
    assert (positions is not None) == limited
    if positions is not None:
        assert check_motion(replace(motion, positions=positions), ARM).light == "grey"


def test_motions_of_several_pages_are_generated_in_one_batch(
    tiny_model: RNNPB, generated: Generated
) -> None:
    desk = Desk(tiny_model)
    works = [MotionWork("one", (0.1 * number, 0.2, 0.3), 9 + 3 * number) for number in range(3)]
    pages = [desk.open() for _ in works]
    for (want, _), work in zip(pages, works, strict=True):
        want({MOTION: work, ("reference", 0): replace(work, pb=(0.0, 0.0, 1.0))})
    desk.run()
    assert generated == [(6, 15)]  # as long as the longest
    for (_, told), work in zip(pages, works, strict=True):
        moved = {one.slot: one.result for one in told if isinstance(one, Delivered)}[MOTION]
        assert isinstance(moved, MotionResult)
        expected = expected_motion(tiny_model, work.pb, work.steps)
        np.testing.assert_allclose(moved.positions, expected, atol=1e-6)
        assert moved.positions.base is None  # it does not keep the batch


def test_a_batch_is_as_large_as_a_piece(tiny_model: RNNPB, generated: Generated) -> None:
    desk = Desk(tiny_model)
    pages = [desk.open() for _ in range(20)]
    for number, (want, _) in enumerate(pages):
        want({MOTION: MotionWork("one", (0.1 * number, 0.2, 0.3), 140)})
    desk.run()
    assert generated == [(16, 140), (4, 140)]


def test_models_have_batches_of_their_own(tiny_model: RNNPB, generated: Generated) -> None:
    other = deepcopy(tiny_model)
    other.weight_out *= 2.0
    desk = Desk(tiny_model, other)
    desk.page.want({MOTION: WAVE, ("motion", 1): replace(WAVE, model="two")})
    desk.run()
    assert generated == [(1, 12), (1, 12)]
    for told, model in zip(desk.told, (tiny_model, other), strict=True):
        assert isinstance(told, Delivered)
        assert isinstance(told.result, MotionResult)
        expected = expected_motion(model, WAVE.pb, 12)
        np.testing.assert_allclose(told.result.positions, expected, atol=1e-6)


def test_a_long_motion_is_generated_in_parts(tiny_model: RNNPB, generated: Generated) -> None:
    (result,) = Desk(tiny_model).results(replace(WAVE, steps=1_300))
    assert isinstance(result, MotionResult)
    assert [batch for batch, _ in generated] == [1, 1, 1]
    assert sum(frames for _, frames in generated) == 1_300
    assert max(frames for _, frames in generated) * (1 + OVERHEAD) <= PIECE
    expected = expected_motion(tiny_model, WAVE.pb, 1_300)
    np.testing.assert_allclose(result.positions, expected, atol=1e-5)


def test_a_motion_that_is_being_generated_comes_although_there_is_newer_work(
    tiny_model: RNNPB,
) -> None:
    """A hand that moves faster than motions come would see none otherwise."""
    desk = Desk(tiny_model)
    desk.page.want({MOTION: WAVE})
    ((job, task),) = desk.engine._schedule.take(0.0)
    newer = replace(WAVE, pb=(0.2, 0.2, 0.2))
    desk.page.want({MOTION: newer})
    desk.engine._do([(job, task)])
    desk.run()
    assert [one.work for one in desk.told] == [WAVE, newer]


def test_a_pb_that_does_not_fit_costs_only_its_own_page(
    tiny_model: RNNPB, caplog: pytest.LogCaptureFixture
) -> None:
    desk = Desk(tiny_model)
    want, told = desk.open()
    desk.page.want({MOTION: WAVE})
    want({MOTION: replace(WAVE, pb=(0.1,))})
    desk.run()
    assert isinstance(desk.told[0], Delivered)
    assert [type(one) for one in told] == [Failed]


# --- landscapes ---
def landscape_work(**changes: object) -> LandscapeWork:
    work = LandscapeWork(
        model="one",
        center=(0.1, -0.2, 0.3),
        directions=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        zero=(0.0, 0.0, 0.0),
        radius=1.0,
        target=None,
        motion=1,
    )
    return replace(work, **changes)  # type: ignore[arg-type]


def landscapes(desk: Desk, work: LandscapeWork) -> list[LandscapeResult]:
    results = desk.results(work, LANDSCAPE)
    assert all(isinstance(result, LandscapeResult) for result in results)
    return results  # type: ignore[return-value]


def test_a_landscape_comes_coarse_and_then_complete(tiny_model: RNNPB) -> None:
    coarse, complete = landscapes(Desk(tiny_model), landscape_work())
    assert (coarse.values.complete, complete.values.complete) == (False, True)
    target = tiny_model.reconstruct(1).numpy()
    stages = landscape_stages(tiny_model, target, [0.1, -0.2, 0.3], axes=(0, 1), radius=1.0)
    for one, expected in zip((coarse.values, complete.values), stages, strict=True):
        np.testing.assert_allclose(one.correlation, expected.correlation, atol=1e-6)
    np.testing.assert_allclose(complete.values.x, np.linspace(-0.9, 1.1, 20))
    np.testing.assert_allclose(complete.values.y, np.linspace(-1.2, 0.8, 20))


@pytest.mark.parametrize("given", ["target", "data"])
def test_a_landscape_is_compared_with_a_given_motion_or_with_the_data(
    tiny_model: RNNPB, given: str
) -> None:
    motion = Motion("given", tiny_model.info.joints, tiny_model.reconstruct(2).numpy(), 20.0)
    if given == "target":
        desk = Desk(tiny_model)
        work = landscape_work(target=target_of_motion(motion), motion=-1)
    else:
        desk, work = Desk(tiny_model, data=[[None, motion, None]]), landscape_work()
    last = landscapes(desk, work)[-1]
    expected = landscape(tiny_model, motion.positions, work.center, axes=(0, 1))
    np.testing.assert_allclose(last.values.correlation, expected.correlation, atol=1e-6)


def test_the_axes_count_from_where_they_are_zero(tiny_model: RNNPB) -> None:
    work = landscape_work(zero=(1.0, 2.0, 3.0), radius=0.5)
    last = landscapes(Desk(tiny_model), work)[-1]
    np.testing.assert_allclose(last.values.x, -0.9 + np.linspace(-0.5, 0.5, 20))
    np.testing.assert_allclose(last.values.y, -2.2 + np.linspace(-0.5, 0.5, 20))


def test_one_dimension_has_a_line_for_a_landscape() -> None:
    work = landscape_work(center=(0.2,), directions=((1.0,),), zero=(0.0,), motion=0)
    last = landscapes(Desk(one_dimensional()), work)[-1]
    assert last.values.correlation.shape == (1, 20)


def test_a_target_that_does_not_fit_is_bad_input(tiny_model: RNNPB) -> None:
    desk = Desk(tiny_model)
    target = target_of_motion(Motion("two", ("a", "b"), np.zeros((9, 2), np.float32)))
    desk.page.want({LANDSCAPE: landscape_work(target=target, motion=-1)})
    desk.run()
    (failed,) = desk.told
    assert isinstance(failed, Failed)
    assert "shape (9, 2)" in failed.message


def test_newer_work_gets_the_coarse_landscape_and_no_more(tiny_model: RNNPB) -> None:
    """A drag brings newer work all the time; without the coarse stage nothing would ever show."""
    desk = Desk(tiny_model)
    desk.page.want({LANDSCAPE: landscape_work()})
    desk.engine.run_one()
    desk.now = 1.0
    desk.page.want({LANDSCAPE: landscape_work(radius=0.5)})
    desk.run()
    stages = [
        (one.work.radius, one.done)  # type: ignore[union-attr]
        for one in desk.told
        if isinstance(one, Delivered)
    ]
    assert stages == [(1.0, False), (0.5, False)]


def test_a_complete_landscape_waits_for_the_hand_to_rest(
    tiny_model: RNNPB, generated: Generated
) -> None:
    desk = Desk(tiny_model)
    desk.now = 5.0
    desk.page.want({LANDSCAPE: landscape_work()})
    desk.now = 5.1499  # a rest is 0.15 s from when it was wanted
    desk.run()
    assert sum(batch for batch, _ in generated) == 1 + 36
    assert [one.done for one in desk.told if isinstance(one, Delivered)] == [False]
    desk.now = 5.1501
    desk.run()
    assert sum(batch for batch, _ in generated) == 1 + 400
    assert [one.done for one in desk.told if isinstance(one, Delivered)] == [False, True]


def test_a_complete_landscape_is_cancelled_when_the_window_moves(
    tiny_model: RNNPB, generated: Generated
) -> None:
    desk = Desk(tiny_model)
    long = target_of_motion(
        Motion("long", tiny_model.info.joints, tiny_model.reconstruct(1, 140).numpy(), 20.0)
    )
    desk.page.want({LANDSCAPE: landscape_work(target=long, motion=-1)})
    desk.run()
    desk.now = 1.0
    for _ in range(3):
        assert desk.engine.run_one()
    begun = sum(batch for batch, _ in generated)
    assert 36 < begun < 100
    moved = landscape_work(target=long, motion=-1, center=(0.5, 0.5, 0.5))
    desk.page.want({LANDSCAPE: moved})
    desk.run()
    assert sum(batch for batch, _ in generated) == begun + 36
    assert not any(one.done for one in desk.told if isinstance(one, Delivered))


def test_a_reconstruction_to_compare_with_is_made_once(
    tiny_model: RNNPB, generated: Generated
) -> None:
    desk = Desk(tiny_model)
    for radius in (1.0, 0.5, 0.25):
        desk.page.want({LANDSCAPE: landscape_work(radius=radius)})
        desk.run()
    assert generated.count((1, 9)) == 1


def test_no_piece_of_a_landscape_is_larger_than_it_may_be(
    tiny_model: RNNPB, generated: Generated
) -> None:
    for frames in (20, 150, 420):
        target = target_of_motion(
            Motion("m", tiny_model.info.joints, tiny_model.reconstruct(0, frames).numpy(), 20.0)
        )
        generated.clear()
        landscapes(Desk(tiny_model), landscape_work(target=target, motion=-1))
        assert sum(batch * part for batch, part in generated) == 400 * frames
        assert max((batch + OVERHEAD) * part for batch, part in generated) <= PIECE
        assert min(batch for batch, _ in generated) >= FEWEST // 2


def test_a_wider_network_has_smaller_pieces(generated: Generated) -> None:
    config = ModelConfig(num_joints=2, pb_dim=1, hidden_size=512, num_motions=2)
    model = RNNPB(config, ModelInfo(joints=("a", "b"))).eval().requires_grad_(False)
    Desk(model).results(MotionWork("one", (0.1,), 200))
    assert len(generated) == 2


# --- recognition ---
def recognise_work(model: RNNPB, **changes: object) -> RecogniseWork:
    motion = Motion("given", model.info.joints, model.reconstruct(1, 12).numpy(), model.info.fps)
    work = RecogniseWork(
        model="one",
        target=target_of_motion(motion),
        method="paper",
        observed=0.7,
        joints=(),
        beta=0.0,
        init="baseline",
        iterations=4,
        trials=2,
        seed=3,
    )
    return replace(work, **changes)  # type: ignore[arg-type]


def traces(desk: Desk, work: RecogniseWork) -> list[RecognitionTrace]:
    results = desk.results(work, RECOGNITION)
    assert all(isinstance(result, RecognitionTrace) for result in results)
    return results  # type: ignore[return-value]


def test_every_iteration_is_a_stage(tiny_model: RNNPB) -> None:
    stages = traces(Desk(tiny_model), recognise_work(tiny_model))
    assert [trace.iterations for trace in stages] == [1, 2, 3, 4]
    last = stages[-1]
    assert last.mu.shape == last.sigma.shape == (5, 2, 3)
    assert last.pb.shape == (4, 2, 3)
    assert last.loss.shape == last.prediction_error.shape == last.early_update.shape == (4, 2)
    for earlier in stages[:-1]:
        np.testing.assert_array_equal(earlier.loss, last.loss[: earlier.iterations])
        np.testing.assert_array_equal(earlier.mu, last.mu[: earlier.iterations + 1])


@pytest.mark.parametrize("init", ["baseline", "learned", "random"])
def test_the_trace_is_what_core_recognises(tiny_model: RNNPB, init: str) -> None:
    work = recognise_work(tiny_model, init=init)
    trace = traces(Desk(tiny_model), work)[-1]
    config = RecognitionConfig(init=work.init, observed=0.7, iterations=4, trials=2, seed=3)
    steps = list(recognize(tiny_model, work.target.array, config))
    for index, step in enumerate(steps):
        np.testing.assert_array_equal(trace.mu[index], step.mu)
        np.testing.assert_array_equal(trace.pb[index], step.pb)
        np.testing.assert_array_equal(trace.loss[index], step.loss)
        np.testing.assert_array_equal(trace.early_update[index], step.early_update)
    np.testing.assert_array_equal(trace.mu[-1], steps[-1].mu_next)
    np.testing.assert_array_equal(trace.sigma[-1], steps[-1].sigma_next)


def test_a_shorter_run_is_the_beginning_of_a_longer_one(tiny_model: RNNPB) -> None:
    long = traces(Desk(tiny_model), recognise_work(tiny_model, iterations=9))[-1]
    short = traces(Desk(tiny_model), recognise_work(tiny_model, iterations=5))[-1]
    for name in ("mu", "sigma", "pb", "loss", "prediction_error", "early_update"):
        expected = getattr(long.first(5), name)
        np.testing.assert_array_equal(getattr(short, name), expected, err_msg=name)


def test_a_run_that_was_ended_is_not_run_again(tiny_model: RNNPB, generated: Generated) -> None:
    desk, work = Desk(tiny_model), recognise_work(tiny_model, iterations=9)
    desk.page.want({RECOGNITION: work})
    for _ in range(5):
        desk.engine.run_one()
    count = len(generated)
    desk.page.want({RECOGNITION: replace(work, iterations=4)})
    desk.run()
    assert len(generated) == count
    last = desk.told[-1]
    assert isinstance(last, Delivered)
    assert isinstance(last.result, RecognitionTrace)
    assert (last.result.iterations, last.done) == (4, True)


@pytest.mark.parametrize(("init", "candidates"), [("learned", 3), ("random", 200)])
def test_a_warm_start_is_searched_in_pieces_and_can_be_cancelled_there(
    tiny_model: RNNPB, generated: Generated, init: str, candidates: int
) -> None:
    frames = 200
    positions = tiny_model.reconstruct(1, frames).numpy()
    target = target_of_motion(Motion("given", tiny_model.info.joints, positions, 20.0))
    desk = Desk(tiny_model)
    work = recognise_work(tiny_model, init=init, target=target, iterations=1)
    generated.clear()
    desk.page.want({RECOGNITION: work})
    pieces = 0
    while not desk.told:
        assert desk.engine.run_one()
        pieces += 1
        assert len(generated) <= pieces
    search = generated[:-1]
    assert sum(batch for batch, _ in search) == candidates
    assert max(part * (batch + OVERHEAD) for batch, part in search) <= PIECE
    desk.page.want({RECOGNITION: replace(work, seed=4)})
    desk.engine.run_one()
    count = len(generated)
    desk.page.want({})
    desk.run()
    assert len(generated) == count


def test_a_run_keeps_one_path_and_no_motions(
    tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch
) -> None:
    outputs: list[weakref.ref[np.ndarray]] = []

    def watched(*args: object, **options: object) -> Iterator[RecognitionStep | None]:
        for step in recognition_pieces(*args, **options):  # type: ignore[arg-type]
            assert step is not None
            outputs.append(weakref.ref(step.output))
            yield step

    monkeypatch.setattr(recognitions, "recognition_pieces", watched)
    desk = Desk(tiny_model)
    stages = traces(desk, recognise_work(tiny_model))
    assert len(stages) == 4
    for name in ("mu", "sigma", "pb", "loss", "prediction_error", "early_update"):
        assert np.shares_memory(getattr(stages[0], name), getattr(stages[-1], name)), name
    assert [output() for output in outputs] == [None] * 4


@pytest.mark.parametrize("name", ["mu", "sigma", "pb", "loss", "mu_next", "sigma_next"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -2 * MAX_PB])
def test_a_run_that_no_document_can_hold_fails_and_leaves_what_was(
    tiny_model: RNNPB, monkeypatch: pytest.MonkeyPatch, name: str, value: float
) -> None:
    if name == "loss" and np.isfinite(value):
        return  # as large as it likes

    def diverging(*args: object, **options: object) -> Iterator[RecognitionStep | None]:
        for step in recognition_pieces(*args, **options):  # type: ignore[arg-type]
            assert step is not None
            values = getattr(step, name).copy()
            values[1] = value
            yield replace(step, **{name: values}) if step.iteration == 2 else step

    monkeypatch.setattr(recognitions, "recognition_pieces", diverging)
    desk = Desk(tiny_model)
    desk.page.want({RECOGNITION: recognise_work(tiny_model)})
    desk.run()
    *stages, failed = desk.told
    assert [type(one) for one in stages] == [Delivered, Delivered]
    assert isinstance(failed, Failed)
    what = "beyond 1,000,000" if np.isfinite(value) else "not finite"
    assert failed.message.endswith(f"of trial 2 is {what} in iteration 3")


def test_a_model_that_generates_no_numbers_recognises_nothing(tiny_model: RNNPB) -> None:
    work = recognise_work(tiny_model)
    tiny_model.weight_out *= 1e30
    desk = Desk(tiny_model)
    desk.page.want({RECOGNITION: work})
    desk.run()
    message = "the loss of trial 1 is not finite in iteration 1"
    assert desk.told == [Failed(RECOGNITION, work, message)]


def test_a_target_too_short_to_observe_is_bad_input(tiny_model: RNNPB) -> None:
    short = target_of_motion(Motion("two", tiny_model.info.joints, np.zeros((2, 5), np.float32)))
    desk = Desk(tiny_model)
    desk.page.want({RECOGNITION: recognise_work(tiny_model, target=short, observed=0.1)})
    desk.run()
    (failed,) = desk.told
    assert isinstance(failed, Failed)
    assert "leaves none to observe" in failed.message


# --- files ---
WILD = MotionWork("one", (40.0, -40.0, 40.0), 12)


@pytest.mark.parametrize("beyond", [False, True])
def test_an_export_is_within_the_limits_unless_one_insists(tiny_model: RNNPB, beyond: bool) -> None:
    tiny_model.weight_out *= 30.0  # beyond the arm's limits
    options = ExportOptions("json", beyond_limits=beyond)
    (result,) = Desk(tiny_model).results(ExportWork(WILD, "wave ../../tiny", options), EXPORT)
    assert isinstance(result, ExportedFile)
    assert result.file_name == "wave_.._.._tiny.json"
    motion = read_motions(result.content, "x.json", ("a", "b", "c"), fps=20.0).motion()
    assert (check_motion(motion, ARM).light == "green") != beyond
    assert ("beyond the limits" in result.summary) == beyond
    assert ("limited: " in result.summary) != beyond


def test_a_motion_goes_along_a_way_of_pbs_in_long_ones_in_parts(tiny_model: RNNPB) -> None:
    way = np.array([[0.0, 0.5, 0.0], [2.0, -1.0, 0.5], [1.0, 0.0, 3.0]])
    for frames in (12, 3 * PIECE // 5):
        work = MotionWork("one", tuple(way[0]), frames, along=tuple(map(tuple, way)))
        (shown,) = Desk(tiny_model).results(work)
        assert isinstance(shown, MotionResult)
        pbs = torch.tensor(morph(way, frames), dtype=torch.float32)[:, None]
        expected = tiny_model.generate(pbs, frames)[0]
        np.testing.assert_allclose(shown.positions, expected, atol=1e-5)


@pytest.mark.parametrize("along", [(), (WAVE.pb, (2.0, -1.0, 0.5))])
def test_a_download_is_the_file_of_the_motion_itself(
    tiny_model: RNNPB, along: tuple[Vector, ...]
) -> None:
    desk, moving = Desk(tiny_model), replace(WAVE, along=along)
    (shown,) = desk.results(moving)
    work = ExportWork(moving, "wave", ExportOptions("csv", beyond_limits=True))
    (result,) = desk.results(work, EXPORT)
    assert isinstance(result, ExportedFile)
    assert isinstance(shown, MotionResult)
    motion = Motion("wave", tiny_model.info.joints, shown.positions, tiny_model.info.fps)
    assert result.content == format_motion(motion).encode()


def test_an_export_starts_from_the_safe_posture_where_that_is_asked_for(tiny_model: RNNPB) -> None:
    desk = Desk(tiny_model)
    lengths = []
    for safe in (False, True):
        work = ExportWork(WAVE, "wave", ExportOptions("csv", safe_posture=safe))
        (result,) = desk.results(work, EXPORT)
        assert isinstance(result, ExportedFile)
        lengths.append(len(result.content.splitlines()))
    assert lengths[0] == 1 + 12
    assert lengths[1] >= 1 + 12 + 2 * 20  # a second each, at least


def test_a_robot_without_naoqi_gets_no_script(tiny_model: RNNPB) -> None:
    desk = Desk(tiny_model)
    desk.page.want({EXPORT: ExportWork(WAVE, "wave", ExportOptions("naoqi"))})
    desk.run()
    (failed,) = desk.told
    assert isinstance(failed, Failed)
    assert "NAOqi on Pepper has no joint a" in failed.message


# --- all of it, on threads ---
def test_everything_at_once_on_the_shipped_model(strong: RNNPB) -> None:
    """Three pages, real threads: what comes is what core computes, and the engine ends."""
    nothing = {"one": [None] * strong.config.num_motions}
    engine = Engine({"one": strong}, nothing, load_robot("pepper"), 2)
    mu = tuple(strong.mu[2].tolist())
    positions = strong.reconstruct(2, 60).numpy()
    given = target_of_motion(Motion("given", strong.info.joints, positions))
    axes = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))
    work = LandscapeWork("one", mu, axes, (0.0,) * 4, 1.0, given, -1)
    run = RecogniseWork("one", given, "paper", 0.8, (), 0.0, "learned", 3, 1, 0)
    boxes: list[SimpleQueue[Delivery]] = [SimpleQueue() for _ in range(3)]
    for number, box in enumerate(boxes):
        motion = MotionWork("one", (*mu[:3], 0.1 * number), 60, "report")
        engine.open(box.put).want({MOTION: motion, LANDSCAPE: work, RECOGNITION: run})
    expected = landscape(strong, positions, mu, axes=(0, 1)).correlation
    config = RecognitionConfig(iterations=3)
    steps = list(recognize(strong, positions, config))
    for number, box in enumerate(boxes):
        done: dict[Slot, Delivered] = {}
        while len(done) < 3:
            one = box.get(timeout=TIMEOUT)
            assert isinstance(one, Delivered), one
            if one.done:
                done[one.slot] = one
        moved, plane = done[MOTION].result, done[LANDSCAPE].result
        trace = done[RECOGNITION].result
        assert isinstance(moved, MotionResult)
        assert isinstance(plane, LandscapeResult)
        assert isinstance(trace, RecognitionTrace)
        motion = expected_motion(strong, (*mu[:3], 0.1 * number), 60)
        np.testing.assert_allclose(moved.positions, motion, atol=1e-4)
        np.testing.assert_allclose(plane.values.correlation, expected, atol=1e-3)
        np.testing.assert_allclose(trace.mu[-1], steps[-1].mu_next, atol=1e-3)
    engine.close(TIMEOUT)
    assert not any(thread.name.startswith("engine") for thread in threading.enumerate())
