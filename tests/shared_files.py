"""Data and published checkpoints in the folder shared/ beside the repository; not for shipping."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

SHARED = Path(__file__).parents[2] / "shared"
REQUIRED = "RNNPB_REQUIRE_SHARED"


def shared(*parts: str, folder: Path = SHARED) -> Path:
    """A file or folder in there; without it the test is skipped, or fails where it is required."""
    path = folder.joinpath(*parts)
    if path.exists():
        return path
    missing = f"needs {Path(*parts)} in the folder {folder.name}/ beside the repository"
    if os.environ.get(REQUIRED) == "1":
        pytest.fail(f"{missing} ({REQUIRED} is set)", pytrace=False)
    pytest.skip(missing)
