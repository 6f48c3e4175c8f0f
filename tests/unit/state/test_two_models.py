"""Models side by side: what they share, and of which one the boards speak."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from rnnpb_explorer.app.page.views import curves_shown, ways_shown
from rnnpb_explorer.app.page.words import smoothness_table
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import Document
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.opening import check_fits, opening_document
from rnnpb_explorer.app.state.results import MotionResult, StretchResult, WaysResult
from rnnpb_explorer.app.state.wanted import export_work, wanted
from rnnpb_explorer.app.state.work import MotionWork, StretchWork, WaysWork
from rnnpb_explorer.core import InputError
from rnnpb_explorer.core.walk import STEPS, Walk

from ..app_states import (
    MU,
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
    target_motion,
)

STRONG = make_facts(3, "strong")
WEAK = make_facts(2, "weak", ("bow", "jump", "wave"))  # knows two of them, in another order
LINE = make_facts(1, "line")
WIDE = make_facts(12, "wide")
PAIR = (STRONG, WEAK)


def names(document: Document, facts: Facts = PAIR) -> list[str]:
    return [f.motions[m.latent.motion] for f, m in zip(facts, document.models, strict=True)]


def test_both_open_with_the_same_motion() -> None:
    assert names(opening_document(PAIR)) == ["wave", "wave"]
    assert names(opening_document(PAIR, motion=1)) == ["bow", "bow"]
    # "nod" is one that the other has not learnt: it has one that it knows.
    assert names(opening_document(PAIR, motion=3)) == ["nod", "wave"]


def test_selecting_moves_both_where_both_know_the_motion() -> None:
    document = opened(PAIR, do.SelectMotion(1))
    assert names(document) == ["bow", "bow"]
    assert document.models[1].latent.mu == document.models[1].anchor == tuple(WEAK.mu[0])
    assert len(newly_wanted(PAIR, opened(PAIR), do.SelectMotion(1))) == 6


def test_selecting_moves_the_active_one_alone_where_the_other_does_not_know_it() -> None:
    assert names(opened(PAIR, do.SelectMotion(3))) == ["nod", "wave"]
    works = newly_wanted(PAIR, opened(PAIR), do.SelectMotion(3))
    assert {index for _, index in works} == {0}


def test_the_index_is_of_the_active_models_list() -> None:
    document = opened(PAIR, do.SelectModel(1), do.SelectMotion(1))
    assert names(document) == ["wave", "jump"]
    assert names(after(PAIR, document, do.SelectMotion(0))) == ["bow", "bow"]


@pytest.mark.parametrize(
    "intent",
    [
        do.SetMu(0, 0.7),
        do.SetSigma(0, 0.7),
        do.MoveOnMap(1, (0, 1), (0.1, 0.1), 1),
        do.MoveOnLandscape(1, ("μ1", "μ2"), (0.1, 0.1), 1),
        do.NewNoise(),
        do.RandomiseLatent(),
    ],
    ids=lambda intent: type(intent).__name__,
)
def test_a_hand_moves_the_active_model_alone(intent: do.LatentIntent) -> None:
    before = opened(PAIR, do.SelectModel(1))
    document = after(PAIR, before, intent)
    assert document.models[0] is before.models[0]
    assert document.models[1].latent != before.models[1].latent
    assert {index for _, index in newly_wanted(PAIR, before, intent)} <= {1}


@pytest.mark.parametrize("index", [-1, 0, 2, 99])
def test_a_model_that_there_is_not_and_the_active_one_change_nothing(index: int) -> None:
    assert opened(PAIR, do.SelectModel(index)) == opened(PAIR)


def test_undo_goes_back_to_the_model_before() -> None:
    page = Page(PAIR).do(do.SelectModel(1), do.SetMu(0, 0.1), do.Undo())
    assert page.document.active == 1
    assert page.do(do.Undo()).document.active == 0
    assert page.do(do.Redo()).document.active == 1


def test_the_axes_are_every_models() -> None:
    facts = (STRONG, make_facts(3, "other"))
    document = opened(facts, do.SelectModel(1), do.SetLandscapeAxes((1, 2)), do.SelectModel(0))
    for index in (0, 1):
        directions = landscape_of(wanted(facts, document), index).directions
        assert directions == ((0, 1, 0), (0, 0, 1))


def test_each_model_has_its_own_training_motion_to_compare_with() -> None:
    data = target_motion(frames=14)
    facts = (make_facts(name="one", data=(data, None, None, None)), make_facts(name="two"))
    works = wanted(facts, opened(facts))
    assert [motion_of(works, index).steps for index in (0, 1)] == [14, 12]
    assert {index for slot, index in works if slot == "reference"} == {1}


def test_the_target_is_every_models() -> None:
    target = make_target()
    works = newly_wanted(PAIR, opened(PAIR), do.SetTarget(target))
    assert [landscape_of(works, index).target for index in (0, 1)] == [target, target]
    assert [motion_of(works, index).steps for index in (0, 1)] == [10, 10]


# --- of different sizes ---
SIZES = pytest.mark.parametrize(
    "facts", [(STRONG, LINE), (LINE, STRONG), (LINE, WIDE), (WIDE, LINE), (WIDE, STRONG)]
)
EVERYTHING = (
    do.SelectMotion(2),
    do.SetMu(0, 0.1),
    do.SetWindow("sd"),
    do.SetLandscapeAxes("pca"),
    do.RandomiseLatent(),
    do.ShowSliders(8),
    do.SelectMotion(1),
    do.SetLandscapeAxes((0, 1)),
    do.SetLandscapeAxes((0,)),
    do.SetTarget(make_target()),
    do.StartRecognition(),
    do.CancelRecognition(),
    do.ClearTarget(),
    do.SetMapAxes((2, 5)),
    do.SetLandscapeAxes((3, 7)),
)


@SIZES
def test_models_of_different_sizes_live_side_by_side(facts: Facts) -> None:
    page = Page(facts)
    for turn in range(4):
        other = 1 - page.document.active
        ways = (do.SelectModel(other), do.Undo(), do.Redo(), *[do.Undo()] * (8 * turn))
        for intent in (*EVERYTHING, *ways):
            page.do(intent)
            check_fits(facts, page.document)
            for index, one in enumerate(facts):
                if ("landscape", index) not in page.wanted:
                    continue
                directions = np.array(landscape_of(page.wanted, index).directions)
                assert directions.shape == (min(one.pb_dim, 2), one.pb_dim)
                square = np.eye(len(directions))
                np.testing.assert_allclose(directions @ directions.T, square, atol=1e-8)


@SIZES
@pytest.mark.parametrize("active", [0, 1])
def test_a_touch_from_before_a_change_of_model_does_no_harm(facts: Facts, active: int) -> None:
    document = opened(facts, do.SelectModel(active))
    for touch in (
        do.MoveOnMap(1 - active, (0, 1), (0.1, 0.2), 1),
        do.MoveOnMap(1 - active, (0,), (0.1,), 1),
        do.MoveOnLandscape(1 - active, ("μ1",), (0.1,), 1),
        do.MoveOnLandscape(1 - active, ("μ1", "μ2"), (0.1, 0.2), 1),
    ):
        assert after(facts, document, touch) == document
    for touch in (
        do.MoveOnMap(active, (7, 11), (0.1, 0.2), 1),
        do.SetMu(11, 0.1),
        do.SetSigma(11, 0.1),
        do.SelectMotion(3),
    ):
        check_fits(facts, after(facts, document, touch))


# --- recognition ---
def recognising() -> Page:
    page = Page(PAIR).do(do.SelectModel(1), do.SetTarget(make_target()), do.StartRecognition())
    trace = make_trace(np.array([[[0.1, 0.1]], [[0.2, 0.2]], [[0.3, 0.3]]]))
    return page.deliver(RUN, trace, done=False)


def test_a_run_belongs_to_the_model_that_was_active() -> None:
    page = recognising()
    assert page.document.models[0] == opened(PAIR).models[0]
    assert page.document.models[1].latent.mu == (0.2, 0.2)
    assert ("landscape", 0) in page.wanted
    assert ("landscape", 1) not in page.wanted


def test_turning_to_the_other_model_stops_the_run_and_scrubbing_moves_its_own() -> None:
    page = recognising()
    assert page.picture.drawn_run is not None
    page.do(do.SelectModel(0))
    assert page.picture.run_status == "cancelled"
    assert page.picture.drawn_run is None  # the boards are the other model's
    before = page.document.models[0]
    page.do(do.ScrubRecognition(0, 0))
    assert page.document.models[0] == before
    assert page.document.models[1].latent.mu == (0.1, 0.1)


# --- one hand for all ---
ONE, TWO = make_facts(name="one"), make_facts(mu=10 * MU, name="two")
TOGETHER = (ONE, TWO)


def mus(document: Document) -> list[NDArray[np.float64]]:
    return [np.array(choice.latent.mu) for choice in document.models]


def moved(*intents: do.DocumentIntent, facts: Facts = TOGETHER) -> list[NDArray[np.float64]]:
    """How far each model's mu went."""
    before = opened(facts, *intents[:-1])
    after_it = after(facts, before, intents[-1])
    return [new - old for old, new in zip(mus(before), mus(after_it), strict=True)]


