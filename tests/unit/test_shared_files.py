"""What tests do that need files which are not part of the repository."""

from __future__ import annotations

from pathlib import Path

import pytest
from shared_files import REQUIRED, shared


def test_what_is_there_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(REQUIRED, "1")
    (tmp_path / "data").mkdir()
    assert shared("data", folder=tmp_path) == tmp_path / "data"


@pytest.mark.parametrize(
    ("required", "ends"), [("1", pytest.fail.Exception), ("", pytest.skip.Exception)]
)
def test_what_is_missing_is_said(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    required: str,
    ends: type[BaseException],
) -> None:
    monkeypatch.setenv(REQUIRED, required)
    either = (pytest.fail.Exception, pytest.skip.Exception)  # or a skip would skip this test
    with pytest.raises(either, match=r"needs data/x\.csv in the folder") as caught:
        shared("data", "x.csv", folder=tmp_path)
    assert caught.type is ends
