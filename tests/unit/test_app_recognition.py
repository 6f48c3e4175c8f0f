"""What a recognition does to the screen: target, settings, start, steps, end, and the way back."""

from __future__ import annotations

import math
import threading
from queue import Queue

import numpy as np
import pytest

from rnnpb_explorer.app.page.panels.recognise import status_line
from rnnpb_explorer.app.page.uploads import UploadReader, read_upload
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import AppState
from rnnpb_explorer.app.state.on_recognition import MAX_ITERATIONS, MAX_TRIALS
from rnnpb_explorer.app.state.transitions import stop_recognition
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.core.motion import MAX_CSV_BYTES, format_motion

from .app_states import (
    FACTS,
    JOINTS,
    MU,
    after,
    answer,
    landscapes,
    make_facts,
    make_trace,
    motions,
    open_screen,
    target_motion,
    wanted,
)

TIMEOUT = 20.0  # seconds until a test that hangs has failed; nothing waits for it otherwise
MOTION, LANDSCAPE = (do.GenerateWork, 0), (do.LandscapeWork, 0)
STOP = (do.CancelRecogniseWork, -1)
TARGET = target_motion(frames=10)
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
BEST_PB = PATH[1, 1] + 0.1  # `make_trace` samples each PB one sigma, 0.1, above mu


def with_target() -> AppState:
    return after(FACTS, open_screen(), do.SetTarget(TARGET))


def running(*, trials: int = 1) -> AppState:
    state = after(FACTS, with_target(), do.SetRecognitionOption("trials", trials))
    return after(FACTS, state, do.StartRecognition())


def stepped(state: AppState, steps: int, trials: int = 2) -> AppState:
    """The run as it is after so many steps along `PATH`."""
    for step in range(1, steps + 1):
        trace = make_trace(PATH[: step + 1, :trials], loss=LOSS[:step, :trials])
        state = after(FACTS, state, do.RecognitionStepped(state.recognition.request, trace))
    return state


def finished() -> AppState:
    state = stepped(running(trials=2), 3)
    return after(FACTS, state, do.RecognitionFinished(state.recognition.request))


# --- the target ---
def test_a_target_is_what_motion_and_landscape_are_compared_with() -> None:
    state, works = update(FACTS, open_screen(), do.SetTarget(TARGET))
    assert state.recognition.target is TARGET
    assert state.recognition.status == "idle"
    assert wanted((state, works)) == [MOTION, LANDSCAPE]
    assert motions(works)[0].target is landscapes(works)[0].target is TARGET.positions
    assert motions(works)[0].steps == 10
    assert state.notice is not None
    assert state.notice.good


def test_the_comparison_with_the_target_can_be_put_off_and_on() -> None:
    state, works = update(FACTS, with_target(), do.SetUseTarget(False))
    assert motions(works)[0].target is landscapes(works)[0].target is None
    assert motions(works)[0].steps == 12
    state, works = update(FACTS, state, do.SetUseTarget(True))
    assert motions(works)[0].target is landscapes(works)[0].target is TARGET.positions


def test_a_new_target_is_looked_at_even_where_the_last_one_was_not() -> None:
    state = after(FACTS, with_target(), do.SetUseTarget(False), do.SetTarget(target_motion(7)))
    assert state.use_target


def test_a_refused_upload_leaves_everything_but_says_why() -> None:
    before = finished()
    state, works = update(FACTS, before, do.RefuseTarget("row 3 has a gap"))
    assert works == ()
    assert state.models == before.models
    assert state.recognition.target is TARGET
    assert state.recognition is before.recognition  # with its line on the run
    assert state.notice is not None
    assert (state.notice.text, state.notice.good) == ("row 3 has a gap", False)


