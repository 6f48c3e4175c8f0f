"""The kernel behind the shipped checkpoints gives the gradients of plain training."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.model import ModelConfig
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.core.training import Trainer, TrainingConfig

SCRIPTS = Path(__file__).parents[2] / "scripts" / "fast_training"


def _has_amx() -> bool:
    cpu = Path("/proc/cpuinfo")
    return cpu.is_file() and "amx_bf16" in cpu.read_text() and shutil.which("g++") is not None


@pytest.mark.skipif(not _has_amx(), reason="needs g++ and a processor with AMX")
@pytest.mark.parametrize("exact", [True, False], ids=["exact", "quick"])
def test_packed_epoch_equals_plain_epoch(exact: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(SCRIPTS))
    packed_lstm = pytest.importorskip("packed_lstm")
    monkeypatch.setattr(packed_lstm.PackedTrainer, "exact_from", -1.0 if exact else 2.0)
    random = np.random.default_rng(0)
    motions = tuple(  # of unequal lengths, not sorted, more than one tile of 16
        Motion(f"m{i}", ("a", "b"), random.normal(size=(2 + 5 * i % 23, 2)).astype(np.float32))
        for i in range(37)
    )
    trainers = [
        kind(Dataset(motions, {}), ModelConfig(pb_dim=3), TrainingConfig(epochs=5, samples=3))
        for kind in (Trainer, packed_lstm.PackedTrainer)
    ]
    sys.modules.pop("packed_lstm", None)
    plain, packed = (next(trainer.run()) for trainer in trainers)
    # In bfloat16 a product is off by up to 2^-8; the backward pass always works in it.
    assert packed.loss == pytest.approx(plain.loss, rel=1e-5 if exact else 1e-3)
    for (name, expected), actual in zip(
        trainers[0].model.named_parameters(), trainers[1].model.parameters(), strict=True
    ):
        assert expected.grad is not None
        assert actual.grad is not None
        error = torch.linalg.vector_norm(actual.grad - expected.grad)
        assert error < 0.02 * torch.linalg.vector_norm(expected.grad), name
