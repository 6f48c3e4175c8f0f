"""The map of PBs: an exact change of basis for any number of motions and dimensions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.decomposition import PCA

from rnnpb_explorer.core.latent_map import Array, LatentMap, spread

cases = st.tuples(st.integers(1, 128), st.integers(1, 90), st.integers(0, 2**32 - 1))


def learned(dimensions: int, motions: int, seed: int) -> tuple[Array, np.random.Generator]:
    random = np.random.default_rng(seed)
    spread = random.uniform(0.01, 3, dimensions)
    mu = random.normal(random.normal(), spread, (motions, dimensions))
    return mu.astype(np.float32).astype(np.float64), random


@settings(max_examples=60, deadline=None)
@given(cases)
def test_project_and_unproject_are_inverse(case: tuple[int, int, int]) -> None:
    mu, random = learned(*case)
    latent_map = LatentMap.fit(mu)
    np.testing.assert_allclose(
        latent_map.components @ latent_map.components.T, np.eye(case[0]), atol=1e-12
    )
    np.testing.assert_allclose(latent_map.unproject(latent_map.points), mu, atol=1e-12)
    anywhere = random.normal(0, 5, (3, case[0]))
    there_and_back = latent_map.unproject(latent_map.project(anywhere))
    np.testing.assert_allclose(there_and_back, anywhere, atol=1e-12)


@settings(max_examples=60, deadline=None)
@given(cases, st.data())
def test_move_leaves_the_other_components_alone(
    case: tuple[int, int, int], data: st.DataObject
) -> None:
    mu, random = learned(*case)
    latent_map = LatentMap.fit(mu)
    count = data.draw(st.integers(1, min(2, case[0])))
    axes = data.draw(st.permutations(range(case[0])))[:count]
    start, to = random.normal(0, 2, case[0]), random.normal(0, 3, count)
    before, after = (
        latent_map.project(pb) for pb in (start, latent_map.move(start, axes, list(to)))
    )
    np.testing.assert_allclose(after[list(axes)], to, atol=1e-12)
    others = np.delete(np.arange(case[0]), axes)
    np.testing.assert_allclose(after[others], before[others], atol=1e-12)
    stay = latent_map.move(start, axes, list(before[list(axes)]))
    np.testing.assert_array_equal(stay, start)


def test_components_are_principal() -> None:
    mu, _ = learned(6, 40, 1)
    latent_map, reference = LatentMap.fit(mu), PCA().fit(mu)
    products = np.abs((latent_map.components * reference.components_).sum(axis=1))
    np.testing.assert_allclose(products, 1)
    np.testing.assert_allclose(latent_map.scale**2 * 40 / 39, reference.explained_variance_)


def test_the_sign_of_a_component_is_settled() -> None:
    mu, _ = learned(5, 30, 2)
    largest = np.abs(LatentMap.fit(mu).components).argmax(axis=1)
    assert (LatentMap.fit(mu).components[np.arange(5), largest] > 0).all()
    np.testing.assert_allclose(
        LatentMap.fit(mu).components, LatentMap.fit(2 * mu.mean(axis=0) - mu).components
    )


def test_spread_is_of_a_sample() -> None:
    """n - 1 in the denominator, the mean over dimensions; sqrt(2) and 2 sqrt(2) here."""
    assert spread([[0, 0], [2, 4]]) == pytest.approx(2.12132034)
    assert spread([[1, 0, 5], [3, 0, 8], [5, 0, 11]]) == pytest.approx(5 / 3)
    assert spread([[3.0, 1.0]]) == spread([[2.0], [2.0]]) == 1.0  # the prior's sigma


@pytest.fixture
def square() -> LatentMap:
    """Four PBs; the first axis carries most variance, the last none."""
    return LatentMap.fit([[2, 1, 5], [-2, 1, 5], [2, -1, 5], [-2, -1, 5]])


def test_off_plane(square: LatentMap) -> None:
    np.testing.assert_allclose(square.off_plane([0, 0, 5], (0, 1)), 0, atol=1e-15)
    np.testing.assert_allclose(square.off_plane([9, 9, 2], (0, 1)), 3)
    np.testing.assert_allclose(square.off_plane([0, 1, 9], (0, 2)), [0, 0, 2, 2], atol=1e-15)


def test_ellipse(square: LatentMap) -> None:
    np.testing.assert_allclose(square.ellipse([1, 2, 3], (0, 1)), [[1, 0], [0, 4]], atol=1e-15)
    turned = LatentMap.fit([[3, 3], [-3, -3], [1, -1], [-1, 1]])  # axes along the diagonals
    expected = np.cov(
        (np.random.default_rng(0).normal(0, [1, 2], (100_000, 2)) @ turned.components.T).T
    )
    np.testing.assert_allclose(turned.ellipse([1, 2], (0, 1)), expected, atol=0.05)
    assert abs(expected[0, 1]) > 1


def test_extrapolation(square: LatentMap) -> None:
    assert square.spacing == pytest.approx(2)
    assert square.extrapolation([2, 1, 5]) == pytest.approx(0)
    assert square.extrapolation([2, 0, 5]) == pytest.approx(0.5)
    assert square.extrapolation([2, 1, 9]) == pytest.approx(2)


@pytest.mark.parametrize("mu", [[[1.0, 2.0]], [[1.0, 2.0], [1.0, 2.0]]])
def test_without_neighbours_a_unit_is_the_prior_s_sigma(mu: list[list[float]]) -> None:
    assert LatentMap.fit(mu).extrapolation([1, 4]) == pytest.approx(2)
