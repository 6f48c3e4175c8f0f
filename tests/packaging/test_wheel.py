"""The wheel, installed into an empty environment, away from the source tree."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import urllib.request
import venv
import zipfile
from pathlib import Path

import pytest
from PIL import Image

from rnnpb_explorer.app.commands.photograph import find_chromium

ROOT = Path(__file__).parents[2]
PACKAGES = ("core", "robot", "app", "static", "checkpoints")
NOT_SHIPPED = ("__pycache__", "*.pyc", "*.resume.pt", "*.part")
# What a person's shell may set and an empty environment does not know.
FOREIGN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")

pytestmark = pytest.mark.packaging


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what a wheel is built from: no stale build folder, nothing else in reach."""
    copy = tmp_path_factory.mktemp("source")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns(*NOT_SHIPPED))
    for name in ("pyproject.toml", "README.md", "LICENSE", "NOTICE"):
        shutil.copy(ROOT / name, copy)
    return copy


@pytest.fixture(scope="module")
def wheel(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", out, source)
    (built,) = out.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with nothing but the wheel and, by path, what it depends on.

    A `.pth` file lends this environment's packages, but not what their own `.pth` files do: the
    editable install of the source tree stays behind.
    """
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False, symlinks=True)
    python = folder / "bin" / "python"
    run(sys.executable, "-m", "pip", f"--python={python}", "install", "--no-deps", "-q", wheel)
    (site_packages,) = folder.glob("lib/python*/site-packages")
    lent = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (site_packages / "lent.pth").write_text("\n".join(sorted(lent)) + "\n")
    return folder


def run(*command: str | Path, cwd: Path | None = None) -> str:
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, env=clean_environment(), text=True,
        stdin=subprocess.DEVNULL, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return done.stdout


def clean_environment() -> dict[str, str]:
    return {key: value for key, value in os.environ.items() if key not in FOREIGN}


def test_wheel_has_every_file_and_no_other_top_level_name(wheel: Path, source: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    expected = {
        f"rnnpb_explorer/{path.relative_to(source)}"
        for name in PACKAGES
        for path in (source / name).rglob("*")
        if path.is_file()
    }
    assert packed == expected


def test_modules_come_from_the_wheel(environment: Path, tmp_path: Path) -> None:
    names = ", ".join(f"rnnpb_explorer.{name}" for name in PACKAGES)
    program = f"import sys, {names}; print(*[m.__file__ for m in ({names})], sep='\\n')"
    places = run(environment / "bin" / "python", "-c", program, cwd=tmp_path).splitlines()
    assert len(places) == len(PACKAGES)
    assert all(Path(place).is_relative_to(environment) for place in places), places


def test_app_serves_its_page_and_ends_cleanly(environment: Path, tmp_path: Path) -> None:
    process = subprocess.Popen(
        [str(environment / "bin" / "rnnpb-explorer"), "--port", "0"],
        cwd=tmp_path, env=clean_environment(), text=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        line = process.stdout.readline().strip()
        said, _, url = line.rpartition(" ")
        assert said == "rnnpb-explorer is ready at", process.communicate()[1][-4000:]
        assert url.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(url, timeout=30) as page:
            assert b"<html" in page.read(1000)
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=30)
        assert process.returncode == 0, errors[-4000:]
    finally:
        process.kill()


@pytest.mark.browser
def test_app_draws_itself_with_its_own_files(environment: Path, tmp_path: Path) -> None:
    if find_chromium() is None and os.environ.get("RNNPB_REQUIRE_BROWSER") != "1":
        pytest.skip("no Chromium")
    out = tmp_path / "app.png"
    command = environment / "bin" / "rnnpb"
    run(command, "screenshot", "--size", "800x600", "--frame", "0", "--out", out, cwd=tmp_path)
    picture = Image.open(out).convert("RGB")
    assert picture.size == (800, 600)
    colors = picture.getcolors(800 * 600)
    assert colors is not None
    assert len(colors) > 200  # a robot, two boards and a panel, no blank page