def test_a_target_with_other_joints_is_no_target_of_this_model() -> None:
    other = target_motion(joints=("x", "y", "z", "v", "w"))
    state, works = update(FACTS, open_screen(), do.SetTarget(other))
    assert motions(works)[0].target is None
    state, works = update(FACTS, state, do.StartRecognition())
    assert works == ()
    assert state.recognition.status == "idle"
    assert state.notice is not None
    assert "other joints" in state.notice.text


def test_a_target_that_is_forgotten_takes_its_run_with_it_and_leaves_the_settings() -> None:
    state = after(FACTS, finished(), do.SetRecognitionOption("observed", 0.5))
    state, works = update(FACTS, state, do.ClearTarget())
    recognition = state.recognition
    assert (recognition.target, recognition.trace, recognition.status) == (None, None, "idle")
    assert (recognition.observed, recognition.trials) == (0.5, 2)
    assert motions(works)[0].target is landscapes(works)[0].target is None


def test_undo_brings_the_last_target_back_and_what_was_compared_with_it() -> None:
    other = target_motion(frames=7, name="other")
    state = after(FACTS, with_target(), do.SetTarget(other))
    state, works = update(FACTS, state, do.Undo())
    assert state.recognition.target is TARGET
    assert wanted((state, works)) == [MOTION, LANDSCAPE]
    assert motions(works)[0].target is landscapes(works)[0].target is TARGET.positions
    state, works = update(FACTS, state, do.Undo())
    assert state.recognition.target is None
    assert motions(works)[0].target is landscapes(works)[0].target is None


# --- settings ---
@pytest.mark.parametrize(
    ("name", "value", "got"),
    [
        ("observed", 0.5, 0.5),
        ("observed", 7.0, 1.0),
        ("observed", -1.0, 0.1),
        ("iterations", 30, 30),
        ("iterations", 0, 1),
        ("iterations", 10**9, MAX_ITERATIONS),
        ("trials", 3.0, 3),
        ("trials", 0, 1),
        ("trials", 10**9, MAX_TRIALS),
        ("init", "random", "random"),
        ("init", "nonsense", "learned"),
    ],
)
def test_settings_stay_within_reason(name: str, value: float | str, got: float | str) -> None:
    state = after(FACTS, open_screen(), do.SetRecognitionOption(name, value))  # type: ignore[arg-type]
    assert getattr(state.recognition, name) == got


def test_a_start_takes_the_settings_along() -> None:
    state = after(
        FACTS,
        with_target(),
        do.SetRecognitionOption("observed", 0.6),
        do.SetRecognitionOption("iterations", 40),
        do.SetRecognitionOption("trials", 4),
        do.SetRecognitionOption("init", "baseline"),
    )
    state, (work,) = update(FACTS, state, do.StartRecognition())
    assert isinstance(work, do.RecogniseWork)
    assert (work.observed, work.iterations, work.trials, work.init) == (0.6, 40, 4, "baseline")
    assert work.target is TARGET.positions
    assert work.request == state.recognition.request > 0
    assert state.recognition.status == "running"


# --- start ---
def test_without_a_target_nothing_starts() -> None:
    state, works = update(FACTS, open_screen(), do.StartRecognition())
    assert works == ()
    assert state.recognition.status == "idle"
    assert state.notice is not None
    assert not state.notice.good


def test_every_start_has_noise_of_its_own() -> None:
    state, (first,) = update(FACTS, with_target(), do.StartRecognition())
    state, (stop, second) = update(FACTS, state, do.StartRecognition())
    assert isinstance(stop, do.CancelRecogniseWork)
    assert isinstance(first, do.RecogniseWork)
    assert isinstance(second, do.RecogniseWork)
    assert first.seed != second.seed
    assert first.request < second.request


def test_a_run_looks_at_its_target() -> None:
    state = after(FACTS, with_target(), do.SetUseTarget(False))
    state, works = update(FACTS, state, do.StartRecognition())
    assert state.use_target
    assert landscapes(works)[0].target is TARGET.positions


