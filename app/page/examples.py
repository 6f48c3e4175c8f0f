"""The example motions that ship with the package, and what each of them is there to teach."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable


@dataclass(frozen=True)
class Example:
    """
    look_for: what a person should look at. hidden: joints that are not observed with it.
    """

    name: str
    file: Traversable
    look_for: str = ""
    hidden: tuple[str, ...] = ()

    def read(self) -> bytes:
        return self.file.read_bytes()

    def observed_joints(self, joints: tuple[str, ...]) -> tuple[str, ...]:
        """Those of a model's joints that are observed with it; all, where it would be none."""
        return tuple(joint for joint in joints if joint not in self.hidden) or joints


@cache
def examples() -> tuple[Example, ...]:
    """All of them, in the order of `examples.toml`."""
    folder = files("rnnpb_explorer.static") / "examples"
    if not folder.is_dir():
        return ()
    told = tomllib.loads((folder / "examples.toml").read_text(encoding="utf-8"))
    return tuple(
        Example(name, folder / f"{name}.csv", one["look_for"], tuple(one.get("hidden", ())))
        for name, one in told.items()
    )
