"""The ten novel patterns: what the authors' script does to a motion, from a seed."""

from __future__ import annotations

import numpy as np
import pytest

from rnnpb_explorer.core import Dataset, InputError, Motion
from rnnpb_explorer.core.paper.novel_patterns import SOURCES, novel_patterns

JOINTS = tuple("abcdefg")


def made_up(frames: int = 40) -> list[Motion]:
    random = np.random.default_rng(1)
    return [
        Motion(
            name,
            JOINTS,
            random.normal(size=(frames + i, len(JOINTS))).cumsum(axis=0).astype(np.float32) / 10,
        )
        for i, name in enumerate(reversed(SOURCES))  # their order must not matter
    ]


def test_each_is_scaled_shifted_and_bent_on_its_own_components() -> None:
    originals = {motion.name: motion for motion in made_up()}
    patterns = novel_patterns(list(originals.values()))
    assert [pattern.name for pattern in patterns] == [f"{name}_noisy" for name in SOURCES]
    found = []
    for pattern in patterns:
        original = originals[pattern.name.removesuffix("_noisy")].positions.astype(np.float64)
        mean = original.mean(axis=0)
        axes = np.linalg.svd(original - mean, full_matrices=False)[2][:5]
        before = (original - mean) @ axes.T
        after = (pattern.positions - mean) @ axes.T
        frames = len(original)
        assert pattern.positions.shape == original.shape
        np.testing.assert_allclose(after @ axes + mean, pattern.positions, atol=1e-5)
        wave = 0.1 * np.sin(2 * np.pi * 0.01 * frames * np.arange(frames) / (frames - 1))
        # after = scale * (before + sign * wave) + sign * shift: the sign of a component is free.
        scales, shifts = [], []
        for k in range(5):
            columns = np.stack([before[:, k], wave, np.ones(frames)], axis=1)
            (scale, height, shift), rest, *_ = np.linalg.lstsq(columns, after[:, k], rcond=None)
            assert rest < 1e-8
            assert abs(height) == pytest.approx(scale, abs=1e-3)
            scales.append(scale)
            shifts.append(shift * np.sign(height))
        np.testing.assert_allclose(scales, scales[0], atol=1e-4)
        np.testing.assert_allclose(shifts, shifts[0], atol=1e-4)
        assert 0.9 <= scales[0] <= 1.1
        assert -0.1 <= shifts[0] <= 0.1
        found.append((scales[0], shifts[0]))
    assert np.std(found, axis=0).min() > 0.01  # every pattern has its own


def test_the_seed_decides() -> None:
    motions = made_up()

    def values(seed: int) -> list[bytes]:
        return [pattern.positions.tobytes() for pattern in novel_patterns(motions, seed)]

    assert values(3) == values(3)
    assert all(one != other for one, other in zip(values(3), values(4), strict=True))


def test_a_missing_source() -> None:
    with pytest.raises(InputError, match=r"made from REBL-Pepper's motions; the data lack Angry_3"):
        novel_patterns(made_up()[:-1])


def test_of_the_real_data_they_are_new_but_alike(dataset: Dataset) -> None:
    originals = {motion.name: motion for motion in dataset.motions}
    for pattern in novel_patterns(dataset.motions):
        original = originals[pattern.name.removesuffix("_noisy")]
        error = float(np.square(pattern.positions - original.positions).mean())
        assert 1e-4 < error < 0.05
