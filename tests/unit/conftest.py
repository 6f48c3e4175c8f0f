"""Fixtures of the unit tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from rnnpb_explorer.core import RNNPB

from .cli_harness import Rnnpb


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
