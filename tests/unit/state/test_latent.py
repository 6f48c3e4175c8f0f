"""What moves a model through its latent space: each intent's effect, and the work it wants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec.structs import replace

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import MAX_COUNT, MAX_PB, Document
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.opening import opening_document
from rnnpb_explorer.app.state.planes import inside_window, landscape_plane
from rnnpb_explorer.app.state.wanted import wanted

from ..app_states import (
    FACTS,
    LANDSCAPE,
    LENGTHS,
    MOTION,
    MU,
    ONE_DIMENSION,
    REFERENCE,
    SIGMA,
    TWELVE_DIMENSIONS,
    after,
    landscape_of,
    make_facts,
    motion_of,
    newly_wanted,
    opened,
    target_motion,
)

ALL_SIZES = pytest.mark.parametrize(
    "facts", [ONE_DIMENSION, FACTS, TWELVE_DIMENSIONS], ids=["D1", "D3", "D12"]
)
LEARNED = (0.5, -0.3, 0.2)  # the mu of the first motion


def mu_of(document: Document) -> tuple[float, ...]:
    return tuple(round(value, 12) for value in document.current.latent.mu)


# --- the opening document ---
def test_opens_with_the_reconstruction_of_the_first_motion_playing() -> None:
    document = opened()
    latent = document.current.latent
    assert (latent.motion, latent.mu, latent.sigma) == (0, LEARNED, (0.1, 0.2, 0.3))
    assert latent.epsilon == (0.0, 0.0, 0.0)
    assert document.playback.playing
    works = wanted(FACTS, document)
    assert set(works) == {MOTION, REFERENCE, LANDSCAPE}
    assert (motion_of(works).pb, motion_of(works).steps) == (LEARNED, 12)
    landscape = landscape_of(works)
    assert (landscape.center, landscape.radius) == (LEARNED, 1.0)
    assert (landscape.target, landscape.motion) == (None, 0)
    assert landscape.directions == ((1, 0, 0), (0, 1, 0))
    assert landscape.zero == (0, 0, 0)


def test_opens_with_another_motion_or_the_last_one_there_is() -> None:
    assert opening_document(FACTS, motion=2).current.latent.motion == 2
    assert opening_document(FACTS, motion=99).current.latent.motion == 3


@pytest.mark.parametrize(("facts", "axes"), [(ONE_DIMENSION, 1), (TWELVE_DIMENSIONS, 2)])
def test_the_boards_have_as_many_axes_as_the_model_allows(facts: Facts, axes: int) -> None:
    document = opened(facts)
    assert document.map_axes == document.landscape_axes == (0, 1)[:axes]
    directions = np.array(landscape_of(wanted(facts, document)).directions)
    assert directions.shape == (axes, facts[0].pb_dim)


# --- selecting ---
def test_selecting_a_motion_goes_to_what_was_learnt() -> None:
    document = opened(FACTS, do.NewNoise(), do.SetSigma(0, 1.0), do.SelectMotion(3))
    latent = document.current.latent
    assert (latent.motion, latent.mu) == (3, tuple(MU[3]))
    assert latent.sigma == tuple(SIGMA[3])
    assert not any(latent.epsilon)
    assert document.current.anchor == tuple(MU[3])
    works = wanted(FACTS, document)
    assert motion_of(works).steps == LENGTHS[3]
    assert (landscape_of(works).motion, landscape_of(works).center) == (3, tuple(MU[3]))


def test_selecting_a_motion_within_the_window_takes_the_window_along() -> None:
    facts = (make_facts(3, mu=[MU[0], MU[0] + 0.1, MU[2], MU[3]]),)
    document = opened(facts, do.SelectMotion(1))
    assert document.current.anchor == document.current.latent.mu == tuple(MU[0] + 0.1)


@ALL_SIZES
def test_reset_goes_back_to_what_was_learnt(facts: Facts) -> None:
    moved = opened(facts, do.SelectMotion(2), do.RandomiseLatent(), do.NewNoise())
    assert after(facts, moved, do.ResetLatent()).models == opened(facts, do.SelectMotion(2)).models


# --- numbers ---
def test_mu_is_set_in_one_dimension() -> None:
    document = opened(FACTS, do.SetMu(1, 0.25))
    assert mu_of(document) == (0.5, 0.25, 0.2)
    assert document.current.latent.sigma == tuple(SIGMA[0])
    assert motion_of(wanted(FACTS, document)).pb == (0.5, 0.25, 0.2)


@pytest.mark.parametrize(("asked", "got"), [(1e9, 1e6), (-1e9, -1e6), (19.5, 19.5), (400, 400)])
def test_mu_stays_within_the_bounds(asked: float, got: float) -> None:
    assert MAX_PB == 1e6
    assert mu_of(opened(FACTS, do.SetMu(2, asked)))[2] == got


@pytest.mark.parametrize(("asked", "got"), [(-1.0, 0.0), (1e9, 1e6), (0.7, 0.7), (99.0, 99.0)])
def test_sigma_stays_within_the_bounds(asked: float, got: float) -> None:
    assert opened(FACTS, do.SetSigma(2, asked)).current.latent.sigma == (0.1, 0.2, got)


def test_moving_sigma_leaves_a_mu_that_is_far_out_alone() -> None:
    """A checkpoint may have learnt |mu| > 20."""
    facts = (make_facts(3, mu=[[25.0, -40.0, 0.0], *MU[1:]]),)
    document = opened(facts, do.SetSigma(0, 0.5), do.SetSigma(1, 7.0), do.NewNoise())
    assert document.current.latent.mu == (25.0, -40.0, 0.0)
    assert document.current.latent.sigma == (0.5, 7.0, 0.3)


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
        do.SelectMotion(-1),
        do.SelectMotion(4),
        do.MoveOnMap(0, (0, 1), (math.nan, 0.0), 1),
        do.MoveOnMap(0, (0, 3), (0.0, 0.0), 1),
        do.MoveOnMap(0, (0, 1), (0.0,), 1),
        do.MoveOnMap(0, (-1, 0), (0.0, 0.0), 1),
        do.MoveOnMap(1, (0, 1), (0.0, 0.0), 1),
        do.MoveOnLandscape(0, ("μ1", "μ2"), (0.0, math.inf), 1),
        do.MoveOnLandscape(0, ("μ1", "μ2"), (0.0,), 1),
        do.MoveOnLandscape(0, ("μ1", "μ2"), (0.0, 0.0, 0.0), 1),
        do.MoveOnLandscape(1, ("μ1", "μ2"), (0.0, 0.0), 1),
    ],
    ids=str,
)
def test_what_does_not_fit_the_model_changes_nothing(intent: do.LatentIntent) -> None:
    """A touch may be older than a change of model; NaN would never leave the screen again."""
    assert opened(FACTS, intent) == opened()


# --- noise ---
def test_noise_moves_the_pb_and_not_mu() -> None:
    document = opened(FACTS, do.NewNoise())
    epsilon = document.current.latent.epsilon
    assert all(epsilon)
    assert mu_of(document) == LEARNED
    works = newly_wanted(FACTS, opened(), do.NewNoise())
    assert set(works) == {MOTION}  # the landscape is at sigma = 0 anyway
    np.testing.assert_allclose(motion_of(works).pb, MU[0] + SIGMA[0] * epsilon, atol=1e-15)


def test_the_noise_stays_while_sigma_moves() -> None:
    noisy = opened(FACTS, do.NewNoise())
    document = after(FACTS, noisy, do.SetSigma(0, 0.8))
    epsilon = noisy.current.latent.epsilon
    assert document.current.latent.epsilon == epsilon
    assert set(newly_wanted(FACTS, noisy, do.SetSigma(0, 0.8))) == {MOTION}
    assert motion_of(wanted(FACTS, document)).pb[0] == 0.5 + 0.8 * epsilon[0]


def test_every_draw_is_another_and_a_seed_replays_them() -> None:
    def draws(seed: int) -> list[tuple[float, ...]]:
        document, seen = opening_document(FACTS, seed), []
        for intent in (do.NewNoise(), do.NewNoise(), do.RandomiseLatent()):
            document = after(FACTS, document, intent)
            seen += [document.current.latent.epsilon, mu_of(document)]
        return seen

    first = draws(seed=5)
    assert first == draws(seed=5) != draws(seed=6)
    assert first[0] != first[2]


def test_the_last_draw_that_can_be_counted_is_followed_by_the_first() -> None:
    last = replace(opened(), draws=MAX_COUNT)
    assert after(FACTS, last, do.NewNoise()).draws == 0


def test_the_noise_goes_with_a_word() -> None:
    assert not any(opened(FACTS, do.NewNoise(), do.ClearNoise()).current.latent.epsilon)


def test_a_random_mu_lies_where_the_learned_ones_do() -> None:
    facts, drawn = TWELVE_DIMENSIONS, []
    document = opened(facts)
    for _ in range(300):
        document = after(facts, document, do.RandomiseLatent())
        drawn.append(facts[0].latent_map.project(document.current.latent.mu))
    scale = facts[0].latent_map.scale
    np.testing.assert_allclose(np.std(drawn, axis=0), scale, atol=0.12 * scale.max())
    np.testing.assert_allclose(np.mean(drawn, axis=0), 0, atol=0.25 * scale.max())
    assert len(np.unique(drawn, axis=0)) == 300


# --- the map ---
@ALL_SIZES
@pytest.mark.parametrize("axes", [(0, 1), (2, 3)], ids=["drawn", "hidden"])
def test_a_drag_on_the_map_moves_its_components_alone(facts: Facts, axes: tuple[int, ...]) -> None:
    axes = tuple(axis for axis in axes if axis < facts[0].pb_dim)
    if not axes:
        return
    document, to = opened(facts), (0.3, -0.2)[: len(axes)]
    expected = facts[0].latent_map.project(document.current.latent.mu)
    expected[list(axes)] = to
    moved = after(facts, document, do.MoveOnMap(0, axes, to, gesture=1))
    coordinates = facts[0].latent_map.project(moved.current.latent.mu)
    np.testing.assert_allclose(coordinates, expected, atol=1e-12)


# --- the landscape follows ---
@pytest.mark.parametrize(
    "intent",
    [do.SetMu(0, 0.9), do.SetMu(1, 0.1), do.MoveOnLandscape(0, ("μ1", "μ2"), (0.7, 0.3), 1)],
    ids=str,
)
def test_a_move_within_the_landscapes_plane_wants_no_landscape(intent: do.LatentIntent) -> None:
    assert set(newly_wanted(FACTS, opened(), intent)) == {MOTION}


def test_a_move_across_the_landscapes_plane_wants_one_and_the_window_stays() -> None:
    for before in (opened(), opened(FACTS, do.SetMu(0, 0.9))):
        works = newly_wanted(FACTS, before, do.SetMu(2, 0.25))
        assert set(works) == {MOTION, LANDSCAPE}
        assert landscape_of(works).center == (0.5, -0.3, 0.25)


def test_in_the_plane_of_the_map_a_drag_on_the_map_leaves_the_landscape() -> None:
    facts = TWELVE_DIMENSIONS
    document = opened(facts, do.SetLandscapeAxes("pca"))
    middle = landscape_plane(facts[0], document, document.current).middle
    inside = do.MoveOnMap(0, (0, 1), (middle[0] + 0.5, middle[1] - 0.9), 1)
    assert set(newly_wanted(facts, document, inside)) == {MOTION}
    across = do.MoveOnMap(0, (2, 3), (0.1, 0.2), 1)
    assert set(newly_wanted(facts, document, across)) == {MOTION, LANDSCAPE}


def test_one_dimension_has_nothing_across() -> None:
    document = opened(ONE_DIMENSION)
    inside = do.SetMu(0, document.current.anchor[0] + 0.5)
    assert set(newly_wanted(ONE_DIMENSION, document, inside)) == {MOTION}


@ALL_SIZES
def test_leaving_the_window_moves_it_to_the_puck(facts: Facts) -> None:
    document = opened(facts)
    document = after(facts, document, do.SetMu(0, document.current.anchor[0] + 1.5))
    assert document.current.anchor == document.current.latent.mu
    np.testing.assert_allclose(
        landscape_of(wanted(facts, document)).center, document.current.latent.mu, atol=1e-9
    )


def test_the_rim_of_the_window_is_inside() -> None:
    """The window goes from -0.5 to 1.5 along the first axis, from -1.3 to 0.7 along the second."""
    for dim, value, inside in ((0, 1.5, True), (0, -0.5, True), (1, 0.7, True), (1, -1.3, True)):
        assert (opened(FACTS, do.SetMu(dim, value)).current.anchor == LEARNED) is inside
        beyond = value + math.copysign(1e-6, value)
        assert opened(FACTS, do.SetMu(dim, beyond)).current.anchor != LEARNED


def test_inside_is_along_the_drawn_axes_alone() -> None:
    def inside(*mu: float) -> bool:
        document = opened()
        latent = replace(document.current.latent, mu=mu)
        return inside_window(FACTS[0], document, replace(document.current, latent=latent))

    assert inside(0.5, -0.3, 0.2)
    assert inside(1.4, 0.6, 900.0)  # the third is not drawn
    assert inside(1.5 + 4e-10, -0.3, 0.2)  # rounding of a drag along the rim
    assert not inside(1.5 + 4e-9, -0.3, 0.2)
    assert not inside(0.5, 0.71, 0.2)


def test_a_drag_on_the_landscape_stays_within_its_window() -> None:
    document = opened(FACTS, do.MoveOnLandscape(0, ("μ1", "μ2"), (9.0, -9.0), 1))
    assert mu_of(document) == (1.5, -1.3, 0.2)
    assert document.current.anchor == LEARNED


def test_a_drag_on_the_landscape_uses_its_axes() -> None:
    document = opened(
        FACTS, do.SetLandscapeAxes((2, 0)), do.MoveOnLandscape(0, ("μ3", "μ1"), (0.9, 0.1), 1)
    )
    assert mu_of(document) == (0.1, -0.3, 0.9)
    facts = TWELVE_DIMENSIONS
    document = opened(facts, do.SetMapAxes((1, 3)), do.SetLandscapeAxes("pca"))
    middle = landscape_plane(facts[0], document, document.current).middle
    to = (middle[0] + 0.5, middle[1] - 0.5)
    document = after(facts, document, do.MoveOnLandscape(0, ("PC2", "PC4"), to, 1))
    coordinates = facts[0].latent_map.project(document.current.latent.mu)
    np.testing.assert_allclose(coordinates[[1, 3]], to, atol=1e-12)


def test_a_touch_on_a_landscape_of_other_axes_moves_nothing() -> None:
    """The drawing with the axes of before stands until the next one is there."""
    document = opened(FACTS, do.SetLandscapeAxes((2, 0)))
    for labels in (("μ1", "μ2"), ("μ1", "μ3"), ("PC1", "PC2"), ("μ3",)):
        touch = do.MoveOnLandscape(0, labels, (0.4, 0.1), 1)
        assert after(FACTS, document, touch) == document
    touch = do.MoveOnLandscape(0, ("μ3", "μ1"), (0.4, 0.1), 1)
    assert mu_of(after(FACTS, document, touch)) == (0.1, -0.3, 0.4)


def test_a_reset_brings_the_window_back_with_it() -> None:
    works = newly_wanted(FACTS, opened(FACTS, do.SetMu(0, 3.0)), do.ResetLatent())
    assert set(works) == {MOTION, LANDSCAPE}
    assert landscape_of(works).center == LEARNED


def test_a_reset_of_what_is_reset_computes_nothing() -> None:
    assert newly_wanted(FACTS, opened(), do.ResetLatent()) == {}


def test_the_relative_window_is_as_wide_as_the_learned_mu_spread() -> None:
    landscape = landscape_of(wanted(FACTS, opened(FACTS, do.SetWindow("sd"))))
    assert landscape.radius == pytest.approx(0.7 * MU.std(axis=0, ddof=1).mean())


def test_the_training_motion_is_compared_with_where_the_app_has_it() -> None:
    data = target_motion(frames=14)
    facts = (make_facts(data=(data, None, None, None)),)
    works = wanted(facts, opened(facts))
    assert set(works) == {MOTION, LANDSCAPE}  # no reconstruction stands in
    assert motion_of(works).steps == 14
    assert set(wanted(facts, opened(facts, do.SelectMotion(1)))) == {MOTION, REFERENCE, LANDSCAPE}
