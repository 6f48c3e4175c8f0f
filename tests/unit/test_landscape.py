"""The correlation landscape: the published figures, Pearson by scipy, stages, cancellation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats
import torch
from numpy.typing import NDArray

from rnnpb_explorer.core.correlation import landscape, landscape_stages, pearson
from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.errors import Cancelled, InputError
from rnnpb_explorer.core.latent_map import LatentMap
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.windows import Landscape, plane, unit_directions

Array = NDArray[np.float32]


def scipy_pearson(generated: Array, target: Array) -> float:
    """Mean over joints; those that are constant on either side left out."""
    moving = [
        j
        for j in range(target.shape[1])
        if np.ptp(generated[:, j]) > 0 and np.ptp(target[:, j]) > 0
    ]
    return float(
        np.mean([scipy.stats.pearsonr(generated[:, j], target[:, j]).statistic for j in moving])
    )


@pytest.fixture
def target(tiny_model: RNNPB) -> Array:
    motion = tiny_model.reconstruct(0, 25).numpy().copy()
    motion[:, 2] = 0.1  # a joint that does not move
    return motion


# Averages over every third motion by name, as measured with the authors' own code.
@pytest.mark.parametrize(
    ("name", "radius_in_sd", "expected"),
    [
        ("published_strong", None, "0.746 0.669 0.0308"),
        ("published_zero", 0.7, "0.688 0.481 0.0437"),
    ],
)
def test_published_landscapes(
    name: str,
    radius_in_sd: float | None,
    expected: str,
    dataset: Dataset,
    request: pytest.FixtureRequest,
) -> None:
    model: RNNPB = request.getfixturevalue(name)
    sd = model.mu.std(dim=0).mean().item()
    radius = 1.0 if radius_in_sd is None else radius_in_sd * sd
    pictures = [
        landscape(model, dataset.motions[i].positions, model.mu[i].numpy(), radius=radius)
        for i in range(0, 72, 3)
    ]
    mean, area, roughness = np.mean([(p.mean, p.area, p.roughness) for p in pictures], axis=0)
    assert f"{mean:.3f} {area:.3f} {roughness:.4f}" == expected


@pytest.mark.parametrize(("index", "still"), [(40, 0), (64, 1)])
def test_cells_by_scipy(published_strong: RNNPB, dataset: Dataset, index: int, still: int) -> None:
    motion, mu = dataset.motions[index].positions[:120], published_strong.mu[index].numpy()
    picture = landscape(published_strong, motion, mu, axes=(2, 1))
    assert (np.ptp(motion, axis=0) == 0).sum() == still  # joints that do not move
    for row, column in np.random.default_rng(index).integers(0, 20, (8, 2)):
        pb = torch.as_tensor(mu).clone()
        pb[2], pb[1] = picture.x[column], picture.y[row]
        generated = published_strong.generate_stepwise(pb, len(motion)).numpy()
        assert picture.correlation[row, column] == pytest.approx(
            scipy_pearson(generated, motion), abs=1e-5
        )


def test_pearson_leaves_constant_joints_out() -> None:
    time = torch.linspace(0, 1, 30)
    target = torch.stack([time, time**2, torch.full_like(time, 0.1)], dim=1)
    generated = torch.stack([3 * time - 1, torch.full_like(time, 0.7), time.cos()], dim=1)
    still = torch.full_like(target, 0.3)
    values = pearson(torch.stack([generated, -target, still]), target)
    np.testing.assert_allclose(values, [1, -1, 0], atol=1e-12)


def test_every_cell_is_where_it_says(tiny_model: RNNPB, target: Array) -> None:
    center = tiny_model.mu[1].numpy()
    picture = landscape(tiny_model, target, center, axes=(2, 0), radius=1.5, grid=7)
    assert picture.correlation.shape == (7, 7)
    assert picture.correlation.dtype == np.float32
    np.testing.assert_allclose(picture.x, center[2] + np.linspace(-1.5, 1.5, 7))
    np.testing.assert_allclose(picture.y, center[0] + np.linspace(-1.5, 1.5, 7))
    for row in range(7):
        for column in range(7):
            pb = torch.tensor([picture.y[row], center[1], picture.x[column]]).float()
            generated = tiny_model.generate_stepwise(pb, len(target)).numpy()
            assert picture.correlation[row, column] == pytest.approx(
                scipy_pearson(generated, target), abs=1e-5
            )


def test_along_principal_components(tiny_model: RNNPB, target: Array) -> None:
    latent_map = LatentMap.fit(tiny_model.mu)
    center = tiny_model.mu[2].numpy()
    directions, origin = latent_map.components[:2], latent_map.mean
    pbs, x, y = plane(center, directions, 0.8, 5, origin=origin)
    at = latent_map.project(center)
    np.testing.assert_allclose(x, at[0] + np.linspace(-0.8, 0.8, 5))
    for row in range(5):
        for column in range(5):
            expected = latent_map.move(center, (0, 1), (x[column], y[row]))
            np.testing.assert_allclose(pbs[row, column], expected, atol=1e-12)
    picture = landscape(
        tiny_model, target, center, directions=directions, radius=0.8, grid=5, origin=origin
    )
    np.testing.assert_array_equal(picture.y, y)
    cell = tiny_model.generate(torch.as_tensor(pbs[1, 4:5]).float(), 25)
    expected = pearson(cell, torch.as_tensor(target))
    assert picture.correlation[1, 4] == pytest.approx(expected.item(), abs=1e-6)


def test_a_coarse_stage_comes_first(tiny_model: RNNPB, target: Array) -> None:
    center = tiny_model.mu[0].numpy()
    coarse, complete = landscape_stages(tiny_model, target, center)
    assert (coarse.complete, complete.complete) == (False, True)
    assert coarse.correlation.shape == complete.correlation.shape == (20, 20)
    whole = landscape(tiny_model, target, center)
    np.testing.assert_allclose(complete.correlation, whole.correlation, atol=1e-6)
    same = coarse.correlation == complete.correlation
    assert 30 <= len(np.unique(coarse.correlation)) <= 60
    assert same[[0, 0, -1, -1], [0, -1, 0, -1]].all()  # the corners were computed
    # every other cell is filled with one that lies at most two cells away
    near = np.lib.stride_tricks.sliding_window_view(
        np.pad(complete.correlation, 2, mode="edge"), (5, 5)
    ).reshape(20, 20, 25)
    assert (near == coarse.correlation[..., None]).any(axis=2).all()


def test_the_complete_stage_reuses_the_coarse_one(
    tiny_model: RNNPB, target: Array, monkeypatch: pytest.MonkeyPatch
) -> None:
    generated = []
    plain = RNNPB.generate

    def counted(model: RNNPB, pb: torch.Tensor, steps: int) -> torch.Tensor:
        generated.append(len(pb))
        return plain(model, pb, steps)

    monkeypatch.setattr(RNNPB, "generate", counted)
    list(landscape_stages(tiny_model, target, tiny_model.mu[0].numpy()))
    assert sum(generated) == 400
    assert generated[0] <= 60


def test_a_small_grid_has_one_stage(tiny_model: RNNPB, target: Array) -> None:
    (only,) = landscape_stages(tiny_model, target, tiny_model.mu[0].numpy(), grid=4)
    assert only.complete


def test_cancelled_between_chunks(published_strong: RNNPB) -> None:
    asked = []

    def third_time() -> bool:
        asked.append(True)
        return len(asked) == 3

    long = np.random.default_rng(0).normal(0, 1, (600, 17))
    stages = landscape_stages(published_strong, long, np.zeros(4), cancelled=third_time)
    with pytest.raises(Cancelled):
        list(stages)
    assert len(asked) == 3
    with pytest.raises(Cancelled):
        landscape(published_strong, long, np.zeros(4), cancelled=lambda: True)


def test_one_dimension_has_one_row(target: Array, tiny_model: RNNPB) -> None:
    model = RNNPB(replace(tiny_model.config, pb_dim=1), tiny_model.info).requires_grad_(False)
    coarse, complete = landscape_stages(model, target, [0.5])
    assert coarse.correlation.shape == complete.correlation.shape == (1, 20)
    np.testing.assert_allclose(complete.x, 0.5 + np.linspace(-1, 1, 20))
    assert complete.y.tolist() == [0]
    assert complete.roughness == pytest.approx(np.abs(np.diff(complete.correlation)).mean())


def test_the_three_numbers() -> None:
    values = np.array([[1.0, 0.92, 0.0], [0.5, 0.91, -0.5]], dtype=np.float32)
    picture = Landscape(values, np.arange(3.0), np.arange(2.0))
    assert picture.mean == pytest.approx(values.mean())
    assert picture.area == pytest.approx(3 / 6)
    differences = [0.08, 0.92, 0.41, 1.41, 0.5, 0.01, 0.5]
    assert picture.roughness == pytest.approx(np.mean(differences))


@pytest.mark.parametrize("axes", [(0, 3), (1, 1), (-1, 0), (2,)])
def test_axes_that_are_none(axes: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="two different axes from 0 to 2"):
        unit_directions(3, axes)


def test_targets_that_do_not_fit(tiny_model: RNNPB, target: Array) -> None:
    with pytest.raises(InputError, match=r"shape \(25, 4\).*\(frames, 5\)"):
        landscape(tiny_model, target[:, :4], np.zeros(3))
    with pytest.raises(InputError, match="at least 2 cells"):
        landscape(tiny_model, target, np.zeros(3), grid=1)
