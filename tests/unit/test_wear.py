"""Pages that come and go leave nothing: the short run of what scripts/wear.py does for longer."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

WEAR = Path(__file__).parents[2] / "scripts" / "wear.py"


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="Linux alone says it in /proc")
def test_after_300_pages_the_server_is_as_before() -> None:
    outcome = subprocess.run(
        [sys.executable, WEAR, "pages", "300"], stdout=subprocess.PIPE, text=True, check=False
    )
    assert "as before" in outcome.stdout
    assert outcome.returncode == 0