def test_a_hand_moves_the_active_model_alone_until_one_asks() -> None:
    one, two = moved(do.SetMu(0, 0.9))
    np.testing.assert_allclose(one, [0.4, 0, 0])
    np.testing.assert_array_equal(two, 0)


@pytest.mark.parametrize(("hand", "times"), [("absolute", 1.0), ("sd", 10.0)])
def test_a_slider_moves_all_by_the_same_amount(hand: str, times: float) -> None:
    one, two = moved(do.SetHand(hand), do.SetMu(1, 0.1))  # type: ignore[arg-type]
    np.testing.assert_allclose(one, [0, 0.4, 0])
    np.testing.assert_allclose(two, times * one)


@pytest.mark.parametrize(("hand", "times"), [("absolute", 1.0), ("sd", 10.0)])
def test_a_drag_on_a_map_moves_all_along_their_own_components(hand: str, times: float) -> None:
    x, y, _ = ONE.latent_map.project(ONE.mu[0])
    drag = do.MoveOnMap(0, (0, 1), (x + 0.3, y - 0.2), 1)
    one, two = moved(do.SetHand(hand), drag)  # type: ignore[arg-type]
    np.testing.assert_allclose(one @ ONE.latent_map.components.T, [0.3, -0.2, 0], atol=1e-9)
    along = two @ TWO.latent_map.components.T
    np.testing.assert_allclose(along, times * np.array([0.3, -0.2, 0]), atol=1e-9)