# --- steps ---
def test_the_robot_follows_the_newest_iterate() -> None:
    state = stepped(running(), 1, trials=1)
    latent = state.current.latent
    np.testing.assert_allclose(latent.mu, PATH[0, 0])
    np.testing.assert_allclose(latent.pb, PATH[0, 0] + 0.2 * 0.5)  # the PB sampled there
    trace = make_trace(PATH[:3, :1], loss=LOSS[:2, :1])
    state, works = update(FACTS, state, do.RecognitionStepped(state.recognition.request, trace))
    np.testing.assert_allclose(state.current.latent.mu, PATH[1, 0])
    np.testing.assert_allclose(motions(works)[0].pb, PATH[1, 0] + 0.1)
    assert landscapes(works) == []  # it waits until the end
    assert state.recognition.trace is trace
    assert "iteration 2 of 100" in status_line(state.recognition)


def test_steps_are_no_steps_of_undo() -> None:
    state = running()
    assert len(stepped(state, 3, trials=1).undo) == len(state.undo)


def test_a_step_of_another_run_is_dropped() -> None:
    state = stepped(running(), 1, trials=1)
    late = do.RecognitionStepped(state.recognition.request - 1, make_trace(PATH[:4, :1]))
    assert update(FACTS, state, late) == (state, ())
    cancelled = after(FACTS, state, do.CancelRecognition())
    late = do.RecognitionStepped(state.recognition.request, make_trace(PATH[:4, :1]))
    assert update(FACTS, cancelled, late) == (cancelled, ())
    over = do.RecognitionFinished(state.recognition.request)
    assert update(FACTS, cancelled, over) == (cancelled, ())


# --- the end ---
def test_in_the_end_it_goes_to_the_best_pb_of_all_trials() -> None:
    state = stepped(running(trials=2), 3)
    state, works = update(FACTS, state, do.RecognitionFinished(state.recognition.request))
    recognition = state.recognition
    assert recognition.status == "finished"
    assert recognition.trial == 1
    np.testing.assert_allclose(state.current.latent.mu, BEST_PB)
    np.testing.assert_allclose(motions(works)[0].pb, BEST_PB)
    np.testing.assert_allclose(landscapes(works)[0].center[2], BEST_PB[2])
    assert "2 of trial 2" in recognition.message
    assert "0.20000" in recognition.message
    assert status_line(recognition).startswith("Recognition done")


def test_the_landscape_comes_even_where_the_last_iterate_is_the_best() -> None:
    state = stepped(running(), 1, trials=1)
    _, works = update(FACTS, state, do.RecognitionFinished(state.recognition.request))
    np.testing.assert_allclose(landscapes(works)[0].center[2], PATH[0, 0, 2] + 0.1)


def test_a_loss_that_is_no_number_is_never_the_best() -> None:
    state = running()
    trace = make_trace(PATH[:, :1], loss=np.array([[0.5], [0.3], [math.nan]]))
    request = state.recognition.request
    state = after(
        FACTS, state, do.RecognitionStepped(request, trace), do.RecognitionFinished(request)
    )
    np.testing.assert_allclose(state.current.latent.mu, PATH[1, 0] + 0.1)


def test_where_everything_is_observed_there_is_no_prediction_to_speak_of() -> None:
    state = running()
    trace = make_trace(PATH[:, :1])
    trace.prediction_error[:] = math.nan
    request = state.recognition.request
    state = after(
        FACTS, state, do.RecognitionStepped(request, trace), do.RecognitionFinished(request)
    )
    assert "nan" not in state.recognition.message


def test_a_run_without_an_iteration_ends_where_it_began() -> None:
    state = running()
    state, works = update(FACTS, state, do.RecognitionFinished(state.recognition.request))
    assert state.recognition.status == "finished"
    assert works == ()
    assert state.current.latent.mu.tolist() == MU[0].tolist()


