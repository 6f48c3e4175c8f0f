"""Models side by side: what they share, and of which one the boards speak."""

from __future__ import annotations

import numpy as np
import pytest

from rnnpb_explorer.app.page.panels.explore import ExplorePanel
from rnnpb_explorer.app.page.panels.readout import readout
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import AppState, initial_state
from rnnpb_explorer.app.state.slices import landscape_slice
from rnnpb_explorer.app.state.transitions import Facts, opening_work
from rnnpb_explorer.app.state.update import update

from .app_states import (
    after,
    landscapes,
    make_facts,
    make_trace,
    motions,
    open_screen,
    target_motion,
)

STRONG = make_facts(3, "strong")
WEAK = make_facts(2, "weak", ("bow", "jump", "wave"))  # knows two of them, in another order
LINE = make_facts(1, "line")
WIDE = make_facts(12, "wide")
PAIR = (STRONG, WEAK)


def names(facts: Facts, state: AppState) -> list[str]:
    return [f.motions[m.latent.motion] for f, m in zip(facts, state.models, strict=True)]


def test_both_open_with_the_same_motion() -> None:
    assert names(PAIR, initial_state(PAIR)) == ["wave", "wave"]
    assert names(PAIR, initial_state(PAIR, motion=1)) == ["bow", "bow"]


def test_a_motion_that_the_other_has_not_learnt_leaves_it_with_one_that_it_has() -> None:
    assert names(PAIR, initial_state(PAIR, motion=3)) in (["nod", n] for n in WEAK.motions)


def test_selecting_moves_both_where_both_know_the_motion() -> None:
    state, works = update(PAIR, open_screen(PAIR), do.SelectMotion(1))
    assert names(PAIR, state) == ["bow", "bow"]
    assert state.models[1].latent.mu.tolist() == WEAK.mu[0].tolist()
    assert [work.model for work in motions(works)] == [0, 1]
    assert [work.model for work in landscapes(works)] == [0, 1]
    assert [work.motion for work in motions(works)] == [1, 0]


def test_selecting_moves_the_active_one_alone_where_the_other_does_not_know_it() -> None:
    state, works = update(PAIR, open_screen(PAIR), do.SelectMotion(3))
    assert names(PAIR, state) == ["nod", "wave"]
    assert [work.model for work in motions(works)] == [0]


def test_the_index_is_of_the_active_models_list() -> None:
    state = after(PAIR, open_screen(PAIR), do.SelectModel(1), do.SelectMotion(1))
    assert names(PAIR, state) == ["wave", "jump"]
    assert names(PAIR, after(PAIR, state, do.SelectMotion(0))) == ["bow", "bow"]


def test_a_motion_chosen_by_name_is_the_active_models_one() -> None:
    import viser

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        sent: list[do.Intent] = []
        panel = ExplorePanel(server.gui, PAIR, sent.append)
        panel.show(after(PAIR, open_screen(PAIR), do.SelectModel(1)))
        panel._choose_motion("wave")
        assert sent == [do.SelectMotion(2)]
        panel.show(open_screen(PAIR))
        panel._choose_motion("wave")
        assert sent[1:] == [do.SelectMotion(0)]
    finally:
        server.stop()


@pytest.mark.parametrize(
    "intent",
    [
        do.SetMu(0, 0.7),
        do.SetSigma(0, 0.7),
        do.MoveOnMap((0, 1), (0.1, 0.1), 1),
        do.MoveOnLandscape((0.1, 0.1), 1),
        do.NewNoise(),
        do.RandomiseLatent(),
    ],
    ids=lambda intent: type(intent).__name__,
)
def test_a_hand_moves_the_active_model_alone(intent: do.Intent) -> None:
    before = after(PAIR, open_screen(PAIR), do.SelectModel(1))
    state, works = update(PAIR, before, intent)
    assert state.models[0] is before.models[0]
    assert state.models[1].latent is not before.models[1].latent
    assert {work.model for work in (*motions(works), *landscapes(works))} == {1}


def test_the_boards_speak_of_the_active_model() -> None:
    state = open_screen(PAIR)
    assert state.current is state.models[0]
    state = after(PAIR, state, do.SelectModel(1))
    assert state.current is state.models[1]
    assert landscape_slice(WEAK, state, state.current).center.tolist() == WEAK.mu[2].tolist()
    assert "target: wave (own reconstruction" in readout(WEAK, state)


@pytest.mark.parametrize("index", [-1, 0, 2, 99])
def test_a_model_that_there_is_not_and_the_active_one_change_nothing(index: int) -> None:
    state = open_screen(PAIR)
    assert update(PAIR, state, do.SelectModel(index)) == (state, ())


def test_undo_goes_back_to_the_model_before() -> None:
    state = after(PAIR, open_screen(PAIR), do.SelectModel(1), do.SetMu(0, 0.1), do.Undo())
    assert state.active == 1
    state = after(PAIR, state, do.Undo())
    assert state.active == 0
    assert after(PAIR, state, do.Redo()).active == 1


def test_each_model_has_results_of_its_own() -> None:
    state = open_screen(PAIR)
    first, second = state.models
    assert first.motion is not None
    assert second.motion is not None
    assert first.motion.request != second.motion.request
    assert first.landscape is not second.landscape


