"""What moves a model through its latent space: each intent's effect, its work, and undo."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import AppState, initial_state
from rnnpb_explorer.app.state.on_latent import MAX_MU, MAX_SIGMA
from rnnpb_explorer.app.state.slices import landscape_slice
from rnnpb_explorer.app.state.transitions import MAX_UNDO, Facts, opening_work
from rnnpb_explorer.app.state.update import update

from .app_states import (
    FACTS,
    LENGTHS,
    MU,
    ONE_DIMENSION,
    SIGMA,
    TWELVE_DIMENSIONS,
    after,
    landscapes,
    make_facts,
    motions,
    open_screen,
    target_motion,
    wanted,
)

MOTION, LANDSCAPE = (do.GenerateWork, 0), (do.LandscapeWork, 0)
ALL_SIZES = pytest.mark.parametrize(
    "facts", [ONE_DIMENSION, FACTS, TWELVE_DIMENSIONS], ids=["D1", "D3", "D12"]
)


def mu_of(state: AppState) -> list[float]:
    return [round(float(value), 12) for value in state.current.latent.mu]


# --- the opening screen ---
def test_opens_with_the_reconstruction_of_the_first_motion_playing() -> None:
    state, works = opening_work(FACTS, initial_state(FACTS))
    latent = state.current.latent
    assert latent.motion == 0
    assert latent.mu.tolist() == [0.5, -0.3, 0.2]
    assert latent.sigma.tolist() == [0.1, 0.2, 0.3]
    assert latent.epsilon.tolist() == [0.0, 0.0, 0.0]
    assert state.playback.playing
    (motion,), (landscape,) = motions(works), landscapes(works)
    assert motion.pb.tolist() == [0.5, -0.3, 0.2]
    assert motion.steps == 12
    assert motion.target is None
    assert motion.request == state.current.motion_request
    assert landscape.center.tolist() == [0.5, -0.3, 0.2]
    assert landscape.directions.tolist() == [[1, 0, 0], [0, 1, 0]]
    assert landscape.zero.tolist() == [0, 0, 0]
    assert landscape.radius == 1.0
    assert landscape.request == state.current.landscape_request != motion.request


def test_opens_with_another_motion_or_the_last_one_there_is() -> None:
    assert initial_state(FACTS, motion=2).current.latent.motion == 2
    assert initial_state(FACTS, motion=99).current.latent.motion == 3


@pytest.mark.parametrize(("facts", "axes"), [(ONE_DIMENSION, 1), (TWELVE_DIMENSIONS, 2)])
def test_the_boards_have_as_many_axes_as_the_model_allows(facts: Facts, axes: int) -> None:
    state, works = opening_work(facts, initial_state(facts))
    assert state.map_axes == state.landscape_axes == (0, 1)[:axes]
    assert landscapes(works)[0].directions.shape == (axes, facts[0].pb_dim)


def test_the_training_motion_is_the_target_where_the_app_has_it() -> None:
    data = target_motion(frames=14)
    facts = (make_facts(data=(data, None, None, None)),)
    _, works = opening_work(facts, initial_state(facts))
    assert motions(works)[0].target is data.positions
    assert motions(works)[0].steps == 14
    assert landscapes(works)[0].target is data.positions


# --- selecting ---
def test_selecting_a_motion_goes_to_what_was_learnt() -> None:
    state = after(FACTS, open_screen(), do.NewNoise(), do.SetSigma(0, 1.0))
    state, works = update(FACTS, state, do.SelectMotion(3))
    latent = state.current.latent
    assert latent.motion == 3
    assert latent.mu.tolist() == MU[3].tolist()
    assert latent.sigma.tolist() == SIGMA[3].tolist()
    assert not latent.epsilon.any()
    assert state.current.anchor.tolist() == MU[3].tolist()
    (motion,), (landscape,) = motions(works), landscapes(works)
    assert motion.steps == LENGTHS[3]
    assert motion.motion == landscape.motion == 3
    assert landscape.center.tolist() == MU[3].tolist()


@pytest.mark.parametrize("index", [-1, 4, 100])
def test_a_motion_that_there_is_not_changes_nothing(index: int) -> None:
    state = open_screen()
    assert update(FACTS, state, do.SelectMotion(index)) == (state, ())


# --- numbers ---
def test_mu_is_set_in_one_dimension() -> None:
    state, works = update(FACTS, open_screen(), do.SetMu(1, 0.25))
    assert mu_of(state) == [0.5, 0.25, 0.2]
    assert state.current.latent.sigma.tolist() == SIGMA[0].tolist()
    assert motions(works)[0].pb.tolist() == [0.5, 0.25, 0.2]


def test_a_new_state_leaves_the_old_one_as_it_was() -> None:
    state = open_screen()
    after(FACTS, state, do.SetMu(0, 0.9), do.SetSigma(0, 0.9), do.NewNoise())
    assert mu_of(state) == MU[0].tolist()
    assert state.current.latent.sigma.tolist() == SIGMA[0].tolist()
    assert not state.current.latent.epsilon.any()
    assert FACTS[0].mu.tolist() == MU.tolist()


@pytest.mark.parametrize(("asked", "got"), [(1e9, MAX_MU), (-1e9, -MAX_MU), (19.5, 19.5)])
def test_mu_stays_within_reason(asked: float, got: float) -> None:
    assert mu_of(after(FACTS, open_screen(), do.SetMu(2, asked)))[2] == got


@pytest.mark.parametrize(("asked", "got"), [(-1.0, 0.0), (99.0, MAX_SIGMA), (0.7, 0.7)])
def test_sigma_stays_within_reason(asked: float, got: float) -> None:
    state = after(FACTS, open_screen(), do.SetSigma(2, asked))
    assert state.current.latent.sigma.tolist() == [0.1, 0.2, got]


@pytest.mark.parametrize(
    "intent",
    [
        do.SetMu(0, math.nan),
        do.SetMu(0, math.inf),
        do.SetMu(3, 0.0),
        do.SetMu(-1, 0.0),
        do.SetSigma(0, math.nan),
        do.SetSigma(3, 0.0),
        do.SetSigma(-1, 0.0),
        do.MoveOnMap((0, 1), (math.nan, 0.0), 1),
        do.MoveOnMap((0, 3), (0.0, 0.0), 1),
        do.MoveOnMap((0, 1), (0.0,), 1),
        do.MoveOnMap((-1, 0), (0.0, 0.0), 1),
        do.MoveOnLandscape((0.0, math.inf), 1),
        do.MoveOnLandscape((0.0,), 1),
        do.MoveOnLandscape((0.0, 0.0, 0.0), 1),
    ],
    ids=str,
)
def test_what_does_not_fit_the_model_changes_nothing(intent: do.Intent) -> None:
    """A touch may be older than a change of model; NaN would never leave the screen again."""
    state = open_screen()
    assert update(FACTS, state, intent) == (state, ())


# --- noise ---
def test_noise_moves_the_pb_and_not_mu() -> None:
    state = open_screen()
    state, works = update(FACTS, state, do.NewNoise())
    latent = state.current.latent
    assert latent.epsilon.all()
    assert mu_of(state) == MU[0].tolist()
    np.testing.assert_array_equal(motions(works)[0].pb, MU[0] + SIGMA[0] * latent.epsilon)
    assert landscapes(works) == []  # the landscape is at sigma = 0 anyway


def test_the_noise_stays_while_sigma_moves() -> None:
    state = after(FACTS, open_screen(), do.NewNoise())
    epsilon = state.current.latent.epsilon
    state, works = update(FACTS, state, do.SetSigma(0, 0.8))
    assert state.current.latent.epsilon.tolist() == epsilon.tolist()
    assert motions(works)[0].pb[0] == MU[0, 0] + 0.8 * epsilon[0]
    assert landscapes(works) == []


def test_every_draw_is_another_and_a_seed_replays_them() -> None:
    def draws(seed: int) -> list[list[float]]:
        state = initial_state(FACTS, seed)
        seen = []
        for intent in (do.NewNoise(), do.NewNoise(), do.RandomiseLatent()):
            state = after(FACTS, state, intent)
            seen += [state.current.latent.epsilon.tolist(), mu_of(state)]
        return seen

    first = draws(seed=5)
    assert first == draws(seed=5) != draws(seed=6)
    assert first[0] != first[2]


def test_the_noise_goes_with_a_word() -> None:
    state = after(FACTS, open_screen(), do.NewNoise(), do.ClearNoise())
    assert not state.current.latent.epsilon.any()


def test_a_random_mu_lies_where_the_learned_ones_do() -> None:
    facts = TWELVE_DIMENSIONS
    drawn = []
    state = open_screen(facts)
    for _ in range(300):
        state = after(facts, state, do.RandomiseLatent())
        drawn.append(facts[0].latent_map.project(state.current.latent.mu))
    spread = np.std(drawn, axis=0)
    scale = facts[0].latent_map.scale
    np.testing.assert_allclose(spread, scale, atol=0.12 * scale.max())
    np.testing.assert_allclose(np.mean(drawn, axis=0), 0, atol=0.25 * scale.max())
    assert len(np.unique(drawn, axis=0)) == 300


@ALL_SIZES
def test_reset_goes_back_to_what_was_learnt(facts: Facts) -> None:
    moved = after(
        facts, open_screen(facts), do.SelectMotion(2), do.RandomiseLatent(), do.NewNoise()
    )
    latent = after(facts, moved, do.ResetLatent()).current.latent
    assert latent.motion == 2
    assert latent.mu.tolist() == facts[0].mu[2].tolist()
    assert latent.sigma.tolist() == facts[0].sigma[2].tolist()
    assert not latent.epsilon.any()


# --- the map ---
@ALL_SIZES
def test_a_drag_on_the_map_moves_the_drawn_components_alone(facts: Facts) -> None:
    state = open_screen(facts)
    axes = state.map_axes
    before = facts[0].latent_map.project(state.current.latent.mu)
    state = after(facts, state, do.MoveOnMap(axes, (0.3, -0.2)[: len(axes)], gesture=1))
    coordinates = facts[0].latent_map.project(state.current.latent.mu)
    np.testing.assert_allclose(coordinates[: len(axes)], [0.3, -0.2][: len(axes)], atol=1e-12)
    np.testing.assert_allclose(coordinates[len(axes) :], before[len(axes) :], atol=1e-12)


def test_the_hidden_components_move_by_the_same_intent() -> None:
    facts = TWELVE_DIMENSIONS
    state = open_screen(facts)
    before = facts[0].latent_map.project(state.current.latent.mu)
    state = after(facts, state, do.MoveOnMap((2, 3), (0.1, 0.2), gesture=1))
    coordinates = facts[0].latent_map.project(state.current.latent.mu)
    expected = before.copy()
    expected[[2, 3]] = 0.1, 0.2
    np.testing.assert_allclose(coordinates, expected, atol=1e-12)


# --- the landscape follows ---
def test_a_move_within_the_landscapes_plane_wants_a_motion_and_no_landscape() -> None:
    for intent in (do.SetMu(0, 0.9), do.SetMu(1, 0.1), do.MoveOnLandscape((0.7, 0.3), 1)):
        assert wanted(update(FACTS, open_screen(), intent)) == [MOTION]


def test_a_move_across_the_landscapes_plane_wants_both() -> None:
    result = update(FACTS, open_screen(), do.SetMu(2, 0.25))
    assert wanted(result) == [MOTION, LANDSCAPE]
    # The window stays where it was along its axes.
    assert landscapes(result[1])[0].center.tolist() == [0.5, -0.3, 0.25]


def test_the_window_stays_while_the_puck_moves_across_and_along() -> None:
    state = after(FACTS, open_screen(), do.SetMu(0, 0.9))
    _, works = update(FACTS, state, do.SetMu(2, 0.0))
    assert landscapes(works)[0].center.tolist() == [0.5, -0.3, 0.0]


def test_in_the_plane_of_the_map_a_drag_on_the_map_leaves_the_landscape() -> None:
    facts = TWELVE_DIMENSIONS
    state = after(facts, open_screen(facts), do.SetLandscapeAxes("pca"))
    where = landscape_slice(facts[0], state, state.current)
    inside = (where.middle[0] + 0.5, where.middle[1] - 0.9)
    assert wanted(update(facts, state, do.MoveOnMap((0, 1), inside, 1))) == [MOTION]
    across = update(facts, state, do.MoveOnMap((2, 3), (0.1, 0.2), 1))
    assert wanted(across) == [MOTION, LANDSCAPE]


def test_one_dimension_has_nothing_across() -> None:
    state = open_screen(ONE_DIMENSION)
    inside = float(state.current.anchor[0]) + 0.5
    assert wanted(update(ONE_DIMENSION, state, do.SetMu(0, inside))) == [MOTION]


@ALL_SIZES
def test_leaving_the_window_moves_it_to_the_puck(facts: Facts) -> None:
    state = open_screen(facts)
    out = float(state.current.anchor[0]) + 1.5
    state, works = update(facts, state, do.SetMu(0, out))
    assert state.current.anchor.tolist() == state.current.latent.mu.tolist()
    assert landscapes(works)[0].center.tolist() == state.current.latent.mu.tolist()


def test_the_rim_of_the_window_is_inside() -> None:
    assert wanted(update(FACTS, open_screen(), do.SetMu(0, 1.5))) == [MOTION]
    assert wanted(update(FACTS, open_screen(), do.SetMu(0, 1.501))) == [MOTION, LANDSCAPE]


def test_a_drag_on_the_landscape_stays_within_its_window() -> None:
    state = after(FACTS, open_screen(), do.MoveOnLandscape((9.0, -9.0), 1))
    assert mu_of(state) == [1.5, -1.3, 0.2]


def test_a_drag_on_the_landscape_uses_its_axes() -> None:
    state = after(FACTS, open_screen(), do.SetLandscapeAxes((2, 0)))
    assert mu_of(after(FACTS, state, do.MoveOnLandscape((0.9, 0.1), 1))) == [0.1, -0.3, 0.9]
    facts = TWELVE_DIMENSIONS
    state = after(facts, open_screen(facts), do.SetMapAxes((1, 3)), do.SetLandscapeAxes("pca"))
    where = landscape_slice(facts[0], state, state.current)
    to = (where.middle[0] + 0.5, where.middle[1] - 0.5)
    state = after(facts, state, do.MoveOnLandscape(to, 1))
    coordinates = facts[0].latent_map.project(state.current.latent.mu)
    np.testing.assert_allclose(coordinates[[1, 3]], to, atol=1e-12)


def test_a_reset_brings_the_window_back_with_it() -> None:
    """Within the plane, yet the window had gone with the puck."""
    state = after(FACTS, open_screen(), do.SetMu(0, 3.0))
    result = update(FACTS, state, do.ResetLatent())
    assert wanted(result) == [MOTION, LANDSCAPE]
    assert landscapes(result[1])[0].center.tolist() == MU[0].tolist()


def test_a_reset_of_what_is_reset_computes_no_landscape() -> None:
    assert wanted(update(FACTS, open_screen(), do.ResetLatent())) == [MOTION]


def test_the_relative_window_is_as_wide_as_the_learned_mu_spread() -> None:
    _, works = update(FACTS, open_screen(), do.SetWindow("sd"))
    assert landscapes(works)[0].radius == pytest.approx(0.7 * MU.std(axis=0, ddof=1).mean())


# --- undo ---
def test_undo_and_redo_walk_through_what_a_person_did() -> None:
    state = after(FACTS, open_screen(), do.SelectMotion(1), do.SetMu(0, 0.9), do.NewNoise())
    noise = state.current.latent.epsilon.tolist()
    state = after(FACTS, state, do.Undo())
    assert not state.current.latent.epsilon.any()
    assert mu_of(state) == [0.9, 0.6, -0.1]
    state = after(FACTS, state, do.Undo())
    assert mu_of(state) == MU[1].tolist()
    state = after(FACTS, state, do.Undo())
    assert (mu_of(state), state.current.latent.motion) == (MU[0].tolist(), 0)
    state = after(FACTS, state, do.Redo(), do.Redo(), do.Redo())
    assert mu_of(state) == [0.9, 0.6, -0.1]
    assert state.current.latent.epsilon.tolist() == noise


def test_undo_wants_the_motion_and_the_landscape_of_where_it_leads() -> None:
    state = after(FACTS, open_screen(), do.SetMu(2, 0.9))
    result = update(FACTS, state, do.Undo())
    assert wanted(result) == [MOTION, LANDSCAPE]
    assert motions(result[1])[0].pb.tolist() == MU[0].tolist()
    assert landscapes(result[1])[0].center.tolist() == MU[0].tolist()


def test_a_drag_is_one_step_back_however_far_it_went() -> None:
    state = open_screen()
    for x in (0.1, 0.2, 0.3, 0.4):
        state = after(FACTS, state, do.MoveOnMap((0, 1), (x, 0.0), gesture=7))
    assert mu_of(after(FACTS, state, do.Undo())) == MU[0].tolist()


def test_a_drag_that_rests_on_its_way_is_still_one() -> None:
    state = after(FACTS, open_screen(), do.MoveOnMap((0, 1), (0.1, 0.0), gesture=7))
    state = after(FACTS, state, do.Tick(5.0), do.MoveOnMap((0, 1), (0.2, 0.0), gesture=7))
    assert mu_of(after(FACTS, state, do.Undo())) == MU[0].tolist()


def test_two_drags_are_two_steps_back_even_on_two_boards() -> None:
    state = after(FACTS, open_screen(), do.MoveOnLandscape((0.6, 0.0), gesture=1))
    first = mu_of(state)
    state = after(FACTS, state, do.MoveOnLandscape((0.7, 0.0), gesture=2))
    assert mu_of(after(FACTS, state, do.Undo())) == first
    state = after(FACTS, state, do.MoveOnMap((0, 1), (0.0, 0.0), gesture=3), do.Undo())
    assert mu_of(state) == [0.7, 0.0, 0.2]


def test_a_slider_is_one_step_back_until_it_rests() -> None:
    state = after(FACTS, open_screen(), do.SetMu(0, 0.6), do.Tick(0.1), do.SetMu(0, 0.7))
    assert mu_of(after(FACTS, state, do.Undo())) == MU[0].tolist()
    state = after(FACTS, state, do.Tick(0.5), do.Tick(0.5), do.SetMu(0, 0.8))
    assert mu_of(after(FACTS, state, do.Undo())) == [0.7, -0.3, 0.2]


def test_ticks_while_a_slider_moves_do_not_add_up_to_a_rest() -> None:
    state = open_screen()
    for step in range(10):
        state = after(FACTS, state, do.SetMu(0, 0.1 * step), do.Tick(0.2))
    assert mu_of(after(FACTS, state, do.Undo())) == MU[0].tolist()


def test_two_sliders_are_two_steps_back() -> None:
    state = after(FACTS, open_screen(), do.SetMu(0, 0.6), do.SetMu(1, 0.6), do.Undo())
    assert mu_of(state) == [0.6, -0.3, 0.2]
    state = after(FACTS, open_screen(), do.SetMu(0, 0.6), do.SetSigma(0, 0.6), do.Undo())
    assert mu_of(state) == [0.6, -0.3, 0.2]
    assert state.current.latent.sigma.tolist() == SIGMA[0].tolist()


@pytest.mark.parametrize("intent", [do.NewNoise(), do.RandomiseLatent(), do.SelectMotion(2)])
def test_what_is_no_gesture_never_merges(intent: do.Intent) -> None:
    state = after(FACTS, open_screen(), intent)
    once = state.current.latent
    state = after(FACTS, state, intent, do.Undo())
    assert state.current.latent is once


def test_a_gesture_that_goes_on_after_undo_begins_anew() -> None:
    state = after(FACTS, open_screen(), do.SetMu(0, 0.6), do.Undo(), do.SetMu(0, 0.7), do.Undo())
    assert mu_of(state) == MU[0].tolist()


def test_a_new_move_forgets_what_was_undone() -> None:
    state = after(FACTS, open_screen(), do.SetMu(0, 0.6), do.Undo(), do.SetMu(1, 0.6))
    state = after(FACTS, state, do.Redo())
    assert mu_of(state) == [0.5, 0.6, 0.2]
    assert state.notice is not None


@pytest.mark.parametrize("intent", [do.Undo(), do.Redo()])
def test_nothing_to_undo_says_so_and_changes_nothing(intent: do.Intent) -> None:
    state = open_screen()
    said, works = update(FACTS, state, intent)
    assert works == ()
    assert said.models == state.models
    assert said.notice is not None
    assert said.notice.text.startswith("Nothing to")


def test_undo_goes_back_only_so_far() -> None:
    state = open_screen()
    for _ in range(MAX_UNDO + 20):
        state = after(FACTS, state, do.NewNoise())
    assert len(state.undo) == MAX_UNDO
