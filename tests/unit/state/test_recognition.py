"""What a recognition does to the document: target, settings, start, iterations, end, way back."""

from __future__ import annotations

import dataclasses
import math
from typing import get_args

import numpy as np
import pytest
from msgspec.structs import replace

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.computed import Entry
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.on_recognition import shown_iteration
from rnnpb_explorer.app.state.statecode import decode, encode
from rnnpb_explorer.app.state.wanted import eyes_of, given_target, known_reference, wanted
from rnnpb_explorer.app.state.work import RecogniseWork
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.recognition_run import Init

from ..app_states import (
    CODEBOOK,
    FACTS,
    LANDSCAPE,
    MOTION,
    REFERENCE,
    RUN,
    Page,
    after,
    landscape_of,
    make_facts,
    make_target,
    make_trace,
    motion_of,
    newly_wanted,
    opened,
)

TARGET = make_target(frames=10)
LEARNED = (0.5, -0.3, 0.2)
# Two trials of three iterations: (S + 1, K, D).
PATH = np.array(
    [
        [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]],
        [[0.1, 0.2, 0.3], [0.9, 0.8, 0.7]],
        [[0.2, 0.3, 0.4], [0.8, 0.7, 0.6]],
        [[0.3, 0.4, 0.5], [0.7, 0.6, 0.5]],
    ]
)
LOSS = np.array([[0.9, 0.8], [0.5, 0.2], [0.4, 0.3]])  # the best: iteration 1 of trial 1
BEST_PB = PATH[1, 1] + 0.1  # `make_trace` samples each PB half a sigma, 0.1, above mu


def running(facts: Facts = FACTS, iterations: int = 100) -> Page:
    return Page(facts).do(
        do.SetTarget(TARGET),
        do.SetRecognitionOption("trials", 2),
        do.SetRecognitionOption("iterations", iterations),
        do.StartRecognition(),
    )


def stepped(page: Page, steps: int) -> Page:
    """The run once it has come so many steps along `PATH`."""
    return page.deliver(RUN, make_trace(PATH[: steps + 1], loss=LOSS[:steps]), done=False)


def finished() -> Page:
    return stepped(running(iterations=3), 3)


def run_of(page: Page) -> RecogniseWork:
    work = page.wanted[RUN]
    assert isinstance(work, RecogniseWork)
    return work


def mu_of(page: Page) -> tuple[float, ...]:
    return page.document.current.latent.mu


# --- the target ---
def test_a_target_is_what_motion_and_landscape_are_compared_with() -> None:
    document = opened(FACTS, do.SetTarget(TARGET))
    works = newly_wanted(FACTS, opened(), do.SetTarget(TARGET))
    assert set(works) == {MOTION, LANDSCAPE, CODEBOOK}
    assert REFERENCE not in wanted(FACTS, document)
    assert landscape_of(works).target is TARGET
    assert motion_of(works).steps == 10
    np.testing.assert_array_equal(known_reference(FACTS, document, 0), TARGET.array)
    off = after(FACTS, document, do.SetUseTarget(False))
    assert wanted(FACTS, off) == wanted(FACTS, opened())


def test_a_new_target_is_looked_at_even_where_the_last_one_was_not() -> None:
    targets = do.SetTarget(TARGET), do.SetUseTarget(False), do.SetTarget(make_target(7))
    assert opened(FACTS, *targets).use_target


def test_a_target_with_other_joints_is_no_target_of_this_model() -> None:
    other = make_target(joints=("x", "y", "z", "v", "w"))
    document = opened(FACTS, do.SetTarget(other))
    assert given_target(FACTS, document, 0) is None
    assert wanted(FACTS, document) == wanted(FACTS, opened())
    with pytest.raises(InputError, match="other joints"):
        after(FACTS, document, do.StartRecognition())


def test_a_target_that_is_forgotten_takes_its_run_with_it_and_leaves_the_settings() -> None:
    page = finished().do(do.SetRecognitionOption("observed", 0.5), do.ClearTarget())
    document = page.document
    assert (document.target, document.run) == (None, None)
    assert (document.recognition.observed, document.recognition.trials) == (0.5, 2)
    assert RUN not in page.computed.entries
    assert landscape_of(page.wanted).target is None