def test_the_landscape_of_a_model_that_was_away_is_of_the_axes_chosen_meanwhile() -> None:
    facts = (STRONG, make_facts(3, "other"))
    state = after(facts, open_screen(facts), do.SelectModel(1), do.SetLandscapeAxes((1, 2)))
    for intent in (do.SelectModel(0), do.Undo()):  # undo leaves the axes as they are
        back, works = update(facts, state, intent)
        assert back.active == 0
        (work,) = (work for work in landscapes(works) if work.model == 0)
        assert work.directions.tolist() == [[0, 1, 0], [0, 0, 1]]


# --- of different sizes ---
SIZES = pytest.mark.parametrize(
    "facts", [(STRONG, LINE), (LINE, STRONG), (LINE, WIDE), (WIDE, LINE), (WIDE, STRONG)]
)
EVERYTHING = (
    do.SelectMotion(2),
    do.SetMu(0, 0.1),
    do.SetWindow("sd"),
    do.SetLandscapeAxes("pca"),
    do.NewNoise(),
    do.RandomiseLatent(),
    do.SelectMotion(1),
    do.SetLandscapeAxes((0, 1)),
    do.SetLandscapeAxes((0,)),
    do.SetTarget(target_motion()),
    do.StartRecognition(),
    do.CancelRecognition(),
    do.ClearTarget(),
    do.SetMapAxes((2, 5)),
    do.SetLandscapeAxes((3, 7)),
)


@SIZES
def test_models_of_different_sizes_live_side_by_side(facts: Facts) -> None:
    state, works = opening_work(facts, initial_state(facts))
    for turn in range(4):
        for intent in (*EVERYTHING, do.SelectModel(1 - state.active), do.Undo(), do.Redo()):
            state, more = update(facts, state, intent)
            works += more
            assert_boards_can_be_drawn(facts, state)
        for _ in range(8 * turn):
            state, more = update(facts, state, do.Undo())
            works += more
            assert_boards_can_be_drawn(facts, state)
    for work in landscapes(works):
        dim = facts[work.model].pb_dim
        assert work.directions.shape == (min(dim, 2), dim)
        np.testing.assert_allclose(
            work.directions @ work.directions.T, np.eye(min(dim, 2)), atol=1e-9
        )


def assert_boards_can_be_drawn(facts: Facts, state: AppState) -> None:
    dim = facts[state.active].pb_dim
    assert len(state.map_axes) == min(dim, 2)
    assert max(state.map_axes) < dim
    if state.landscape_axes != "pca":
        assert len(state.landscape_axes) == min(dim, 2)
        assert max(state.landscape_axes) < dim


@SIZES
def test_a_touch_from_before_a_change_of_model_does_no_harm(facts: Facts) -> None:
    for active in (0, 1):
        state = after(facts, open_screen(facts), do.SelectModel(active))
        for touch in (
            do.MoveOnMap((0, 1), (0.1, 0.2), 1),
            do.MoveOnMap((0,), (0.1,), 1),
            do.MoveOnMap((7, 11), (0.1, 0.2), 1),
            do.MoveOnLandscape((0.1,), 1),
            do.MoveOnLandscape((0.1, 0.2), 1),
            do.SetMu(11, 0.1),
            do.SetSigma(11, 0.1),
            do.SelectMotion(3),
        ):
            moved = after(facts, state, touch)
            assert moved.current.latent.mu.shape == (facts[active].pb_dim,)
            assert_boards_can_be_drawn(facts, moved)


# --- recognition ---
def test_a_run_belongs_to_the_model_that_was_active() -> None:
    state = after(PAIR, open_screen(PAIR), do.SelectModel(1), do.SetTarget(target_motion()))
    state, works = update(PAIR, state, do.StartRecognition())
    (work,) = (work for work in works if isinstance(work, do.RecogniseWork))
    assert work.model == state.recognition.model == 1
    trace = make_trace(np.full((2, 1, 2), 0.25))
    before = state.models[0].latent
    state, works = update(PAIR, state, do.RecognitionStepped(work.request, trace))
    assert state.models[1].latent.mu.tolist() == [0.25, 0.25]
    assert state.models[0].latent is before
    assert [work.model for work in motions(works)] == [1]


def test_turning_to_the_other_model_stops_the_run_and_scrubbing_moves_its_own() -> None:
    state = after(PAIR, open_screen(PAIR), do.SelectModel(1), do.SetTarget(target_motion()))
    state = after(PAIR, state, do.StartRecognition())
    trace = make_trace(np.array([[[0.1, 0.1]], [[0.2, 0.2]], [[0.3, 0.3]]]))
    state = after(PAIR, state, do.RecognitionStepped(state.recognition.request, trace))
    state, works = update(PAIR, state, do.SelectModel(0))
    assert isinstance(works[0], do.CancelRecogniseWork)
    assert state.recognition.status == "cancelled"
    before = state.models[0].latent
    state = after(PAIR, state, do.ScrubRecognition(0, 0))
    assert state.models[0].latent is before
    assert state.models[1].latent.mu.tolist() == [0.1, 0.1]


def test_the_target_is_every_models() -> None:
    _, works = update(PAIR, open_screen(PAIR), do.SetTarget(target_motion()))
    assert len(motions(works)) == len(landscapes(works)) == 2
    assert all(work.target is not None for work in (*motions(works), *landscapes(works)))


def test_each_model_has_its_own_training_motion_as_target() -> None:
    data = target_motion(frames=14)
    facts = (make_facts(name="one", data=(data, None, None, None)), make_facts(name="two"))
    _, works = opening_work(facts, initial_state(facts))
    assert motions(works)[0].target is data.positions
    assert motions(works)[1].target is None
