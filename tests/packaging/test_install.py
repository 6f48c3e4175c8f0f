"""scripts/install.py, with the real pip: a line that tells, and what went wrong where it did."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

INSTALL = Path(__file__).parents[2] / "scripts" / "install.py"
OFFLINE = ("--no-index", "--no-build-isolation", "--no-deps")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "tiny_motion.py").write_text("frames = 3\n")
    (folder / "pyproject.toml").write_text(
        '[project]\nname = "tiny-motion"\nversion = "1"\n'
        '[build-system]\nrequires = []\nbuild-backend = "setuptools.build_meta"\n'
    )
    return folder


def test_it_installs_and_says_so_in_two_lines(package: Path, tmp_path: Path) -> None:
    target = tmp_path / "target"
    done = subprocess.run(
        [sys.executable, INSTALL, *OFFLINE, "--target", target, package],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "")
    assert (target / "tiny_motion.py").is_file()
    begin, end = done.stderr.splitlines()
    assert begin.startswith("installing packages")
    assert end.startswith("installed 1 packages in ")


def test_a_terminal_shows_what_it_is_doing(package: Path, tmp_path: Path) -> None:
    terminal, other_end = pty.openpty()
    with subprocess.Popen(
        [sys.executable, INSTALL, *OFFLINE, "--target", tmp_path / "target", package],
        stdout=other_end,
        stderr=other_end,
    ) as process:
        os.close(other_end)
        shown = b""
        try:
            while part := os.read(terminal, 4096):
                shown += part
        except OSError:  # the end of a terminal
            pass
        finally:
            os.close(terminal)
    assert process.returncode == 0
    assert b"installing, 0 s: " in shown
    assert shown.count(b"\n") == 2  # each line of the status goes over the one before
    assert shown.split(b"\r\x1b[K")[-1].startswith(b"installed 1 packages in ")


def test_a_failure_is_pips_own(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, INSTALL, *OFFLINE, "--target", tmp_path, "no-such-motion"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "No matching distribution found for no-such-motion" in done.stderr
    assert "\ninstalled" not in done.stderr
