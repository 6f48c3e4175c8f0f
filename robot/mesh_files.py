"""The files that a description's meshes are in, looked for as the tools of ROS do."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from lxml import etree

MAX_BYTES = 200_000_000  # of one mesh
MAX_ENTRIES = 5_000  # of a folder that are looked at
LEVELS = 5  # folders above the description whose packages are looked through
SUFFIXES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".off")
PACKAGE = re.compile(
    r"(?P<how>package://|model://|(?:file:(?://)?)?\$\(find (?P<found>[^)]+)\))(?P<rest>.*)",
    re.DOTALL,
)


@dataclass(frozen=True)
class MeshFile:
    """A mesh that a description names, and what became of it.

    name: as the description has it. link: the first that it belongs to.
    remark: how the file was found, where it was not as named; empty otherwise.
    problem: why nothing of it is shown; empty where it is.
    """

    name: str
    link: str
    file: Path | None
    remark: str = ""
    problem: str = ""


def mesh_warnings(meshes: tuple[MeshFile, ...]) -> list[str]:
    """A line for each that is missing, and one for those that were found in the same other way."""
    ways: dict[str, list[str]] = {}
    for mesh in meshes:
        if mesh.remark and not mesh.problem:
            ways.setdefault(mesh.remark, []).append(mesh.name)
    return [
        f"link {mesh.link} is shown without {mesh.name}: {mesh.problem}"
        for mesh in meshes
        if mesh.problem
    ] + [
        names[0] + (f" and {len(names) - 1} more" if len(names) > 1 else "") + f": {remark}"
        for remark, names in ways.items()
    ]


class MeshFinder:
    """Finds the meshes of one description.

    A package is looked for beside and above the description, in the folders of ROS_PACKAGE_PATH and
    AMENT_PREFIX_PATH, by the name in its `package.xml`, and at last as the folder that holds the
    rest of the path. Only files that a mesh can be in are ever found.
    """

    def __init__(self, urdf_path: Path) -> None:
        self._folder = urdf_path.parent
        self._above = tuple(urdf_path.resolve().parents)
        self._packages: dict[str, Path] | None = None

    def find(self, name: str) -> tuple[Path | None, str]:
        """The file, and in which way it is not the one that is named; or None, and why."""
        if re.match(r"https?:", name, re.IGNORECASE):
            return None, "it is on the network, from where nothing is fetched"
        if not _spellings(name)[0][0].lower().endswith(SUFFIXES):
            return None, f"of meshes {' '.join(SUFFIXES)} can be read"
        for any_case in (False, True):
            for spelling, remark in _spellings(name):
                for candidate, how in self._candidates(spelling):
                    file = _in_any_case(candidate) if any_case else candidate
                    if file is not None and os.path.isfile(file):
                        case = "found in other case" if any_case else ""
                        return file, ", ".join(filter(None, (remark, how, case)))
        return None, "no such file"

    def _candidates(self, name: str) -> Iterator[tuple[Path, str]]:
        match = PACKAGE.match(name)
        if match is None:
            path = re.sub(r"^file:(//(localhost(?=/))?)?", "", name)
            yield self._folder / path, ""  # absolute ones stay so
            if path != name:
                yield self._folder / path.lstrip("/"), "found beside the description"
            # an absolute path of the machine on which it was written
            for count in (3, 2):
                parts = PurePosixPath(path).parts
                if len(parts) > count and (path.startswith("/") or parts[0].endswith(":")):
                    for folder in self._above[:LEVELS]:
                        yield folder.joinpath(*parts[-count:]), f"found in {folder.name}"
            return
        if match["found"] is not None:
            package, rest = match["found"].strip(), match["rest"].lstrip("/")
        else:
            package, _, rest = match["rest"].lstrip("/").partition("/")
        scheme = "$(find ...)" if match["found"] else match["how"]
        how = "" if scheme == "package://" else f"{scheme} taken for package://"
        for folder in self._above:
            yield folder / package / rest, how
        for root in _search_path():
            yield root / package / rest, how
        if package in self.packages:
            by_name = f"package {package} is the folder {self.packages[package].name}"
            yield self.packages[package] / rest, by_name
        for folder in self._above:
            yield folder / rest, how

    @property
    def packages(self) -> dict[str, Path]:
        """The packages beside and above the description, by the name in their `package.xml`."""
        if self._packages is None:
            self._packages = {}
            for folder in self._above[:LEVELS]:
                for place in (folder, *_folders_in(folder)):
                    name = _package_name(place / "package.xml")
                    if name:
                        self._packages.setdefault(name, place)
        return self._packages


def _spellings(name: str) -> list[tuple[str, str]]:
    """A file's name as it stands, and as it may be meant."""
    spellings = {(name := name.strip()): ""}
    for meant, remark in (
        (name.replace("\\", "/"), "\\ taken for /"),
        (unquote(name), "%-signs worked out"),
        (unquote(name.replace("\\", "/")), "\\ taken for /, %-signs worked out"),
    ):
        spellings.setdefault(meant, remark)
    return [(one, remark) for one, remark in spellings.items() if "\0" not in one]


def _search_path() -> list[Path]:
    ros = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    ament = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(one) for one in ros if one] + [Path(one) / "share" for one in ament if one]


def _in_any_case(path: Path) -> Path | None:
    """The file of this path where only capitals differ, below the deepest folder that is there."""
    missing: list[str] = []
    while not os.path.isdir(path):
        if path.parent == path:
            return None
        missing.append(path.name)
        path = path.parent
    for name in reversed(missing):
        if name in ("", ".", ".."):
            return None
        same = [entry for entry in _entries(path) if entry.lower() == name.lower()]
        if len(same) != 1:  # none, or which?
            return None
        path = path / same[0]
    return path


@lru_cache(maxsize=256)
def _listing(folder: Path, changed: int) -> tuple[str, ...]:
    with os.scandir(folder) as entries:
        return tuple(entry.name for entry in islice(entries, MAX_ENTRIES))


def _entries(folder: Path) -> tuple[str, ...]:
    try:
        return _listing(folder, folder.stat().st_mtime_ns)
    except OSError:
        return ()


def _folders_in(folder: Path) -> list[Path]:
    return [folder / name for name in _entries(folder) if not name.startswith(".")]


def _package_name(file: Path) -> str | None:
    try:
        if not file.is_file() or file.stat().st_size > 1_000_000:
            return None
        parser = etree.XMLParser(resolve_entities=False, no_network=True)
        name = etree.fromstring(file.read_bytes(), parser).findtext("name")
    except (OSError, etree.XMLSyntaxError):
        return None
    return name.strip() if name else None
