"""Imports go one way: core <- robot <- app, and viser stays at the screen."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = [
    path.relative_to(ROOT)
    for layer in ("core", "robot", "app")
    for path in (ROOT / layer).rglob("*.py")
]
FORBIDDEN = {
    "core": ("rnnpb_explorer.robot", "rnnpb_explorer.app", "viser"),
    "robot": ("rnnpb_explorer.app", "viser"),
    "app": (),
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
        for layer in FORBIDDEN[path.parts[0]]
        if (name == layer or name.startswith(layer + ".")) and EXCEPTIONS.get(path) != layer
    ]


@pytest.mark.parametrize("path", SOURCES, ids=str)
def test_imports_go_one_way(path: Path) -> None:
    assert violations((ROOT / path).read_text(encoding="utf-8"), path) == []


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
        ("from ...core import model\nimport viser", "app/page/session.py", []),
        ("from .landscape import landscape\nfrom . import app", "core/m.py", []),
    ],
)
def test_the_rule_finds_what_breaks_it(source: str, path: str, found: list[str]) -> None:
    assert violations(source, Path(path)) == found