def test_the_iteration_on_the_screen_is_known_however_a_run_ends() -> None:
    state = stepped(running(trials=2), 3)
    request = state.recognition.request
    ends = [
        after(FACTS, state, do.CancelRecognition()),
        after(FACTS, state, do.WorkFailed("recognition", request, "broken")),
        stop_recognition(state)[0],  # a reload
    ]
    for end in ends:
        recognition = end.recognition
        assert (recognition.iteration, recognition.trial) == (2, 0)  # the best is (1, 1)
        np.testing.assert_allclose(end.current.latent.mu, PATH[2, 0])
    end = after(FACTS, state, do.RecognitionFinished(request))
    assert (end.recognition.iteration, end.recognition.trial) == (1, 1)
    end = after(FACTS, end, do.ScrubRecognition(0, 1))
    assert (end.recognition.iteration, end.recognition.trial) == (0, 1)
    assert with_target().recognition.iteration == 0


def test_cancelling_leaves_the_path_and_the_robot_where_they_are() -> None:
    state = stepped(running(), 2, trials=1)
    state, works = update(FACTS, state, do.CancelRecognition())
    assert (do.CancelRecogniseWork, -1) in wanted((state, works))
    assert state.recognition.status == "cancelled"
    assert state.recognition.trace is not None
    np.testing.assert_allclose(state.current.latent.mu, PATH[1, 0])
    assert "cancelled after 2 iterations" in status_line(state.recognition)
    # The landscape had waited for the end, and this is one.
    np.testing.assert_allclose(landscapes(works)[0].center[2], PATH[1, 0, 2])


def test_without_a_run_there_is_nothing_to_cancel() -> None:
    state = with_target()
    assert update(FACTS, state, do.CancelRecognition()) == (state, ())


@pytest.mark.parametrize(
    "intent",
    [
        do.SetMu(0, 0.4),
        do.SetSigma(0, 0.4),
        do.MoveOnMap((0, 1), (0.0, 0.0), 1),
        do.MoveOnLandscape((0.1, 0.2), 1),
        do.SelectMotion(2),
        do.NewNoise(),
        do.RandomiseLatent(),
        do.Undo(),
        do.SetTarget(target_motion(7)),
        do.ClearTarget(),
    ],
    ids=lambda intent: type(intent).__name__,
)
def test_a_hand_on_the_robot_stops_the_run(intent: do.Intent) -> None:
    state, works = update(FACTS, stepped(running(), 2, trials=1), intent)
    assert wanted((state, works))[0] == STOP
    assert state.recognition.status in ("cancelled", "idle")
    # The landscape waited for the end of the run; only undo leads to where it was left.
    assert len(landscapes(works)) == (0 if isinstance(intent, do.Undo) else 1)


@pytest.mark.parametrize(
    "intent", [do.Tick(0.1), do.TogglePlaying(), do.Seek(2), do.SetColouring("valence"), do.Redo()]
)
def test_looking_does_not_stop_the_run(intent: do.Intent) -> None:
    state = after(FACTS, stepped(running(), 2, trials=1), intent)
    assert state.recognition.status == "running"


def test_a_failure_ends_the_run_and_says_why() -> None:
    state = stepped(running(), 2, trials=1)
    failure = do.WorkFailed("recognition", state.recognition.request, "out of memory")
    state, works = update(FACTS, state, failure)
    assert state.recognition.status == "failed"
    assert state.recognition.trace is not None
    assert status_line(state.recognition) == "Recognition failed: out of memory"
    assert state.notice is not None
    assert state.notice.text == "out of memory"
    np.testing.assert_allclose(landscapes(works)[0].center[2], PATH[1, 0, 2])
    state, works = update(FACTS, state, do.StartRecognition())
    assert state.recognition.status == "running"


def test_the_failure_of_another_run_is_none_of_this_one() -> None:
    state = running()
    late = do.WorkFailed("recognition", state.recognition.request - 1, "out of memory")
    assert update(FACTS, state, late) == (state, ())


