"""Codebooks: what is in them, that they are used while they grow, and that the cache keeps them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.core import RNNPB, codebook
from rnnpb_explorer.core.codebook import (
    APART,
    BATCH,
    FRAMES,
    STRIDE,
    Codebook,
    codebook_pbs,
    complete_codebook,
    size_for,
)
from rnnpb_explorer.core.files import CACHE_VARIABLE
from rnnpb_explorer.core.model import ModelConfig, ModelInfo


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    return tmp_path / "codebooks"


def grown(model: RNNPB, batches: int, size: int = 3 * BATCH, at_once: int = FRAMES) -> Codebook:
    book = Codebook(model, size)
    for _ in range(batches):
        for _ in book.grow(at_once):
            pass
    return book


def test_every_beginning_of_the_pbs_is_a_codebook(tiny_model: RNNPB) -> None:
    pbs = codebook_pbs(tiny_model, 400)
    torch.testing.assert_close(pbs[:3], tiny_model.mu)
    mu = tiny_model.mu.numpy()
    between, wide = pbs[3::2].numpy(), pbs[4::2].numpy()
    assert between.std(axis=0).max() < wide.std(axis=0).max()
    low, high = mu.min(axis=0), mu.max(axis=0)
    room = 5 * 0.1 * mu.std(axis=0, ddof=1)
    assert ((between > low - room) & (between < high + room)).all()
    assert (codebook_pbs(tiny_model, 2).numpy() == mu[:2]).all()


@pytest.mark.parametrize("at_once", [FRAMES, 100, 37, STRIDE, 5])
def test_it_keeps_the_motions_that_the_model_makes(tiny_model: RNNPB, at_once: int) -> None:
    book = grown(tiny_model, 1, at_once=at_once)
    assert (book.entries, book.complete, len(book)) == (BATCH, False, 3 * BATCH)
    whole = tiny_model.generate(book.pbs[:BATCH], FRAMES)[:, ::STRIDE]
    torch.testing.assert_close(book.motions[:BATCH].float(), whole, rtol=1e-3, atol=1e-4)


def test_a_batch_that_is_given_up_is_made_by_somebody_else(tiny_model: RNNPB) -> None:
    book = Codebook(tiny_model, 2 * BATCH)
    given_up = book.grow(50)
    next(given_up)
    other = book.grow(50)
    next(other)
    given_up.close()
    for _ in other:
        pass
    assert book.entries == 0  # the second batch is there, the first is not
    for _ in book.grow():
        pass
    assert book.complete
    assert list(book.grow()) == []


def test_errors_are_those_of_the_kept_frames_and_of_the_observed_joints(tiny_model: RNNPB) -> None:
    book = grown(tiny_model, 3)
    observation = tiny_model.reconstruct(1, 40).numpy()
    errors = book.frame_errors(observation)
    assert errors.shape == (3 * BATCH, 4)
    motions = tiny_model.generate(book.pbs, 40).numpy()
    plain = np.square(motions - observation)[:, ::STRIDE]
    np.testing.assert_allclose(errors, plain.mean(axis=2), atol=1e-3)
    some = book.frame_errors(observation, [0, 3])
    np.testing.assert_allclose(some, plain[:, :, [0, 3]].mean(axis=2), atol=1e-3)
    long = np.zeros((2 * FRAMES, 5), np.float32)
    assert book.frame_errors(long).shape == (3 * BATCH, FRAMES // STRIDE)


def test_starts_are_the_best_that_lie_apart(tiny_model: RNNPB) -> None:
    book = grown(tiny_model, 3)
    starts = book.starts(tiny_model.reconstruct(2, 40).numpy(), 5)
    torch.testing.assert_close(starts[0], tiny_model.mu[2])
    gaps = torch.cdist(starts, starts) + torch.eye(len(starts)) * 1e9
    assert gaps.min() > APART * book.scale


def test_the_cache_gives_back_what_was_made(tiny_model: RNNPB, cache: Path) -> None:
    made = complete_codebook(tiny_model, 2 * BATCH)
    assert len(list(cache.iterdir())) == 1
    again = Codebook(tiny_model, 2 * BATCH)
    assert again.restore()
    assert again.complete
    assert torch.equal(again.motions, made.motions)
    tiny_model.weight_out += 1e-3  # another model has another one
    assert not Codebook(tiny_model, 2 * BATCH).restore()


@pytest.mark.parametrize("content", [b"", b"no array", b"\x93NUMPY\x01\x00v\x00{'descr'"])
def test_a_damaged_cache_is_made_anew(tiny_model: RNNPB, cache: Path, content: bytes) -> None:
    complete_codebook(tiny_model, BATCH)
    (file,) = cache.iterdir()
    file.write_bytes(content)
    assert not Codebook(tiny_model, BATCH).restore()
    assert complete_codebook(tiny_model, BATCH).complete
    assert Codebook(tiny_model, BATCH).restore()


def test_wrong_arrays_in_the_cache_are_not_used(tiny_model: RNNPB, cache: Path) -> None:
    made = complete_codebook(tiny_model, BATCH)
    (file,) = cache.iterdir()
    for wrong in (
        made.motions.numpy()[:-1],
        made.motions.float().numpy(),
        np.full(made.motions.shape, np.nan, np.float16),
    ):
        np.save(file, wrong)
        assert not Codebook(tiny_model, BATCH).restore()


def test_a_cache_that_cannot_be_written_is_no_fault(
    tiny_model: RNNPB, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "file"))
    assert complete_codebook(tiny_model, BATCH).complete


def test_the_cache_does_not_grow_for_ever(
    tiny_model: RNNPB, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(codebook, "KEPT", 2)
    for size in (64, 128, 192):
        complete_codebook(tiny_model, size)
    assert len(list(cache.iterdir())) == 2


def test_a_wider_network_has_fewer_entries(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(codebook, "SIZE", 16_384)
    monkeypatch.setattr(codebook, "SMALLEST", 1_024)
    sizes = []
    for hidden in (8, 256, 512, 4096):
        config = ModelConfig(num_joints=1, pb_dim=1, hidden_size=8, num_motions=1)
        model = RNNPB(config, ModelInfo(joints=("a",)))
        object.__setattr__(model.config, "hidden_size", hidden)
        sizes.append(size_for(model))
    assert sizes == [16_384, 16_384, 4_096, 1_024]
