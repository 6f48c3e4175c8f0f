"""Codebooks, beliefs, the other recognitions and their files, as the engine computes them."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rnnpb_explorer.app.engine.engine import Delivered
from rnnpb_explorer.app.state.document import target_of_motion
from rnnpb_explorer.app.state.results import (
    BeliefResult,
    CodebookResult,
    ExportedFile,
    RecognitionTrace,
    StretchResult,
    WaysResult,
)
from rnnpb_explorer.app.state.work import (
    BeliefWork,
    CodebookWork,
    RecogniseWork,
    Slot,
    StretchWork,
    TakeAway,
    TakeAwayWork,
    WaysWork,
)
from rnnpb_explorer.core.belief import belief_cloud
from rnnpb_explorer.core.codebook import complete_codebook
from rnnpb_explorer.core.files import CACHE_VARIABLE
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.core.recognition_lm import LMConfig, recognize_lm
from rnnpb_explorer.core.smoothness import shortest, straight, stretch, walk

from .test_engine_works import EXPORT, RECOGNITION, Desk, one_dimensional

CODEBOOK: Slot = ("codebook", 0)
BELIEF: Slot = ("belief", 0)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    return tmp_path / "codebooks"


def target_motion(model: RNNPB, frames: int = 30) -> Motion:
    positions = model.reconstruct(1, frames).numpy()
    noise = np.random.default_rng(0).normal(0, 0.02, positions.shape)
    return Motion("given", model.info.joints, (positions + noise).astype(np.float32), 20.0)


def run_work(model: RNNPB, method: str, **changes: object) -> RecogniseWork:
    fields: dict[str, object] = {
        "model": "one",
        "target": target_of_motion(target_motion(model)),
        "method": method,
        "observed": 0.8,
        "joints": (),
        "beta": 0.0,
        "init": "learned",
        "iterations": 6 if method == "paper" else None,
        "trials": 1,
        "seed": 0,
    }
    return RecogniseWork(**(fields | changes))  # type: ignore[arg-type]


def traces(desk: Desk, work: RecogniseWork) -> list[RecognitionTrace]:
    results = desk.results(work, RECOGNITION)
    assert all(isinstance(result, RecognitionTrace) for result in results)
    return results  # type: ignore[return-value]


# --- codebooks ---
def test_a_codebook_grows_is_told_of_and_kept(tiny_model: RNNPB, cache: Path) -> None:
    told = Desk(tiny_model).results(CodebookWork("one"), CODEBOOK)
    assert all(isinstance(one, CodebookResult) for one in told)
    entries = [one.entries for one in told if isinstance(one, CodebookResult)]
    assert entries == sorted(entries)
    assert len(entries) > 2
    last = told[-1]
    assert isinstance(last, CodebookResult)
    assert last.entries == last.size
    assert last.seconds > 0
    assert len(list(cache.iterdir())) == 1
    (again,) = Desk(tiny_model).results(CodebookWork("one"), CODEBOOK)
    assert again == CodebookResult(last.size, last.size, 0.0)


def test_everything_else_goes_before_a_codebook(tiny_model: RNNPB) -> None:
    desk = Desk(tiny_model)
    desk.page.want({CODEBOOK: CodebookWork("one")})
    for _ in range(3):
        desk.engine.run_one()
    desk.page.want(
        {CODEBOOK: CodebookWork("one"), RECOGNITION: run_work(tiny_model, "paper", iterations=3)}
    )
    desk.told.clear()
    desk.run()
    kinds = [one.slot[0] for one in desk.told if isinstance(one, Delivered)]
    assert kinds[:3] == ["recognition"] * 3
    assert set(kinds[3:]) == {"codebook"}


def test_a_codebook_that_nobody_wants_any_more_is_gone_on_with_later(tiny_model: RNNPB) -> None:
    desk = Desk(tiny_model)
    desk.page.want({CODEBOOK: CodebookWork("one")})
    for _ in range(4):
        desk.engine.run_one()
    desk.page.want({})
    desk.run()
    result = desk.results(CodebookWork("one"), CODEBOOK)[-1]
    assert isinstance(result, CodebookResult)
    assert result.entries == result.size


# --- belief ---
def test_the_belief_is_what_core_makes_of_it(tiny_model: RNNPB) -> None:
    desk = Desk(tiny_model)
    desk.results(CodebookWork("one"), CODEBOOK)
    target = target_of_motion(target_motion(tiny_model))
    work = BeliefWork("one", target, 0.8, (0, 1), 0.2, 512)
    (result,) = desk.results(work, BELIEF)
    assert isinstance(result, BeliefResult)
    book = complete_codebook(tiny_model)
    expected = belief_cloud(book, target.array[:24], scale=0.2, joints=(0, 1), steps=30)
    np.testing.assert_array_equal(result.cloud.weights, expected.weights)
    assert len(result.motions) == len(expected.modes)
    for motion, mode in zip(result.motions, expected.modes, strict=True):
        assert motion.shape == (30, 5)
        first = float(np.square(motion[::12] - book.motions[0, :3].float().numpy()).mean())
        assert np.isfinite(first)
        assert mode.mass > 0


# --- global ---
def test_a_global_run_is_what_core_recognises_and_ends_with_a_posterior(
    tiny_model: RNNPB,
) -> None:
    complete_codebook(tiny_model)  # in the cache: the job takes it from there
    stages = traces(Desk(tiny_model), run_work(tiny_model, "global"))
    last = stages[-1]
    config = LMConfig(observed=0.8)
    motion = target_motion(tiny_model).positions
    steps = list(recognize_lm(tiny_model, motion, config, codebook=complete_codebook(tiny_model)))
    assert last.iterations == len(steps)
    for index, step in enumerate(steps):
        np.testing.assert_array_equal(last.pb[index], step.pb)
        np.testing.assert_array_equal(last.loss[index], step.loss)
    assert [trace.finished for trace in stages] == [False] * len(steps) + [True]
    assert last.posterior is not None
    assert last.posterior.deviation.shape == (30, 5)
    np.testing.assert_allclose(last.posterior.mu, last.pb[last.best], rtol=1e-6)


def test_it_makes_what_it_needs_of_the_codebook_itself(tiny_model: RNNPB) -> None:
    last = traces(Desk(tiny_model), run_work(tiny_model, "global"))[-1]
    assert last.finished
    assert last.loss.min() < 1e-3


def test_a_run_that_was_cut_has_no_end(tiny_model: RNNPB) -> None:
    last = traces(Desk(tiny_model), run_work(tiny_model, "global", iterations=2))[-1]
    assert (last.iterations, last.finished, last.posterior) == (2, False, None)


def test_an_open_direction_can_be_drawn() -> None:
    model = one_dimensional()
    model.weight_pb[:] = 0.0  # no PB makes a difference
    trace = traces(Desk(model), run_work(model, "global"))[-1]
    assert np.isfinite(trace.sigma).all()


# --- live ---
def test_a_live_run_waits_for_its_frames(tiny_model: RNNPB) -> None:
    complete_codebook(tiny_model)
    desk = Desk(tiny_model)
    desk.page.want({RECOGNITION: run_work(tiny_model, "live")})
    seen = []
    for now in np.arange(0.0, 1.3, 0.05):  # 20 frames a second
        desk.now = float(now)
        desk.run()
        last = desk.told[-1]
        assert isinstance(last, Delivered)
        assert isinstance(last.result, RecognitionTrace)
        seen.append(last.result.iterations)
    assert seen[:4] == [1, 2, 3, 4]
    assert seen[-1] == 24
    assert isinstance(last.result, RecognitionTrace)
    assert last.result.finished
    assert last.result.loss[-1, 0] < 0.01


def test_a_live_run_knows_nothing_of_what_has_not_come(tiny_model: RNNPB) -> None:
    complete_codebook(tiny_model)
    motion = target_motion(tiny_model)
    other = motion.positions.copy()
    other[12:] = 1.0
    changed = target_of_motion(Motion("given", motion.joints, other, 20.0))
    runs = []
    for work in (
        run_work(tiny_model, "live"),
        run_work(tiny_model, "live", target=changed),
    ):
        desk = Desk(tiny_model)
        desk.now = 0.0
        desk.page.want({RECOGNITION: work})
        desk.now = 100.0
        desk.run()
        result = desk.told[-1]
        assert isinstance(result, Delivered)
        assert isinstance(result.result, RecognitionTrace)
        runs.append(result.result)
    np.testing.assert_array_equal(runs[0].pb[:12], runs[1].pb[:12])
    assert not np.array_equal(runs[0].pb[13:], runs[1].pb[13:])


# --- take it away ---
def file_of(model: RNNPB, what: TakeAway, method: str = "paper") -> ExportedFile:
    desk = Desk(model)
    run = run_work(model, method, trials=2)
    trace = traces(desk, run)[-1]
    (result,) = desk.results(TakeAwayWork(run, trace, what, 1, "given ../tiny"), EXPORT)
    assert isinstance(result, ExportedFile)
    assert "/" not in result.file_name
    return result


def test_the_path_as_a_table(tiny_model: RNNPB) -> None:
    file = file_of(tiny_model, "path")
    rows = list(csv.DictReader(io.StringIO(file.content.decode())))
    assert file.file_name == "given_.._tiny_belief_path.csv"
    assert [(row["trial"], row["iteration"]) for row in rows] == [
        (str(trial), str(iteration)) for trial in (1, 2) for iteration in range(1, 7)
    ]
    assert set(rows[0]) >= {"mu1", "mu3", "sigma2", "pb3", "loss", "kl", "early_update"}
    assert all(np.isfinite(float(row["loss"])) for row in rows)


@pytest.mark.parametrize("method", ["paper", "global"])
def test_all_of_it_as_arrays(tiny_model: RNNPB, method: str) -> None:
    file = file_of(tiny_model, "arrays", method)
    arrays = np.load(io.BytesIO(file.content), allow_pickle=False)
    trials, iterations = arrays["loss"].shape
    assert arrays["mu"].shape == (trials, iterations + 1, 3)
    assert arrays["output"].shape == (30, 5)
    assert ("posterior_covariance" in arrays) == (method == "global")


@pytest.mark.parametrize("method", ["paper", "global"])
def test_a_figure(tiny_model: RNNPB, method: str) -> None:
    png = file_of(tiny_model, "png", method)
    image = Image.open(io.BytesIO(png.content)).convert("L")
    assert image.width > 800
    assert len(image.getcolors(1 << 20)) > 50
    svg = file_of(tiny_model, "svg", method).content.decode()
    assert svg.lstrip().startswith("<?xml")
    assert "recognising given" in svg or "<path" in svg


def test_of_a_deterministic_model_too() -> None:
    config = ModelConfig(5, 3, 16, 2, "deterministic", None)
    model = RNNPB(config, ModelInfo(joints=tuple("abcde"), fps=20.0)).eval().requires_grad_(False)
    assert file_of(model, "png").content.startswith(b"\x89PNG")


# --- smoothness ---
def test_stretch_and_ways_are_what_core_measures(tiny_model: RNNPB) -> None:
    mu = [tuple(row) for row in tiny_model.mu.tolist()]
    (found,) = Desk(tiny_model).results(StretchWork("one", mu[1]), ("stretch", 0))
    expected = stretch(tiny_model, tiny_model.mu[1])
    assert isinstance(found, StretchResult)
    assert found.degrees == pytest.approx(np.rad2deg(expected.largest))
    first, last = Desk(tiny_model).results(WaysWork("one", mu[0], mu[1]), ("ways", 0))
    way = walk(tiny_model, straight(tiny_model.mu[0], tiny_model.mu[1]))
    best = shortest(tiny_model, tiny_model.mu[0], tiny_model.mu[1])
    assert isinstance(first, WaysResult)
    assert isinstance(last, WaysResult)
    assert (first.sought, last.sought) == (False, True)
    np.testing.assert_allclose(first.straight.steps, way.steps, atol=1e-6)
    np.testing.assert_allclose(last.shortest.pbs, best.pbs, atol=1e-6)
    assert last.detour == pytest.approx(way.length / best.length)
