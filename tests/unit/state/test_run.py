"""A run that is not the published one, that pauses, steps, goes slowly; what is observed of it."""

from __future__ import annotations

import dataclasses
from typing import get_args

import numpy as np
import pytest
from msgspec.structs import replace

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import MAX_ADDED
from rnnpb_explorer.app.state.on_recognition import advance
from rnnpb_explorer.app.state.results import BeliefResult, CodebookResult, RecognitionTrace
from rnnpb_explorer.app.state.statecode import encode
from rnnpb_explorer.app.state.wanted import joint_indices, seen_target, take_away_work
from rnnpb_explorer.app.state.work import BeliefWork, RecogniseWork
from rnnpb_explorer.core import InputError
from rnnpb_explorer.core.belief import Cloud, Mode
from rnnpb_explorer.core.recognition_run import Method, Posterior

from ..app_states import (
    BELIEF,
    CODEBOOK,
    FACTS,
    RUN,
    Page,
    after,
    make_facts,
    make_target,
    make_trace,
    motion_result,
    opened,
)

TARGET = make_target(frames=10)
PATH = np.linspace(0.1, 0.9, 6 * 3).reshape(6, 1, 3)  # one trial of five iterations


def running(method: str = "global", *options: do.DocumentIntent) -> Page:
    chosen = do.SetRecognitionOption("method", method)
    return Page().do(do.SetTarget(TARGET), chosen, *options, do.StartRecognition())


def came(page: Page, steps: int, *, finished: bool = False) -> Page:
    trace = make_trace(PATH[: steps + 1], finished=finished)
    return page.deliver(RUN, trace, done=finished)


def run_work(page: Page) -> RecogniseWork:
    work = page.wanted[RUN]
    assert isinstance(work, RecogniseWork)
    return work


# --- methods ---
@pytest.mark.parametrize("method", get_args(Method))
def test_every_method_can_be_chosen_and_starts(method: str) -> None:
    page = running(method)
    assert run_work(page).method == method
    assert run_work(page).iterations == (100 if method == "paper" else None)


@pytest.mark.parametrize("method", ["global", "live"])
def test_it_ends_when_it_says_so_and_not_before(method: str) -> None:
    page = came(running(method), 3)
    assert page.picture.run_status == "running"
    assert RUN in page.missing
    came(page, 3, finished=True)
    assert page.picture.run_status == "finished"
    assert RUN not in page.missing


def test_in_the_end_sigma_is_that_of_the_posterior() -> None:
    page = running()
    trace = make_trace(PATH[:4], finished=True)
    belief = Posterior(np.zeros(3), np.diag([0.04, 0.09, 0.25]), np.zeros((10, 5)))
    page.deliver(RUN, dataclasses.replace(trace, posterior=belief))
    assert page.document.current.latent.sigma == pytest.approx((0.2, 0.3, 0.5))
    assert page.picture.posterior is belief
    page.do(do.SetMu(0, 0.0))
    assert page.picture.posterior is None  # a hand has moved it away from there


def test_a_live_run_begins_with_the_motion_and_ends_at_its_last_frame() -> None:
    page = Page().do(do.SetTarget(TARGET), do.SetPlaying(False, 5.0), do.SetSpeed(2.0))
    page.do(do.SetRecognitionOption("method", "live"), do.StartRecognition())
    playback = page.document.playback
    assert (playback.playing, playback.phase, playback.speed) == (True, 0.0, 1.0)
    came(page, 5, finished=True)
    np.testing.assert_allclose(page.document.current.latent.mu, PATH[4, 0])


def test_what_is_cancelled_keeps_its_iterations_and_a_reload_asks_for_as_many() -> None:
    page = came(running("live"), 3).do(do.CancelRecognition())
    assert page.picture.run_status == "cancelled"
    assert run_work(page).iterations == 3
    other = Page().do(do.RestoreCode(encode(page.document)))
    assert run_work(other).iterations == 3
    document = other.document
    came(other, 2)
    assert other.document == document


def test_a_finished_run_that_comes_back_waits_for_its_end() -> None:
    page = came(running(), 3, finished=True)
    document = page.document
    other = Page().do(do.RestoreCode(encode(document)))
    for steps in (1, 2, 3):
        assert came(other, steps).document == document
    assert came(other, 3, finished=True).document == document


def test_too_short_a_part_to_follow() -> None:
    with pytest.raises(InputError, match="leaves no frame to observe"):
        Page().do(
            do.SetTarget(make_target(frames=2)),
            do.SetRecognitionOption("method", "live"),
            do.SetRecognitionOption("observed", 0.1),
            do.StartRecognition(),
        )