def test_each_goes_the_same_share_of_its_way() -> None:
    """The active one half-way from the selected motion to the goal."""
    hand = (do.SetHand("way"), do.SetGoal("rest"))
    half = (MU[0] + MU[2]) / 2
    document = opened(TOGETHER, *hand, *(do.SetMu(dim, half[dim]) for dim in range(3)))
    np.testing.assert_allclose(document.models[0].latent.mu, half)
    np.testing.assert_allclose(document.models[1].latent.mu, 10 * half)
    alone = opened(TOGETHER, do.SetHand("way"), do.SetMu(0, 0.9))  # to nowhere
    np.testing.assert_allclose(alone.models[1].latent.mu, 10 * MU[0])


def test_models_of_other_sizes_go_along_what_they_have() -> None:
    one, line = moved(do.SetHand("absolute"), do.SetMu(0, 0.9), facts=(STRONG, LINE))
    assert line.shape == (1,)
    np.testing.assert_allclose(line, one[:1])
    _, none = moved(do.SetHand("absolute"), do.SetMu(2, 0.9), facts=(STRONG, LINE))
    np.testing.assert_allclose(none, 0)


def test_one_drag_is_one_step_back_for_all() -> None:
    page = Page(TOGETHER).do(do.SetHand("absolute"))
    before = page.document
    for to in (0.1, 0.2, 0.3):
        page.do(do.MoveOnMap(0, (0, 1), (to, 0.0), 7))
    assert page.do(do.Undo()).document == before


def test_a_hand_or_goal_that_is_none() -> None:
    document = opened(TOGETHER)
    assert after(TOGETHER, document, do.SetGoal("nowhere")) == document
    assert after(TOGETHER, document, do.SetHand("both")) == document  # type: ignore[arg-type]


# --- side by side ---
THREE = (ONE, TWO, make_facts(2, "three"))


def test_two_models_boards_and_one_hand_for_both() -> None:
    document = opened(TOGETHER)
    assert document.on_boards == (0,)
    document = after(TOGETHER, document, do.SetCompare(True))
    assert (document.on_boards, document.hand) == ((0, 1), "absolute")
    kept = opened(TOGETHER, do.SetHand("sd"), do.SetCompare(True))
    assert kept.hand == "sd"
    assert after(TOGETHER, document, do.SetCompare(False)).on_boards == (0,)
    assert opened((ONE,), do.SetCompare(True)).on_boards == (0,)