def test_the_targets_colours_are_shown_while_it_is_compared_with() -> None:
    track = np.full((10, 2, 8, 3), 0.2, dtype=np.float32)
    track[0] = 1.0
    eyes = (track * 255).astype(np.uint8).tobytes()
    document = opened(FACTS, do.SetTarget(replace(TARGET, eyes=eyes)))
    seen = eyes_of(FACTS, document, 0)
    assert seen is not None
    np.testing.assert_allclose(seen, track, atol=1e-6)
    assert eyes_of(FACTS, after(FACTS, document, do.SetUseTarget(False)), 0) is None
    assert eyes_of(FACTS, after(FACTS, document, do.SetTarget(TARGET)), 0) is None
    facts = (dataclasses.replace(FACTS[0], eyes=(None, track, None, None)),)
    assert eyes_of(facts, opened(facts), 0) is None
    assert eyes_of(facts, opened(facts, do.SelectMotion(1)), 0) is track
    assert eyes_of(facts, opened(facts, do.SelectMotion(1), do.SetTarget(TARGET)), 0) is None


@pytest.mark.parametrize(
    "broken",
    [
        {"joints": ()},
        {"positions": b""},
        {"positions": TARGET.positions[:-4]},
        {"positions": TARGET.positions[:20]},  # one frame
        {"positions": TARGET.positions * 501},  # 5010 frames
        {"positions": np.full(50, np.nan, "<f4").tobytes()},
        {"positions": np.full(50, np.inf, "<f4").tobytes()},
        {"eyes": b"\0" * 47},
    ],
    ids=lambda broken: next(iter(broken)),
)
def test_a_target_is_a_motion(broken: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"motion|eye colours"):
        replace(TARGET, **broken)


# --- settings ---
@pytest.mark.parametrize(
    ("name", "value", "got"),
    [
        ("observed", 0.5, 0.5),
        ("observed", 7.0, 1.0),
        ("observed", -1.0, 0.1),
        ("observed", math.nan, 0.8),
        ("iterations", 30, 30),
        ("iterations", 0, 1),
        ("iterations", 1000, 300),
        ("trials", 3.0, 3),
        ("trials", 0, 1),
        ("trials", 20, 10),
        ("trials", math.inf, 1),
        ("init", "random", "random"),
        ("init", "nonsense", "learned"),
    ],
)
def test_settings_stay_within_their_sliders(name: str, value: float | str, got: object) -> None:
    document = opened(FACTS, do.SetRecognitionOption(name, value))  # type: ignore[arg-type]
    assert getattr(document.recognition, name) == got
    assert decode(FACTS, encode(document)) == document


def test_a_start_takes_the_settings_along_and_later_ones_wait_for_the_next() -> None:
    page = Page().do(
        do.SetTarget(TARGET),
        do.SetRecognitionOption("observed", 0.6),
        do.SetRecognitionOption("iterations", 40),
        do.SetRecognitionOption("trials", 4),
        do.SetRecognitionOption("init", "baseline"),
        do.StartRecognition(),
    )
    work = run_of(page)
    assert (work.observed, work.iterations, work.trials, work.init) == (0.6, 40, 4, "baseline")
    assert work.target is TARGET
    assert page.picture.run_status == "running"
    assert run_of(page.do(do.SetRecognitionOption("observed", 0.9))) == work


@pytest.mark.parametrize("init", get_args(Init))
def test_every_init_can_be_chosen(init: str) -> None:
    assert opened(FACTS, do.SetRecognitionOption("init", init)).recognition.init == init


# --- start ---
def test_without_a_target_nothing_starts() -> None:
    with pytest.raises(InputError, match="Upload a motion"):
        opened(FACTS, do.StartRecognition())


def test_every_start_has_noise_of_its_own_and_the_last_ones_trace_goes() -> None:
    page = stepped(running(), 2)
    first = run_of(page)
    second = run_of(page.do(do.StartRecognition()))
    assert dataclasses.replace(first, seed=second.seed) == second != first
    assert page.picture.trace is None
    assert RUN in page.missing


def test_a_run_looks_at_its_target() -> None:
    page = Page().do(do.SetTarget(TARGET), do.SetUseTarget(False), do.StartRecognition())
    assert page.document.use_target
    assert motion_of(page.wanted).steps == 10


