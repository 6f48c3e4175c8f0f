"""Fixtures of the unit tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from rnnpb_explorer.core import RNNPB, codebook

from .cli_harness import Rnnpb

# How long an example takes says how busy the machine is, not whether the program is right.
settings.register_profile("no deadline", deadline=None)
settings.load_profile("no deadline")


@pytest.fixture(autouse=True, scope="session")
def small_codebooks() -> Iterator[None]:
    """Codebooks that are made in a moment."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(codebook, "SIZE", 512)
        patch.setattr(codebook, "SMALLEST", 128)
        yield


@pytest.fixture
def rnnpb(
    tiny_model: RNNPB,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> Rnnpb:
    """The command in a folder of its own, with `tiny.pt` and `data/` in it."""
    monkeypatch.chdir(tmp_path)
    return Rnnpb(tmp_path, tiny_model, capsys)
