"""Imports go one way: core <- robot <- app, state <- engine and page <- commands, in no circle."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = [
    path.relative_to(ROOT)
    for layer in ("core", "robot", "app")
    for path in (ROOT / layer).rglob("*.py")
]
APP = "rnnpb_explorer.app"
# What no module below a folder may import, nor for types alone.
FORBIDDEN = {
    "core": ("rnnpb_explorer.robot", APP, "viser", "argparse", "cyclopts"),
    "robot": (APP, "viser", "argparse", "cyclopts"),
    "app/state": (f"{APP}.engine", f"{APP}.page", f"{APP}.commands", "viser", "torch", "trimesh"),
    "app/engine": (f"{APP}.page", f"{APP}.commands", "viser"),
    "app/page": (f"{APP}.commands",),
}
EXCEPTIONS = {Path("robot/view.py"): "viser"}


def imported(source: str, path: Path) -> Iterator[str]:
    """Absolute dotted names of everything that a source file imports, wherever in the file."""
    package = ("rnnpb_explorer", *path.parent.parts)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            anchor = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join([*anchor, *([node.module] if node.module else [])])
            yield from (f"{module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call):  # importlib.import_module("..."), __import__("...")
            name = getattr(node.func, "attr", getattr(node.func, "id", None))
            first = node.args[0] if node.args else None
            if name in ("import_module", "__import__") and isinstance(first, ast.Constant):
                yield str(first.value)


def violations(source: str, path: Path) -> list[str]:
    return [
        name
        for name in imported(source, path)
        for folder, layers in FORBIDDEN.items()
        if path.is_relative_to(folder)
        for layer in layers
        if (name == layer or name.startswith(layer + ".")) and EXCEPTIONS.get(path) != layer
    ]


def dotted(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(("rnnpb_explorer", *(parts[:-1] if parts[-1] == "__init__" else parts)))


def circle(sources: dict[Path, str]) -> list[str]:
    """Modules that import each other in a circle, the first one again at the end; [] if none do."""
    modules = {dotted(path) for path in sources}
    graph = {
        dotted(path): {
            # `from package import name`: the module of that name, or else the package itself
            next(module for module in (name, name.rpartition(".")[0]) if module in modules)
            for name in imported(source, path)
            if name in modules or name.rpartition(".")[0] in modules
        }
        for path, source in sources.items()
    }
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


@pytest.mark.parametrize("path", SOURCES, ids=str)
def test_imports_go_one_way(path: Path) -> None:
    assert violations((ROOT / path).read_text(encoding="utf-8"), path) == []


@pytest.mark.parametrize("layer", ["core", "robot", "app"])
def test_no_module_imports_itself_in_a_circle(layer: str) -> None:
    """Imports for types count: who knows whom should be said in one direction."""
    inside = [path for path in SOURCES if path.parts[0] == layer]
    assert circle({path: (ROOT / path).read_text(encoding="utf-8") for path in inside}) == []


def test_core_prints_nothing() -> None:
    """What a command says is the command's; so is the end of the program."""
    found = [
        f"{path}:{node.lineno}"
        for path in SOURCES
        if path.parts[0] in ("core", "robot")
        for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        and ast.unparse(node.func) in ("print", "input", "exit", "sys.exit")
    ]
    assert found == []


def test_all_layers_were_looked_at() -> None:
    assert {path.parts[0] for path in SOURCES} == {"core", "robot", "app"}
    assert Path("core/model.py") in SOURCES


@pytest.mark.parametrize(
    ("source", "path", "found"),
    [
        ("import viser", "core/model.py", ["viser"]),
        ("import viser.extras as v", "robot/pepper.py", ["viser.extras"]),
        ("from viser import ViserServer", "core/a/b.py", ["viser.ViserServer"]),
        ("from ..robot.pepper import X", "core/model.py", ["rnnpb_explorer.robot.pepper.X"]),
        ("from .. import app", "robot/view.py", ["rnnpb_explorer.app"]),
        ("from ...robot import x", "core/paper/figures.py", ["rnnpb_explorer.robot.x"]),
        ("def f():\n    import rnnpb_explorer.app", "core/m.py", ["rnnpb_explorer.app"]),
        ("importlib.import_module('viser')", "core/m.py", ["viser"]),
        ("import viser", "robot/view.py", []),
        ("from ..page import board", "app/state/document.py", [f"{APP}.page.board"]),
        ("if TYPE_CHECKING:\n    import torch", "app/state/intents.py", ["torch"]),
        (
            "from ..page.session import Session",
            "app/engine/queue.py",
            [f"{APP}.page.session.Session"],
        ),
        ("from ...commands import main", "app/page/panels/help.py", [f"{APP}.commands.main"]),
        ("from ..state import document", "app/page/session.py", []),
        ("from ...core import model\nimport viser", "app/page/session.py", []),
        ("from .landscape import landscape\nfrom . import app", "core/m.py", []),
    ],
)
def test_the_rule_finds_what_breaks_it(source: str, path: str, found: list[str]) -> None:
    assert violations(source, Path(path)) == found


@pytest.mark.parametrize(
    ("sources", "found"),
    [
        (
            {"a": "from .b import x", "b": "from . import c", "c": "from .a import y"},
            {"a", "b", "c"},
        ),
        (
            {"a": "if TYPE_CHECKING:\n    from .b import X", "b": "def f():\n    from . import a"},
            {"a", "b"},
        ),
        ({"a": "from .b import x\nfrom .c import y", "b": "from .c import z", "c": ""}, set()),
        ({"a/__init__": "from .b import x", "a/b": "from . import y"}, {"a", "a.b"}),
    ],
)
def test_a_circle_is_found(sources: dict[str, str], found: set[str]) -> None:
    files = {Path("core", f"{name}.py"): source for name, source in sources.items()}
    assert set(circle(files)) == {f"rnnpb_explorer.core.{name}" for name in found}