# --- iterations ---
def test_the_latent_follows_the_newest_iterate() -> None:
    page = stepped(running(), 1)
    np.testing.assert_allclose(mu_of(page), PATH[0, 0])
    latent = page.document.current.latent
    np.testing.assert_allclose(latent.pb, PATH[0, 0] + 0.1)  # the PB that was sampled there
    stepped(page, 2)
    np.testing.assert_allclose(mu_of(page), PATH[1, 0])
    np.testing.assert_allclose(motion_of(page.wanted).pb, PATH[1, 0] + 0.1)
    assert page.document.run is not None
    assert page.document.run.done == 2


def test_no_landscape_is_wanted_or_complete_while_a_run_passes_through() -> None:
    page = running().compute()
    assert LANDSCAPE not in page.wanted
    before = Page().do(do.SetTarget(TARGET)).compute()
    assert before.picture.landscape_complete
    before.do(do.StartRecognition())
    assert not before.picture.landscape_complete  # nothing has moved, and yet it will
    for steps in (1, 2):
        stepped(before, steps)
        assert before.picture.landscape is not None  # the old one stays on the board
        assert not before.picture.landscape_complete
    before.do(do.CancelRecognition())
    assert not before.picture.landscape_complete
    assert before.compute().picture.landscape_complete


def test_iterations_are_no_steps_of_undo() -> None:
    page = running()
    steps = len(page.history.past)
    assert len(stepped(page, 3).history.past) == steps


def test_iterations_of_another_run_are_dropped() -> None:
    page = running()
    old = run_of(page)
    stepped(page, 1).do(do.StartRecognition())
    before = page.document
    page.deliver(RUN, make_trace(PATH), done=False, work=old)
    assert page.document == before
    page.do(do.ClearTarget())
    page.computed = page.computed.put(page.wanted, RUN, Entry(old, make_trace(PATH), False))
    assert RUN not in page.computed.entries


def test_what_comes_after_a_cancel_moves_nothing() -> None:
    page = stepped(running(), 1)
    work = run_of(page)
    page.do(do.CancelRecognition())
    before = page.document
    page.deliver(RUN, make_trace(PATH), done=False, work=work)
    assert page.document == before
    assert page.picture.trace is not None
    assert page.picture.trace.iterations == 1


# --- the end ---
def test_in_the_end_it_goes_to_the_best_pb_of_all_trials() -> None:
    page = finished()
    run, trace = page.document.run, page.picture.trace
    assert run is not None
    assert trace is not None
    assert page.picture.run_status == "finished"
    assert (shown_iteration(run, trace), run.trial, run.done) == (1, 1, 3)
    latent = page.document.current.latent
    np.testing.assert_allclose(latent.mu, BEST_PB)
    assert latent.epsilon == (0.0, 0.0, 0.0)
    assert RUN not in page.missing
    np.testing.assert_allclose(landscape_of(page.wanted).center[2], BEST_PB[2])


def test_the_best_is_one_of_as_many_iterations_as_were_wanted() -> None:
    """The same run was wanted longer before, and what was found then is still there."""
    page = running(iterations=3)
    short = page.document
    path = np.concatenate([PATH, PATH[-1:]])
    loss = np.array([[0.5, 0.9], [0.3, 0.4], [0.6, 0.9], [0.1, 0.1]])
    page.deliver(RUN, make_trace(path, loss=loss))
    np.testing.assert_allclose(mu_of(page), PATH[1, 0] + 0.1)
    assert page.document.run is not None
    assert short.run is not None
    assert page.document.run.done == 3


def test_a_loss_that_is_no_number_is_never_the_best() -> None:
    page = running(iterations=3)
    loss = np.array([[0.5, 0.9], [0.3, math.nan], [math.nan, 0.9]])
    page.deliver(RUN, make_trace(PATH, loss=loss))
    np.testing.assert_allclose(mu_of(page), PATH[1, 0] + 0.1)


def test_cancelling_leaves_the_latent_at_the_last_iterate() -> None:
    page = stepped(running(), 2).do(do.CancelRecognition())
    run, trace = page.document.run, page.picture.trace
    assert run is not None
    assert trace is not None
    assert page.picture.run_status == "cancelled"
    assert (shown_iteration(run, trace), run.trial, run.done) == (1, 0, 2)
    np.testing.assert_allclose(mu_of(page), PATH[1, 0])  # the best is of the other trial
    assert RUN not in page.missing
    # The landscape had waited for the end, and this is one; the puck lies in its window.
    np.testing.assert_allclose(landscape_of(page.missing).center[2], PATH[1, 0, 2])