def test_a_hand_on_the_other_board_makes_its_model_the_active_one_and_moves_both() -> None:
    document = opened(TOGETHER, do.SetCompare(True))
    x, y, _ = TWO.latent_map.project(TWO.mu[0])
    dragged = after(TOGETHER, document, do.MoveOnMap(1, (0, 1), (x + 0.5, y), 1))
    assert dragged.active == 1
    assert dragged.on_boards == (0, 1)  # each stays where it is
    one, two = (new - old for old, new in zip(mus(document), mus(dragged), strict=True))
    np.testing.assert_allclose(two, 0.5 * TWO.latent_map.components[0], atol=1e-9)
    np.testing.assert_allclose(one, 0.5 * ONE.latent_map.components[0], atol=1e-9)
    chosen = after(TOGETHER, document, do.SelectMotion(2, 1))
    assert (chosen.active, names(chosen, TOGETHER)) == (1, ["rest", "rest"])


def test_without_comparison_a_word_of_another_model_is_late_and_moves_nothing() -> None:
    document = opened(TOGETHER)
    assert after(TOGETHER, document, do.MoveOnMap(1, (0, 1), (0.5, 0.5), 1)) == document


def test_a_third_model_takes_the_place_of_the_active_one() -> None:
    document = opened(THREE, do.SetCompare(True), do.SelectModel(2))
    assert (document.active, document.on_boards) == (2, (2, 1))
    assert check_fits(THREE, document) is None
    from_three = opened(THREE, do.SelectModel(2), do.SetCompare(True))
    assert from_three.on_boards == (0, 2)


def test_a_picture_of_the_other_model_has_axes_that_it_has() -> None:
    page = Page((STRONG, LINE)).do(do.SetMapAxes((1, 2)), do.SetCompare(True))
    other = page.picture.of(1)
    assert (other.active, other.document.map_axes, other.document.landscape_axes) == (1, (0,), (0,))
    assert page.picture.of(0) is page.picture or page.picture.of(0).active == 0


@pytest.mark.parametrize("pair", [(0, 0), (0, 7)])
def test_a_code_of_two_models_that_are_not_here_is_refused(pair: tuple[int, int]) -> None:
    with pytest.raises(InputError, match="two models to compare"):
        check_fits(TOGETHER, replace(opened(TOGETHER), pair=pair))


