"""Every command computes where `--device` says, and mixes nothing that lies in two places.

Few machines that run these tests have a GPU. torch's meta device stands in for one: it has shapes
and no numbers, so that all that is shown is where things are computed.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch.fx.experimental import _config as config
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from rnnpb_explorer.core import RNNPB, landscape, load_checkpoint
from rnnpb_explorer.core.codebook import Codebook
from rnnpb_explorer.core.device import choose_device
from rnnpb_explorer.core.following import Follower
from rnnpb_explorer.core.observation import Observation
from rnnpb_explorer.core.recognition_lm import posterior_pieces
from rnnpb_explorer.core.training import Trainer, TrainingProgress

from .cli_harness import Rnnpb

aten = torch.ops.aten
MAY_MIX = (aten.copy_.default, aten.index.Tensor)  # an index may lie with the processor


class _AsAGpu(TorchDispatchMode):
    """Has the meta device refuse what a GPU refuses, and hand over numbers. They are all zero."""

    def __torch_dispatch__(
        self,
        func: Any,
        types: object,
        args: tuple[Any, ...] = (),
        kwargs: Mapping[str, Any] | None = None,
    ) -> Any:
        kwargs = kwargs or {}
        tensor = args[0] if args and isinstance(args[0], torch.Tensor) else None
        if tensor is not None and tensor.is_meta:
            if func is aten._local_scalar_dense.default:  # item(), and what a condition asks
                return True if tensor.dtype == torch.bool else 0.0
            if func is aten._to_copy.default and kwargs.get("device") == torch.device("cpu"):
                return torch.zeros(tensor.shape, dtype=kwargs.get("dtype") or tensor.dtype)
        with self:  # in inference mode, operations arrive undivided
            result = func.decompose(*args, **kwargs)
        if result is not NotImplemented:
            return result
        places = {
            value.device.type
            for value in tree_leaves((args, kwargs))
            if isinstance(value, torch.Tensor) and value.ndim > 0  # one number may lie anywhere
        }
        if len(places) > 1 and func not in MAY_MIX:
            raise RuntimeError(f"{func} of tensors on {' and '.join(sorted(places))}")
        return func(*args, **kwargs)


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """`--device` means the stand-in."""
    meta = torch.device("meta")
    monkeypatch.setattr("rnnpb_explorer.core.device.choose_device", lambda name: meta)
    # A mask on the stand-in takes everything.
    with config.patch(meta_nonzero_assume_all_nonzero=True), _AsAGpu():
        yield


@pytest.mark.parametrize(
    "mix",
    [
        lambda here, there: here + there,
        lambda here, there: there @ here,
        lambda here, there: torch.cat([there, here]),
        lambda here, there: there.numpy(),
    ],
    ids=["add", "matmul", "cat", "numpy"],
)
def test_the_stand_in_refuses_to_mix(
    elsewhere: None, mix: Callable[[torch.Tensor, torch.Tensor], object]
) -> None:
    with pytest.raises((RuntimeError, TypeError)):
        mix(torch.ones(3, 3), torch.ones(3, 3, device="meta"))


MODEL = ("--ckpt", "tiny.pt")
DATA = ("--data", "data")
TRAIN = ("train", *DATA, "--hidden-size", 8, "--epochs", 2)
RECOGNIZE = ("recognize", *MODEL, "data/rest.csv", "--trials", 2, "--iterations", 3)


@pytest.mark.parametrize(
    "command",
    [
        (*TRAIN, "--out", "C.pt"),
        (*TRAIN, "--samples", 2, "--out", "C.pt"),
        (*TRAIN, "--behavior", "deterministic", "--out", "C.pt"),
        ("generate", *MODEL, "--motion", "bow", "--samples", 2, "--out", "x.csv"),
        ("landscape", *MODEL, "--motion", "bow", "--out", "L.npz"),
        ("landscape", *MODEL, *DATA, "--motion", "bow", "--axes", "pca", "--out", "L.png"),
        (*RECOGNIZE, "--init", "baseline", "--out", "R.npz"),
        (*RECOGNIZE, "--init", "learned", "--out", "R.npz"),
        (*RECOGNIZE, "--init", "random", "--out", "R.npz"),
        (*RECOGNIZE, "--method", "lm", "--out", "R.npz"),
        (*RECOGNIZE, "--method", "global", "--out", "R.npz"),
        (
            *("evaluate", *MODEL, *DATA, "--task", "reconstruction,structure"),
            *("--samples", 4),
        ),
        (
            *("sweep", *DATA, "--hidden-size", 8, "--epochs", 1, "--samples", 4, "--pb-dims", 2),
            *("--conditions", "strong", "--jobs", 1, "--keep-checkpoints", "--out", "cells"),
        ),
    ],
    ids=lambda command: " ".join(str(word) for word in command if not str(word).startswith("--")),
)
def test_nothing_is_mixed(
    rnnpb: Rnnpb, elsewhere: None, monkeypatch: pytest.MonkeyPatch, command: tuple[object, ...]
) -> None:
    seen = _devices_of_generation(monkeypatch)
    outcome = rnnpb(*command)
    assert outcome.code == 0, outcome
    assert "meta" in seen
    for file in Path().rglob("C.pt"):
        assert load_checkpoint(file).mu.device.type == "cpu"


def test_a_follower_and_a_posterior_mix_nothing(tiny_model: RNNPB, elsewhere: None) -> None:
    model = tiny_model.to("meta")
    book = Codebook(model, 64)
    for _ in book.grow():
        pass
    follower = Follower(model, codebook=book, joints=(0, 1), beside=False, horizon=30)
    for frame in np.zeros((3, 5)):
        assert follower.update(frame).foretold.shape == (30, 5)
        while follower.work():
            pass
    seen = Observation.of(model, np.zeros((20, 5)), 0.8, (0, 1))
    *_, belief = posterior_pieces(model, model.mu[0], seen)
    assert belief is not None
    assert belief.covariance.shape == (3, 3)


@pytest.mark.filterwarnings("ignore:.*copying from a non-meta parameter:UserWarning")
def test_a_run_goes_on_elsewhere(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    run = Trainer.run

    def interrupted(self: Trainer) -> Iterator[TrainingProgress]:
        for progress in run(self):
            yield progress
            if progress.epoch == 1:
                raise KeyboardInterrupt

    monkeypatch.setattr(Trainer, "run", interrupted)
    monkeypatch.setattr("rnnpb_explorer.app.commands.train.SAVE_EVERY", 0.0)
    assert rnnpb(*TRAIN, "--out", "C.pt").code == 130
    monkeypatch.setattr(Trainer, "run", run)
    request.getfixturevalue("elsewhere")
    outcome = rnnpb("train", *DATA, "--resume", "C.resume.pt", "--out", "C.pt")
    assert outcome.code == 0, outcome
    assert outcome.out.startswith("2 epochs")


def _devices_of_generation(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """Where motions are generated from now on; filled as it happens."""
    seen: set[str] = set()
    generate = RNNPB.generate

    def noting(self: RNNPB, pb: torch.Tensor, steps: int) -> torch.Tensor:
        motions = generate(self, pb, steps)
        seen.add(motions.device.type)
        return motions

    monkeypatch.setattr(RNNPB, "generate", noting)
    return seen


def test_a_gpu_computes_in_float32_and_without_remarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.backends.cudnn, "allow_tf32", True)
    with warnings.catch_warnings(record=True) as remarks:
        warnings.simplefilter("always")
        assert choose_device("auto") == torch.device("cuda")
        assert not torch.backends.cudnn.allow_tf32
        warnings.warn("RNN module weights are not part of single contiguous chunk", stacklevel=1)
        warnings.warn("something else", stacklevel=1)
    assert [str(remark.message) for remark in remarks] == ["something else"]


@pytest.mark.skipif(not torch.cuda.is_available(), reason="torch finds no GPU on this machine")
def test_a_gpu_learns_and_generates_as_the_processor_does(rnnpb: Rnnpb) -> None:
    for device in ("cpu", "cuda"):
        outcome = rnnpb(*TRAIN, "--device", device, "--out", f"{device}.pt")
        assert (outcome.code, outcome.err) == (0, ""), outcome
        motion = ("--motion", "bow", "--device", device, "--out", f"{device}.csv")
        assert rnnpb("generate", *MODEL, *motion).code == 0
    here, there = (load_checkpoint(f"{device}.pt").state_dict() for device in ("cpu", "cuda"))
    for name, values in here.items():
        torch.testing.assert_close(there[name], values, rtol=1e-3, atol=1e-5, msg=name)
    generated = [np.loadtxt(f"{d}.csv", delimiter=",", skiprows=1) for d in ("cpu", "cuda")]
    np.testing.assert_allclose(*generated, atol=1e-5)
    model, target = rnnpb.model, rnnpb.target(1).positions
    correlations = [
        landscape(model.to(device), target, rnnpb.model.mu[1].tolist(), grid=4).correlation
        for device in ("cpu", "cuda")
    ]
    np.testing.assert_allclose(*correlations, atol=1e-4)