def test_a_run_that_is_cancelled_before_its_first_iteration_has_none() -> None:
    page = running()
    work = run_of(page)
    page.do(do.CancelRecognition())
    page.deliver(RUN, make_trace(PATH[:2], loss=LOSS[:1]), done=False, work=work)
    assert (page.picture.trace, page.picture.drawn_run) == (None, None)
    assert page.picture.run_status == "cancelled"
    assert mu_of(page) == LEARNED
    assert RUN not in page.missing


def test_without_a_run_there_is_nothing_to_cancel() -> None:
    for document in (opened(), opened(FACTS, do.SetTarget(TARGET)), finished().document):
        assert after(FACTS, document, do.CancelRecognition()) == document


@pytest.mark.parametrize(
    "intent",
    [
        do.SetMu(0, 0.4),
        do.SetSigma(0, 0.4),
        do.MoveOnMap(0, (0, 1), (0.0, 0.0), 1),
        do.MoveOnLandscape(0, ("μ1", "μ2"), (0.1, 0.2), 1),
        do.SelectMotion(2),
        do.ResetLatent(),
        do.NewNoise(),
        do.RandomiseLatent(),
    ],
    ids=lambda intent: type(intent).__name__,
)
@pytest.mark.parametrize("start", [lambda: stepped(running(), 2), finished], ids=["runs", "done"])
def test_a_hand_takes_the_latent_from_a_run(intent: do.LatentIntent, start: object) -> None:
    page = start()  # type: ignore[operator]
    expected = after(FACTS, page.document, intent).current.latent
    page.do(intent)
    assert not page.document.running
    assert LANDSCAPE in page.wanted
    assert page.document.current.latent == expected
    # Not even what it still brings takes it back.
    page.deliver(RUN, make_trace(PATH), done=False)
    assert page.document.current.latent == expected


@pytest.mark.parametrize(
    "intent",
    [
        do.TogglePlaying(),
        do.Seek(2),
        do.SetColouring("valence"),
        do.SetWindow("sd"),
        do.SelectModel(0),
        do.ScrubRecognition(0, 0),
        do.SetRecognitionOption("trials", 7),
    ],
    ids=lambda intent: type(intent).__name__,
)
def test_looking_does_not_stop_the_run(intent: do.DocumentIntent) -> None:
    page = stepped(running(), 2).do(intent)
    assert page.document.running
    np.testing.assert_allclose(mu_of(stepped(page, 3)), PATH[2, 0])


def test_a_failure_ends_the_run_and_says_why() -> None:
    page = stepped(running(), 2).fail(RUN, "out of memory")
    assert page.picture.run_status == "failed"
    assert page.picture.run_failure == "out of memory"
    assert page.picture.trace is not None
    np.testing.assert_allclose(landscape_of(page.wanted).center[2], PATH[1, 0, 2])
    page.do(do.StartRecognition())
    assert (page.picture.run_status, page.picture.run_failure) == ("running", "")


def test_a_run_that_fails_before_it_has_come_there_again_takes_the_window_along() -> None:
    """It is out of a code, whose latent had left the window."""
    page = running()
    page.deliver(RUN, make_trace(9 + PATH[:2], loss=LOSS[:1]), done=False)
    other = Page().do(do.RestoreCode(encode(page.document))).fail(RUN, "broken")
    assert other.document.current.latent.mu == (9.0, 9.0, 9.0)
    assert other.document.current.anchor == (9.0, 9.0, 9.0)


def test_a_failure_of_something_else_leaves_the_run_alone() -> None:
    page = running().fail(MOTION, "broken")
    assert page.picture.run_status == "running"
    assert page.picture.run_failure == ""


# --- scrubbing ---
def test_scrubbing_shows_an_iterate_again() -> None:
    page = finished().do(do.ScrubRecognition(0, 0))
    run = page.document.run
    assert run is not None
    assert (run.shown, run.trial) == (0, 0)
    latent = page.document.current.latent
    np.testing.assert_allclose(latent.mu, PATH[0, 0])
    np.testing.assert_allclose(latent.sigma, 0.2)
    np.testing.assert_allclose(motion_of(page.wanted).pb, PATH[0, 0] + 0.1)
    page.do(do.SetMu(0, 0.4), do.ScrubRecognition(2, 1))  # a hand, and back to the run
    np.testing.assert_allclose(mu_of(page), PATH[2, 1])