@pytest.mark.parametrize("work", ["motion", "landscape"])
def test_other_failures_leave_the_run_alone(work: str) -> None:
    state, works = update(FACTS, running(), do.WorkFailed(work, 1, "broken"))  # type: ignore[arg-type]
    assert works == ()
    assert state.recognition.status == "running"
    assert state.notice is not None
    assert state.notice.text == "broken"


# --- afterwards ---
def test_scrubbing_shows_an_iterate_again() -> None:
    state, works = update(FACTS, finished(), do.ScrubRecognition(0, 0))
    assert (state.recognition.shown, state.recognition.trial) == (0, 0)
    np.testing.assert_allclose(state.current.latent.mu, PATH[0, 0])
    np.testing.assert_allclose(state.current.latent.sigma, 0.2)
    np.testing.assert_allclose(motions(works)[0].pb, PATH[0, 0] + 0.1)


@pytest.mark.parametrize(("asked", "got"), [((99, 99), (2, 1)), ((-5, -5), (0, 0))])
def test_scrubbing_stays_within_the_run(asked: tuple[int, int], got: tuple[int, int]) -> None:
    recognition = after(FACTS, finished(), do.ScrubRecognition(*asked)).recognition
    assert (recognition.shown, recognition.trial) == got


def test_scrubbing_is_one_step_back_however_far() -> None:
    state = finished()
    scrubbed = after(FACTS, state, *(do.ScrubRecognition(i, 0) for i in (2, 1, 0)), do.Undo())
    assert scrubbed.recognition.shown is None
    np.testing.assert_allclose(scrubbed.current.latent.mu, BEST_PB)


def test_there_is_nothing_to_scrub_before_and_during_a_run() -> None:
    for state in (with_target(), stepped(running(), 2, trials=1)):
        assert update(FACTS, state, do.ScrubRecognition(0, 0)) == (state, ())


def test_a_pb_sampled_without_spread_is_mu() -> None:
    state = running()
    trace = make_trace(PATH[:2, :1], sigma=0.0)
    state = after(FACTS, state, do.RecognitionStepped(state.recognition.request, trace))
    assert state.current.latent.epsilon.tolist() == [0.0, 0.0, 0.0]


def test_undo_goes_back_to_before_the_run_and_redo_to_its_end() -> None:
    state = after(FACTS, finished(), do.Undo())
    assert state.recognition.status == "idle"
    assert state.recognition.trace is None
    assert state.recognition.target is TARGET
    assert state.current.latent.mu.tolist() == MU[0].tolist()
    state = after(FACTS, state, do.Redo())
    assert state.recognition.status == "finished"
    assert state.recognition.trace is not None
    np.testing.assert_allclose(state.current.latent.mu, BEST_PB)


def test_undo_and_redo_leave_the_settings_of_the_next_run() -> None:
    state = after(FACTS, finished(), do.SetMu(0, 0.4), do.SetRecognitionOption("observed", 0.5))
    state = after(FACTS, state, do.Undo())
    assert state.recognition.trace is not None
    assert state.recognition.observed == 0.5
    state = after(FACTS, state, do.SetRecognitionOption("trials", 7), do.Redo())
    assert state.recognition.trials == 7


@pytest.mark.parametrize(
    "intent",
    [do.SetMu(0, 0.4), do.CancelRecognition(), do.RestoreCode("rnnpb1-x"), do.StartRecognition()],
    ids=lambda intent: type(intent).__name__,
)
def test_no_way_back_leads_into_a_run_that_nobody_runs(intent: do.Intent) -> None:
    state = after(FACTS, stepped(running(), 2, trials=1), intent)
    if isinstance(intent, do.RestoreCode):  # a refused code changes nothing at all
        assert state.recognition.status == "running"
        return
    for _ in range(3):
        state = after(FACTS, state, do.Undo())
        assert state.recognition.status != "running"
    for _ in range(3):
        state = after(FACTS, state, do.Redo())
        assert state.recognition.status != "running"