# From "wave" to "rest" of the second model: twice as far as their distance, and 1.6 times as far as
# the shortest way, which goes aside.
WAY = np.linspace(TWO.mu[0], TWO.mu[2], STEPS + 1).round(6)
STRAIGHT = Walk(WAY, np.tile([0.05, 0.15], STEPS // 2), 2.0)
SHORTEST = Walk(WAY + 0.25, np.full(STEPS, 0.0625), 2.0)
FOUND = WaysResult(STRAIGHT, SHORTEST, sought=True)


def test_smoothness_is_wanted_of_both_where_they_are_compared() -> None:
    assert not {"stretch", "ways"} & {slot for slot, _ in wanted(TOGETHER, opened(TOGETHER))}
    document = opened(TOGETHER, do.SetCompare(True))
    works = wanted(TOGETHER, document)
    assert works["stretch", 1] == StretchWork("two", document.models[1].latent.mu)
    assert ("ways", 0) not in works
    works = wanted(TOGETHER, after(TOGETHER, document, do.SetGoal("rest")))
    assert works["ways", 1] == WaysWork("two", tuple(10 * MU[0]), tuple(10 * MU[2]))
    nowhere = after(TOGETHER, document, do.SetGoal("wave"))  # it is there already
    assert ("ways", 0) not in wanted(TOGETHER, nowhere)


def test_smoothness_side_by_side_in_numbers() -> None:
    page = Page(TOGETHER)
    assert smoothness_table(page.picture) == []
    page.do(do.SetCompare(True), do.SetGoal("rest"))
    page.deliver(("stretch", 1), StretchResult(38.0, 2.0))
    page.deliver(("ways", 1), WaysResult(STRAIGHT, STRAIGHT, sought=False), done=False)
    head, *rows = smoothness_table(page.picture)
    assert head == ["", "one", "two"]
    table = {name: cells for name, *cells in rows}
    assert table["stretch, °/unit of μ"] == ["…", "38.0"]
    assert table["stretch, °/sd of μ"] == ["…", f"{TWO.mu_sd * 38:.1f}"]
    assert table["wander"] == ["…", "2.0"]
    assert table["cliff"] == ["…", "1.5"]
    assert table["detour"] == ["…", "…"]
    page.deliver(("ways", 1), FOUND)
    assert smoothness_table(page.picture)[-2] == ["detour", "…", "1.60"]
    page.do(do.SetGoal("bow"))  # whose way is not measured yet
    assert smoothness_table(page.picture)[-2] == ["detour", "…", "…"]
    page.do(do.SetCompare(False))  # of the active model alone
    assert smoothness_table(page.picture)[0] == ["", "one"]


# --- two ways to walk ---
def test_all_models_stand_at_the_same_step() -> None:
    page = Page(TOGETHER).do(do.SetCompare(True), do.SetGoal("rest"), do.NewNoise(), do.WalkTo(10))
    for one, choice in zip(TOGETHER, page.document.models, strict=True):
        np.testing.assert_allclose(choice.latent.mu, one.mu[0] + (one.mu[2] - one.mu[0]) / 4)
        assert not any(choice.latent.epsilon)
    assert page.document.walk == 10


@pytest.mark.parametrize(
    "other", [do.SetMu(0, 0.3), do.SelectMotion(1), do.RandomiseLatent(), do.SetGoal("bow")]
)
def test_a_hand_ends_the_walk(other: do.DocumentIntent) -> None:
    page = Page(TOGETHER).do(do.SetCompare(True), do.SetGoal("rest"), do.WalkTo("morph"))
    assert page.do(do.SetJoint("a")).document.walk == "morph"
    assert page.do(other).document.walk is None
    assert page.do(do.Undo()).document.walk == "morph"


def test_there_is_nothing_to_walk_without_a_goal() -> None:
    assert Page(TOGETHER).do(do.WalkTo(3)).document.walk is None
    page = Page(TOGETHER).do(do.SetGoal("rest"))
    for step in (-1, STEPS + 1):
        assert page.do(do.WalkTo(step)).document.walk is None


def test_the_ghost_goes_the_shortest_way_while_the_robot_goes_straight() -> None:
    page = Page(TOGETHER).do(do.SetCompare(True), do.SetGoal("rest"), do.WalkTo(2))
    assert ("walk", 1) not in page.wanted  # before there is one
    page.deliver(("ways", 1), FOUND)
    work = page.wanted["walk", 1]
    assert isinstance(work, MotionWork)
    assert work.pb == tuple(FOUND.shortest.pbs[2])
    page.deliver(("walk", 1), MotionResult(np.ones((work.steps, 5), np.float32)))
    (ghost,) = page.picture.ghosts(1)
    assert ghost.shape == (work.steps, 5)
    assert page.picture.ghosts(0) == ()
    assert page.do(do.WalkTo(None)).picture.ghosts(1) == ()


def test_the_morph_is_one_motion_from_end_to_end() -> None:
    page = Page(TOGETHER).do(do.SetCompare(True), do.SetGoal("rest"), do.WalkTo("morph"))
    page.deliver(("ways", 1), FOUND)
    robot, ghost = page.wanted["motion", 1], page.wanted["walk", 1]
    assert isinstance(robot, MotionWork)
    assert isinstance(ghost, MotionWork)
    assert robot.along == (tuple(TWO.mu[0]), tuple(TWO.mu[2]))
    np.testing.assert_allclose(ghost.along, FOUND.shortest.pbs)
    assert robot.steps == ghost.steps == TWO.lengths[0] + TWO.lengths[2]
    assert export_work(TOGETHER, page.document).motion.along
    assert export_work(TOGETHER, page.document).name == "wave to rest one"
    shown = ways_shown(page.picture.of(1), 1)
    assert shown.shares is not None
    assert len(shown.shares) == robot.steps
    assert (shown.shares[0], shown.shares[-1]) == (0, 1)


def test_both_ways_and_their_steepest_step_are_shown() -> None:
    page = Page(TOGETHER).do(do.SetCompare(True), do.SetGoal("rest"), do.WalkTo(3))
    assert ways_shown(page.picture.of(1), 1).straight is None
    page.deliver(("ways", 1), FOUND)
    shown = ways_shown(page.picture.of(1), 1)
    assert shown.straight is not None
    assert shown.changes is not None
    np.testing.assert_allclose(
        shown.straight, TWO.latent_map.project(STRAIGHT.pbs)[:, list(page.document.map_axes)]
    )
    np.testing.assert_allclose(shown.changes, np.rad2deg(STRAIGHT.steps))
    assert (shown.steepest, shown.at, shown.shares) == (STRAIGHT.steepest, 3, None)


def test_the_curves_of_both_models_are_found_by_the_joints_names() -> None:
    turned = make_facts(2, "turned", joints=tuple(reversed(TWO.joints)), stochastic=False)
    page = Page((TWO, turned)).do(do.SetCompare(True), do.SetGhosts(True))
    shown = curves_shown(page.picture)
    assert shown.columns is not None
    assert shown.columns.tolist() == [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0]]
    assert shown.models == ("two", "turned (σ = 0, no band)")