@pytest.mark.parametrize(("asked", "got"), [((99, 99), (2, 1)), ((-5, -5), (0, 0))])
def test_scrubbing_stays_within_the_run(asked: tuple[int, int], got: tuple[int, int]) -> None:
    run = finished().do(do.ScrubRecognition(*asked)).document.run
    assert run is not None
    assert (run.shown, run.trial) == got


def test_scrubbing_is_one_step_back_however_far() -> None:
    page = finished()
    before = page.document
    page.do(*(do.ScrubRecognition(i, 0) for i in (2, 1, 0)), do.Undo())
    assert page.document == before
    np.testing.assert_allclose(mu_of(page), BEST_PB)


def test_there_is_nothing_to_scrub_before_and_during_a_run() -> None:
    scrub = do.ScrubRecognition(0, 0)
    none_yet = running().do(do.CancelRecognition())
    for page in (Page(), stepped(running(), 2), none_yet):
        assert after(FACTS, page.document, scrub) == page.document


def test_a_pb_sampled_without_spread_is_mu() -> None:
    page = running().deliver(RUN, make_trace(PATH[:2], loss=LOSS[:1], sigma=0.0), done=False)
    assert page.document.current.latent.epsilon == (0.0, 0.0, 0.0)


def test_a_deterministic_model_recognises_as_well() -> None:
    page = running((make_facts(stochastic=False),), iterations=3)
    page.deliver(RUN, make_trace(PATH, loss=LOSS, sigma=0.0))
    assert page.picture.run_status == "finished"
    np.testing.assert_allclose(mu_of(page), PATH[1, 1])


# --- the way back ---
def test_undo_goes_back_to_before_the_run_and_redo_to_its_end() -> None:
    page = finished()
    end = page.document
    page.do(do.Undo())
    assert page.document.run is None
    assert page.document.target is TARGET
    assert mu_of(page) == LEARNED
    assert page.do(do.Redo()).document == end
    # Its iterations were forgotten; computed once more, they move nothing but the boards' path.
    for steps in (1, 2, 3):
        assert RUN in page.missing
        assert stepped(page, steps).document == end
    assert page.picture.trace is not None
    assert page.missing.keys() <= {MOTION, LANDSCAPE, CODEBOOK}


def test_undo_of_a_hand_on_a_run_lets_it_go_on_where_it_stood() -> None:
    page = stepped(running(iterations=3), 2)
    there = page.document
    page.do(do.SetMu(0, 0.4), do.Undo())
    assert page.document == there
    assert stepped(page, 3).picture.run_status == "finished"
    np.testing.assert_allclose(mu_of(page), BEST_PB)


def test_a_code_of_a_run_shows_its_iterate_until_it_has_come_there_again() -> None:
    for page in (stepped(running(), 2), stepped(running(), 2).do(do.CancelRecognition())):
        document = page.document
        other = Page().do(do.RestoreCode(encode(document)))
        assert other.document == document
        assert stepped(other, 1).document == document
        assert stepped(other, 2).document == document


def test_a_code_restores_exactly_what_a_recognition_found() -> None:
    """There is one set of bounds: |mu| > 20 and sigma > 5 are none of them."""
    page = running(iterations=3)
    page.deliver(RUN, make_trace(100 * PATH, loss=LOSS, sigma=7.25))
    latent = page.document.current.latent
    assert latent.mu == tuple(100 * PATH[1, 1] + 3.625)
    assert latent.sigma == (7.25, 7.25, 7.25)
    assert Page().do(do.RestoreCode(encode(page.document))).document == page.document


def test_a_run_that_goes_beyond_all_bounds_stays_within_them() -> None:
    page = running(iterations=3)
    page.deliver(RUN, make_trace(1e9 * PATH, loss=LOSS, sigma=1e9, epsilon=1.0))
    latent = page.document.current.latent
    assert (latent.mu, latent.sigma) == ((1e6, 1e6, 1e6), (1e6, 1e6, 1e6))
    assert decode(FACTS, encode(page.document)) == page.document


def test_after_the_run_a_drag_within_the_plane_leaves_the_landscape() -> None:
    page = finished().compute()
    x, y, _ = mu_of(page)
    page.do(do.MoveOnLandscape(0, ("μ1", "μ2"), (x + 0.01, y), 1))
    assert set(page.missing) == {MOTION, CODEBOOK}