def test_after_the_run_a_drag_within_the_plane_leaves_the_landscape() -> None:
    state = stepped(running(), 2, trials=1)
    state, works = update(FACTS, state, do.RecognitionFinished(state.recognition.request))
    state = answer(FACTS, state, works)
    x, y, _ = state.current.latent.mu.tolist()
    assert wanted(update(FACTS, state, do.MoveOnLandscape((x + 0.01, y), 1))) == [MOTION]


# --- uploads ---
def test_an_upload_becomes_the_target() -> None:
    content = format_motion(TARGET).encode()
    intent = read_upload("my wave.csv", content, FACTS[0])
    assert isinstance(intent, do.SetTarget)
    assert intent.motion.name == "my wave"
    assert intent.motion.joints == JOINTS
    assert intent.motion.fps == 20.0
    np.testing.assert_array_equal(intent.motion.positions, TARGET.positions)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "x.csv"),
        (b"a,b,c,d\n1,2,3,4\n1,2,3,4\n", "no column for e"),
        (b"\xff\xfe\x00", "x.csv"),
        (b"a,b,c,d,e\n1,2,3,4,nan\n1,2,3,4,5\n", "row 2"),
        (b"x" * (MAX_CSV_BYTES + 1), "larger than 8 MB"),
    ],
    ids=["empty", "joint missing", "no text", "nan", "too large"],
)
def test_an_upload_that_is_no_motion_is_refused_in_one_line(content: bytes, says: str) -> None:
    intent = read_upload("x.csv", content, FACTS[0])
    assert isinstance(intent, do.RefuseTarget)
    assert says in intent.reason
    assert "\n" not in intent.reason


@pytest.mark.parametrize("name", ["", "\n\r\x00.csv", "x" * 10_000 + ".csv", "<b>é\u202e.csv"])
def test_an_upload_may_be_called_anything(name: str) -> None:
    intent = read_upload(name, format_motion(TARGET).encode(), FACTS[0])
    assert isinstance(intent, do.SetTarget)
    assert intent.motion.name.isprintable()
    assert 0 < len(intent.motion.name) <= 80


def test_what_is_chosen_while_another_file_is_read_stays_chosen() -> None:
    content = format_motion(TARGET).encode()
    begun, chosen = threading.Event(), threading.Event()

    def large() -> bytes:
        begun.set()
        assert chosen.wait(TIMEOUT)
        return content

    sent: Queue[do.Intent] = Queue()
    reader = UploadReader(sent.put)
    reader.read("large.csv", large, FACTS[0])
    assert begun.wait(TIMEOUT)
    reader.read("small.csv", lambda: content, FACTS[0])
    chosen.set()
    intent = sent.get(timeout=TIMEOUT)  # they are read one after the other
    assert isinstance(intent, do.SetTarget)
    assert intent.motion.name == "small"
    assert sent.empty()


@pytest.mark.parametrize("error", [OSError("no such file"), MemoryError("too much")])
def test_a_file_that_cannot_be_read_is_logged_and_said(
    error: Exception, caplog: pytest.LogCaptureFixture
) -> None:
    def broken() -> bytes:
        raise error

    sent: Queue[do.Intent] = Queue()
    UploadReader(sent.put).read("x.csv", broken, FACTS[0])
    assert sent.get(timeout=TIMEOUT) == do.RefuseTarget(f"the file could not be read: {error}")
    (record,) = caplog.records
    assert record.exc_info is not None
    assert record.exc_info[1] is error


def test_a_deterministic_model_recognises_as_well() -> None:
    facts = (make_facts(stochastic=False),)
    state = after(facts, open_screen(facts), do.SetTarget(TARGET), do.StartRecognition())
    trace = make_trace(PATH[:3, :1], sigma=0.0)
    request = state.recognition.request
    state = after(
        facts, state, do.RecognitionStepped(request, trace), do.RecognitionFinished(request)
    )
    assert state.recognition.status == "finished"
    assert not state.current.latent.epsilon.any()
