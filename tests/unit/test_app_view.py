"""How things are shown: playback, axes, window, and what becomes of finished work."""

from __future__ import annotations

import numpy as np
import pytest

from rnnpb_explorer.app.page.panels.playback import frame_of
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import AppState, initial_state
from rnnpb_explorer.app.state.on_view import MAX_SPEED, MIN_SPEED
from rnnpb_explorer.app.state.slices import landscape_slice
from rnnpb_explorer.app.state.transitions import Facts, opening_work
from rnnpb_explorer.app.state.update import update

from .app_states import (
    FACTS,
    MU,
    ONE_DIMENSION,
    TWELVE_DIMENSIONS,
    after,
    answer,
    landscape_result,
    landscapes,
    make_facts,
    motion_result,
    motions,
    open_screen,
    wanted,
)

MOTION, LANDSCAPE = (do.GenerateWork, 0), (do.LandscapeWork, 0)
LAST = 11  # the opening motion has 12 frames
FRAME = 1 / 20  # seconds


# --- playback ---
def test_time_moves_the_motion_at_its_own_rate() -> None:
    state = after(FACTS, open_screen(), do.Tick(3 * FRAME))
    assert frame_of(state) == 3
    assert frame_of(after(FACTS, state, do.Tick(2 * FRAME))) == 5


def test_speed_multiplies_time() -> None:
    assert frame_of(after(FACTS, open_screen(), do.SetSpeed(2.0), do.Tick(3 * FRAME))) == 6
    assert frame_of(after(FACTS, open_screen(), do.SetSpeed(0.5), do.Tick(4 * FRAME))) == 2


@pytest.mark.parametrize(("asked", "got"), [(0.0, MIN_SPEED), (99.0, MAX_SPEED), (-1, MIN_SPEED)])
def test_speed_stays_within_reason(asked: float, got: float) -> None:
    assert after(FACTS, open_screen(), do.SetSpeed(asked)).playback.speed == got


def test_a_looped_motion_begins_again() -> None:
    state = after(FACTS, open_screen(), do.Tick(11 * FRAME), do.Tick(2 * FRAME))
    assert state.playback.playing
    assert frame_of(state) == 2


def test_a_long_pause_of_the_clock_is_many_rounds() -> None:
    state = after(FACTS, open_screen(), do.Tick(1000 * 11 * FRAME + 4 * FRAME))
    assert 0.0 <= state.playback.phase < 1.0
    assert frame_of(state) == 4


def test_without_loop_it_stops_at_the_last_frame() -> None:
    state = after(FACTS, open_screen(), do.SetLoop(False), do.Tick(50 * FRAME))
    assert not state.playback.playing
    assert frame_of(state) == LAST
    assert frame_of(after(FACTS, state, do.Tick(1.0))) == LAST


def test_play_at_the_end_begins_again() -> None:
    state = after(FACTS, open_screen(), do.SetLoop(False), do.Tick(50 * FRAME), do.TogglePlaying())
    assert state.playback.playing
    assert frame_of(state) == 0


def test_a_state_that_time_does_not_change_stays_the_same_one() -> None:
    state = after(FACTS, open_screen(), do.SetPlaying(False), do.Tick(1.0))
    assert update(FACTS, state, do.Tick(1.0)) == (state, ())
    state = after(FACTS, state, do.SetMu(0, 0.5))
    assert update(FACTS, state, do.Tick(0.1)) != (state, ())  # the gesture goes on
    state = after(FACTS, state, do.Tick(1.0))
    assert update(FACTS, state, do.Tick(1.0)) == (state, ())


def test_a_paused_motion_stands_still_and_goes_on_from_there() -> None:
    state = after(FACTS, open_screen(), do.Tick(3 * FRAME), do.TogglePlaying(), do.Tick(1.0))
    assert frame_of(state) == 3
    state = after(FACTS, state, do.SetPlaying(True), do.Tick(FRAME))
    assert frame_of(state) == 4


@pytest.mark.parametrize(("asked", "got"), [(7, 7), (0, 0), (LAST, LAST), (99, LAST), (-4, 0)])
def test_seeking_pauses_at_a_frame(asked: int, got: int) -> None:
    state = after(FACTS, open_screen(), do.Seek(asked))
    assert not state.playback.playing
    assert frame_of(state) == got


def test_every_frame_can_be_sought() -> None:
    state = open_screen()
    assert [frame_of(after(FACTS, state, do.Seek(i))) for i in range(12)] == list(range(12))