# --- pause, step, pace ---
def shown(page: Page) -> int:
    run = page.document.run
    assert run is not None
    return run.done


def test_a_pause_holds_what_is_shown_while_more_is_computed() -> None:
    page = came(running(), 2).do(do.PauseRecognition(True))
    came(page, 4)
    assert shown(page) == 2
    np.testing.assert_allclose(page.document.current.latent.mu, PATH[1, 0])
    trace = page.picture.trace
    assert trace is not None
    assert trace.iterations == 2
    page.do(do.PauseRecognition(False))
    assert shown(page) == 4


def test_single_steps_to_the_end() -> None:
    page = came(running(), 2).do(do.PauseRecognition(True))
    came(page, 4, finished=True)
    assert page.picture.run_status == "running"
    page.do(do.StepRecognition())
    assert (shown(page), page.picture.run_status) == (3, "running")
    page.do(do.StepRecognition())
    assert (shown(page), page.picture.run_status) == (4, "finished")


def test_a_step_pauses_a_run() -> None:
    page = came(running(), 1).do(do.StepRecognition())
    came(page, 4)
    assert shown(page) == 2
    assert page.document.run is not None
    assert page.document.run.paused


def test_a_slow_run_goes_on_only_when_it_is_told_to() -> None:
    page = running("global", do.SetRecognitionOption("slow", 1))
    came(page, 4, finished=True)
    for expected in (1, 2, 3):
        assert shown(page) == expected
        page.history = page.history.revise(advance(page.document))
        page.do()
        page._follow()
    assert page.picture.run_status == "finished"


def test_cancelling_a_pause_leaves_it_where_it_stands() -> None:
    page = came(running(), 2).do(do.PauseRecognition(True))
    came(page, 4).do(do.CancelRecognition())
    assert (shown(page), page.picture.run_status) == (2, "cancelled")


@pytest.mark.parametrize("intent", [do.PauseRecognition(True), do.StepRecognition()])
def test_there_is_nothing_to_pause_without_a_run(intent: do.DocumentIntent) -> None:
    for document in (opened(), came(running(), 3, finished=True).document):
        assert after(FACTS, document, intent) == document


# --- joints ---
def test_some_joints_are_observed_the_others_hidden() -> None:
    page = running("global", do.SetRecognitionOption("joints", ("d", "a", "x")))
    assert page.document.recognition.joints == ("a", "d")
    assert run_work(page).joints == (0, 3)
    seen = seen_target(FACTS, page.document, 0)
    assert seen is not None
    assert np.isnan(seen[:, [1, 2, 4]]).all()
    np.testing.assert_array_equal(seen[:, [0, 3]], TARGET.array[:8, [0, 3]])
    page.do(do.SetRevealed(True))
    np.testing.assert_array_equal(seen_target(FACTS, page.document, 0), TARGET.array)


def test_all_joints_are_none_in_particular() -> None:
    document = opened(FACTS, do.SetRecognitionOption("joints", FACTS[0].joints))
    assert document.recognition.joints == ()
    assert joint_indices(FACTS[0], ()) == ()


def test_one_joint_at_least() -> None:
    with pytest.raises(InputError, match="At least one joint"):
        opened(FACTS, do.SetRecognitionOption("joints", ()))


def test_a_code_that_names_a_joint_that_is_not_there_is_refused() -> None:
    page = came(running("global", do.SetRecognitionOption("joints", ("a",))), 2)
    run = page.document.run
    assert run is not None
    broken = replace(page.document, run=replace(run, settings=replace(run.settings, joints=("q",))))
    with pytest.raises(InputError, match="recognition that cannot be"):
        Page().do(do.RestoreCode(encode(broken)))


# --- KL ---
def test_the_kl_term_is_the_next_runs_and_only_where_there_is_a_sigma() -> None:
    page = running("global", do.SetRecognitionOption("beta", 1e-3))
    assert run_work(page).beta == 1e-3
    facts = (make_facts(stochastic=False),)
    other = Page(facts).do(
        do.SetTarget(TARGET), do.SetRecognitionOption("beta", 1e-3), do.StartRecognition()
    )
    assert run_work(other).beta == 0.0
    assert opened(FACTS, do.SetRecognitionOption("beta", -1.0)).recognition.beta == 0.0


# --- codebook and belief ---
def a_cloud() -> Cloud:
    mode = Mode(np.zeros(3, np.float32), 0.7)
    return Cloud(
        frames=np.array([0]),
        pbs=np.zeros((2, 3), np.float32),
        weights=np.full((1, 2), 0.5, np.float32),
        entropy=np.ones(1, np.float32),
        modes=(mode, Mode(np.ones(3, np.float32), 0.3)),
        nearest=np.arange(4, dtype=np.float32),
        entries=2,
    )


