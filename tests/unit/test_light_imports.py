"""The small definitions that every page, command and `--help` needs load nothing heavy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from rnnpb_explorer.app.commands.main import COMMANDS
from rnnpb_explorer.app.state import document

ROOT = Path(__file__).parents[2]
HEAVY = ("torch", "trimesh", "yourdfpy", "viser", "matplotlib")
LIGHT = (
    *(f"app.state.{path.stem}" for path in sorted((ROOT / "app/state").glob("[!_]*.py"))),
    "core.data",
    "core.device",
    "core.errors",
    "core.latent_map",
    "core.motion",
    "core.recognition_run",
    "core.windows",
    "robot.formats",
    "robot.reading",
    "robot.pepper",
    "robot.safety_report",
    "app.commands.explorer",
    *(f"app.commands.{name}" for name in COMMANDS),
)


def loaded(*modules: str) -> list[str]:
    """What is heavy in an interpreter of its own that has imported these."""
    program = "import sys\n" + "".join(f"import rnnpb_explorer.{module}\n" for module in modules)
    program += f"print(*[name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stderr == ""
    return done.stdout.split()


def test_light_modules_load_nothing_heavy() -> None:
    assert loaded(*LIGHT) == []


def test_the_pure_state_loads_nothing_heavy() -> None:
    files = Path(document.__file__).parent.glob("[a-z]*.py")
    modules = [f"app.state.{path.stem}" for path in files]
    assert len(modules) > 10
    assert loaded(*modules) == []


def test_it_sees_what_is_heavy() -> None:
    assert loaded("core.model") == ["torch"]