def test_the_phase_survives_a_change_of_length() -> None:
    state = after(FACTS, open_screen(), do.Seek(LAST // 2 + 1))  # 6 of 11
    phase = state.playback.phase
    state, works = update(FACTS, state, do.SelectMotion(3))  # 21 frames
    assert state.playback.phase == phase
    state = answer(FACTS, state, works)
    assert state.playback.phase == phase
    assert frame_of(state) == round(6 / 11 * 20)


def test_playing_goes_on_while_the_latent_moves() -> None:
    state = after(FACTS, open_screen(), do.Tick(3 * FRAME))
    state, works = update(FACTS, state, do.SetMu(0, 0.9))
    state = after(FACTS, answer(FACTS, state, works), do.Tick(FRAME))
    assert frame_of(state) == 4


def test_before_the_first_motion_there_is_no_frame() -> None:
    state = initial_state(FACTS)
    assert frame_of(state) == 0
    assert update(FACTS, state, do.Seek(3)) == (state, ())
    assert after(FACTS, state, do.Tick(1.0)).playback.phase == 0.0


def test_time_alone_wants_no_work() -> None:
    _, works = update(FACTS, open_screen(), do.Tick(0.03))
    assert works == ()


# --- what the boards show ---
def test_other_axes_want_another_landscape() -> None:
    state, works = update(FACTS, open_screen(), do.SetLandscapeAxes((2, 1)))
    assert wanted((state, works)) == [LANDSCAPE]
    assert landscapes(works)[0].directions.tolist() == [[0, 0, 1], [0, 1, 0]]
    where = landscape_slice(FACTS[0], state, state.current)
    assert where.labels == ("μ3", "μ2")
    assert where.middle.tolist() == [0.2, -0.3]


def test_the_plane_of_the_map_is_a_landscape_too() -> None:
    state, works = update(FACTS, open_screen(), do.SetLandscapeAxes("pca"))
    latent_map = FACTS[0].latent_map
    np.testing.assert_array_equal(landscapes(works)[0].directions, latent_map.components[:2])
    np.testing.assert_array_equal(landscapes(works)[0].zero, latent_map.mean)
    np.testing.assert_allclose(landscapes(works)[0].center, MU[0])
    where = landscape_slice(FACTS[0], state, state.current)
    assert where.labels == ("PC1", "PC2")
    np.testing.assert_allclose(where.middle, latent_map.project(MU[0])[:2])


def test_the_maps_axes_matter_to_the_landscape_only_in_its_own_plane() -> None:
    assert wanted(update(FACTS, open_screen(), do.SetMapAxes((1, 2)))) == []
    state = after(FACTS, open_screen(), do.SetLandscapeAxes("pca"))
    _, works = update(FACTS, state, do.SetMapAxes((1, 2)))
    np.testing.assert_array_equal(
        landscapes(works)[0].directions, FACTS[0].latent_map.components[[1, 2]]
    )


@pytest.mark.parametrize(
    ("facts", "axes"),
    [
        (FACTS, (0,)),
        (FACTS, (0, 0)),
        (FACTS, (0, 3)),
        (FACTS, (-1, 0)),
        (FACTS, (0, 1, 2)),
        (FACTS, ()),
        (ONE_DIMENSION, (0, 1)),
        (ONE_DIMENSION, (1,)),
    ],
)
def test_axes_that_there_are_not_change_nothing(facts: Facts, axes: tuple[int, ...]) -> None:
    state = open_screen(facts)
    assert update(facts, state, do.SetMapAxes(axes)) == (state, ())
    assert update(facts, state, do.SetLandscapeAxes(axes)) == (state, ())


@pytest.mark.parametrize("facts", [ONE_DIMENSION, FACTS, TWELVE_DIMENSIONS])
def test_the_same_view_again_costs_nothing(facts: Facts) -> None:
    state = open_screen(facts)
    axes = state.map_axes
    for intent in (do.SetMapAxes(axes), do.SetLandscapeAxes(axes), do.SetWindow("absolute")):
        assert wanted(update(facts, state, intent)) == []


def test_a_window_that_loses_the_puck_moves_to_it() -> None:
    state = after(FACTS, open_screen(), do.SetMu(0, 0.5 + 0.9))  # 0.7 sd is about 0.3
    state, works = update(FACTS, state, do.SetWindow("sd"))
    assert state.current.anchor.tolist() == [1.4, -0.3, 0.2]
    assert landscapes(works)[0].center.tolist() == [1.4, -0.3, 0.2]


def test_axes_along_which_the_puck_is_far_move_the_window_to_it() -> None:
    far = after(FACTS, open_screen(), do.SetMu(2, 3.0))  # across the plane: the window stays
    assert far.current.anchor.tolist() == MU[0].tolist()
    state, works = update(FACTS, far, do.SetLandscapeAxes((1, 2)))
    assert state.current.anchor.tolist() == far.current.latent.mu.tolist()
    assert landscapes(works)[0].center.tolist() == far.current.latent.mu.tolist()
    state = after(FACTS, open_screen(), do.SetLandscapeAxes("pca"), do.MoveOnMap((2,), (4.0,), 1))
    state = after(FACTS, state, do.SetMapAxes((0, 2)))
    np.testing.assert_array_equal(state.current.anchor, state.current.latent.mu)


def test_colours_and_joints_are_just_shown() -> None:
    state, works = update(FACTS, open_screen(), do.SetColouring("valence"))
    assert (state.colouring, works) == ("valence", ())
    state, works = update(FACTS, state, do.SetJoint("c"))
    assert (state.joint, works) == ("c", ())


def test_the_same_words_twice_are_two_notices() -> None:
    first = after(FACTS, open_screen(), do.RefuseTarget("no motion"))
    assert first.notice is not None
    second = after(FACTS, first, do.RefuseTarget("no motion"))
    assert second.notice is not None
    assert second.notice.text == first.notice.text
    assert second.notice != first.notice


def test_view_settings_are_no_steps_of_undo() -> None:
    state = after(FACTS, open_screen(), do.SetColouring("valence"), do.SetWindow("sd"), do.Seek(3))
    assert state.undo == ()


# --- results ---
def two_requests(intent: do.Intent) -> tuple[AppState, tuple[do.Work, ...], tuple[do.Work, ...]]:
    state, first = opening_work(FACTS, initial_state(FACTS))
    state, second = update(FACTS, state, intent)
    return state, first, second


def test_a_motion_is_shown_when_it_comes() -> None:
    state, works = opening_work(FACTS, initial_state(FACTS))
    assert state.current.motion is None
    state, more = update(FACTS, state, motion_result(motions(works)[0]))
    assert more == ()
    assert state.current.motion is not None
    assert state.current.motion.request == motions(works)[0].request
    assert state.current.motion.positions.shape == (12, 5)


def test_an_older_motion_never_replaces_a_newer_one() -> None:
    state, first, second = two_requests(do.SetMu(0, 0.9))
    state = after(FACTS, state, motion_result(motions(second)[0]))
    assert update(FACTS, state, motion_result(motions(first)[0])) == (state, ())


def test_an_older_motion_shows_while_the_newer_one_is_on_its_way() -> None:
    state, first, _ = two_requests(do.SetMu(0, 0.9))
    state = after(FACTS, state, motion_result(motions(first)[0]))
    assert state.current.motion is not None


def test_an_older_landscape_never_replaces_a_newer_one() -> None:
    state, first, second = two_requests(do.SetMu(2, 0.9))
    state = after(FACTS, state, landscape_result(landscapes(second)[0], complete=False))
    assert update(FACTS, state, landscape_result(landscapes(first)[0])) == (state, ())


def test_coarse_gives_way_to_complete_and_never_the_other_way_round() -> None:
    state, works = opening_work(FACTS, initial_state(FACTS))
    coarse = landscape_result(landscapes(works)[0], complete=False)
    complete = landscape_result(landscapes(works)[0])
    state = after(FACTS, state, coarse)
    assert state.current.landscape is coarse.landscape
    state = after(FACTS, state, complete)
    assert state.current.landscape is complete.landscape
    assert update(FACTS, state, coarse) == (state, ())


def test_a_newer_coarse_landscape_replaces_an_older_complete_one() -> None:
    state, first, second = two_requests(do.SetMu(2, 0.9))
    state = after(FACTS, state, landscape_result(landscapes(first)[0]))
    coarse = landscape_result(landscapes(second)[0], complete=False)
    assert after(FACTS, state, coarse).current.landscape is coarse.landscape


def test_every_request_has_a_number_of_its_own() -> None:
    facts = (make_facts(name="one"), make_facts(name="two"))
    state, works = opening_work(facts, initial_state(facts))
    for intent in (do.SetMu(2, 0.9), do.SelectMotion(2), do.Undo(), do.NewNoise()):
        state, more = update(facts, state, intent)
        works += more
    numbers = [work.request for work in works if not isinstance(work, do.CancelRecogniseWork)]
    assert len(set(numbers)) == len(numbers) > 8
    assert numbers == sorted(numbers)