def test_a_target_wants_a_codebook_and_as_it_grows_the_belief_anew() -> None:
    page = Page()
    assert CODEBOOK not in page.wanted
    page.do(do.SetTarget(TARGET))
    assert CODEBOOK in page.wanted
    assert BELIEF not in page.wanted
    for entries in (64, 128):
        page.deliver(CODEBOOK, CodebookResult(entries, 128, 0.0), done=entries == 128)
        work = page.wanted[BELIEF]
        assert isinstance(work, BeliefWork)
        assert (work.entries, work.observed, work.scale) == (entries, 0.8, 0.1)
        page.deliver(BELIEF, BeliefResult(a_cloud(), ()))
    assert page.picture.belief is not None
    assert page.picture.codebook == CodebookResult(128, 128, 0.0)
    page.do(do.SetErrorScale(0.3))
    assert BELIEF in page.missing
    assert page.picture.belief is not None  # the old one stays until the new one is there
    page.do(do.SetCloud(False))
    assert BELIEF not in page.wanted
    assert page.picture.belief is None


def test_what_the_belief_is_torn_between_is_seen_as_ghosts() -> None:
    page = Page().do(do.SetTarget(TARGET))
    page.deliver(CODEBOOK, CodebookResult(128, 128, 0.0))
    motions = (np.zeros((10, 5), np.float32), np.ones((10, 5), np.float32))
    page.deliver(BELIEF, BeliefResult(a_cloud(), motions))
    assert page.picture.ghosts(0) == motions
    assert page.do(do.SetExplanations(False)).picture.ghosts(0) == ()
    page.do(do.SetExplanations(True)).deliver(BELIEF, BeliefResult(a_cloud(), motions[:1]))
    assert page.picture.ghosts(0) == ()  # one explanation is no choice


@pytest.mark.parametrize(("asked", "got"), [(0.2, 0.2), (9.0, 1.0), (0.0, 0.01), (np.nan, 0.1)])
def test_the_error_scale_has_bounds(asked: float, got: float) -> None:
    assert opened(FACTS, do.SetErrorScale(asked)).error_scale == got


# --- the verdict ---
def test_how_much_is_explained_follows_what_is_on_the_screen() -> None:
    page = Page().do(do.SetTarget(TARGET)).compute()
    before = page.picture.explained
    assert before is not None
    page.do(do.SetMu(0, 0.4))
    work = page.wanted["motion", 0]
    page.deliver(("motion", 0), motion_result(work))  # type: ignore[arg-type]
    assert page.picture.explained != before
    assert Page().picture.explained is None


# --- points of one's own ---
def test_a_point_is_added_found_again_undone_and_taken_away() -> None:
    page = Page().do(do.SetMu(0, 0.4), do.AddToMap("mine"))
    (added,) = page.document.added
    assert (added.name, added.mu) == ("mine", page.document.current.latent.mu)
    page.do(do.SetMu(0, -0.4), do.SelectAdded(0))
    assert page.document.current.latent.mu == added.mu
    other = Page().do(do.RestoreCode(encode(page.document)))
    assert other.document.added == (added,)
    page.do(do.RemoveAdded())
    assert page.document.added == ()
    assert page.do(do.Undo()).document.added == (added,)
    assert after(FACTS, page.document, do.SelectAdded(7)) == page.document


def test_the_map_takes_so_many_points() -> None:
    page = Page().do(*(do.AddToMap(str(number)) for number in range(MAX_ADDED)))
    with pytest.raises(InputError, match="50 points"):
        page.do(do.AddToMap("one more"))


def test_a_point_of_another_size_is_refused() -> None:
    page = Page().do(do.AddToMap("mine"))
    (added,) = page.document.added
    for broken in (replace(added, mu=(0.0,)), replace(added, model=3)):
        code = encode(replace(page.document, added=(broken,)))
        with pytest.raises(InputError, match="on none of these maps"):
            Page().do(do.RestoreCode(code))


# --- take it away ---
def test_there_is_nothing_to_take_away_before_a_run() -> None:
    page = Page().do(do.SetTarget(TARGET))
    with pytest.raises(InputError, match="no recognition yet"):
        take_away_work(FACTS, page.document, page.picture.trace, "path")


def test_what_was_shown_is_taken_away() -> None:
    page = came(running(), 2).do(do.PauseRecognition(True))
    came(page, 4)
    work = take_away_work(FACTS, page.document, page.picture.trace, "png")
    assert isinstance(work.trace, RecognitionTrace)
    assert (work.trace.iterations, work.what, work.name) == (2, "png", "given tiny")
