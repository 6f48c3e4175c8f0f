"""A URDF as people have it, read into the plain one that yourdfpy takes.

Readers differ in what they let pass; a description that works in any of them should work here. What
is passed over, or read as something else than it says, is a warning with its line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

from lxml import etree

from ..core.errors import InputError

MAX_BYTES = 20_000_000
MAX_LINKS = 5_000  # of all that a description may have; robots have some hundred
LARGEST = 1e6  # metres, radians, factors: beyond it is no robot
SMALLEST = 1e-7  # metres
# As it declares itself; where that is wrong, as most are, and at last one that takes any bytes.
ENCODINGS = (None, "utf-8", "iso-8859-1")
# Where a text is no XML to the letter, but other readers know what is meant; libxml2's numbers.
PASSED = {
    5: "something follows </robot>",
    23: "an & that begins no entity",
    26: "an entity that is defined nowhere",
    38: "a < in a value",
    42: "an attribute is given twice",
    64: "something stands before <?xml ...?>",
    65: "a space is missing",
    68: "an & that begins no entity",
    80: "-- in a comment",
    96: "<?xml ...?> without a version",
    97: "an unknown version of XML",
    108: "an unknown version of XML",
    201: "a prefix is declared nowhere",
}
BROKEN = {
    4: "it does not begin with a tag",
    9: "a character that XML does not allow",
    38: "a < in a value",
    39: "a value without quotes",
    40: "a value without a closing quote",
    41: "an attribute without a value",
    73: "a tag without its >",
    76: "a tag is closed that is not the open one",
    77: "it ends within <robot>",
    114: "entities or tags within each other without end",
}
# What a robot is built of here; everything else in a description is for other programs.
CHILDREN = {
    "robot": ("link", "joint", "material"),
    "link": ("visual",),
    "visual": ("origin", "geometry", "material"),
    "joint": ("parent", "child", "origin", "axis", "limit", "mimic"),
    "material": ("color",),
}
NAMES = {
    "link": ("name",),
    "joint": ("name", "type"),
    "parent": ("link",),
    "child": ("link",),
    "mimic": ("joint",),
    "mesh": ("filename",),
    "material": ("name",),
}
NUMBERS = {  # how many
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "velocity": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "color": {"rgba": 4},
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "mesh": {"scale": 3},
}
SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
WRITTEN_FOR_XACRO = ("include", "macro", "if", "unless", "insert_block")
EXPRESSION = re.compile(r"\$\{|\$\((?!find )")  # for xacro to work out
CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]+")
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|[+-]?inf(?:inity)?", re.IGNORECASE)


def read_urdf(path: Path) -> tuple[ElementTree.Element, list[str]]:
    """The plain description in a file, and a warning for everything that was not.

    All numbers in it are whole and finite (limits aside), all links that joints name are there,
    names are given once; a capsule is a cylinder whose visual is named so.

    Raises:
        InputError: no such file, no URDF, or one that lacks what a robot is made of.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:  # a null character in the name
        raise InputError(f"{str(path)!r} is no file name") from error
    if len(content) > MAX_BYTES:
        raise InputError(f"{path} has over {MAX_BYTES // 1_000_000} MB; no URDF is so large")
    root, warnings = _parse(content, path)
    if _local(root) != "robot":
        raise InputError(f"{path} is no URDF: its root is <{_local(root)}>, expected <robot>")
    reading = _Reading(path, warnings)
    robot = reading.robot(root)
    return robot, list(reading.warnings.values())


def _parse(content: bytes, path: Path) -> tuple[etree._Element, dict[str, str]]:
    if not content.strip():
        raise InputError(f"{path} is empty, so no URDF")
    reason = ""
    for encoding in ENCODINGS:
        # Entities are worked out within libxml2's bounds; none is read from elsewhere (lxml 5).
        parser = etree.XMLParser(
            recover=True, no_network=True, huge_tree=False,
            remove_comments=True, remove_pis=True, encoding=encoding,
        )  # fmt: skip
        try:
            root: etree._Element | None = etree.fromstring(content, parser)
        except etree.XMLSyntaxError:  # nothing in it at all
            root = None
        errors = list(parser.error_log)
        wrong = next((error for error in errors if error.type not in PASSED), None)
        if root is not None and wrong is None:
            warnings = {
                PASSED[error.type]: f"line {error.line}: {PASSED[error.type]}; passed over"
                for error in reversed(errors)
            }
            if encoding is not None:
                warnings["encoding"] = (
                    f"{path.name} does not say in which encoding it is; read as {encoding}"
                )
            return root, warnings
        if wrong is not None and not reason:
            what = BROKEN.get(wrong.type, "it is broken")
            reason = f"line {wrong.line}, column {wrong.column}: {what}"
    raise InputError(f"{path} is not XML, so no URDF: {reason or 'it is broken'}")


def _local(element: etree._Element) -> str:
    """Its name; with a prefix in it where that is declared nowhere."""
    return str(element.tag).rpartition("}")[2]


def _in_one_line(value: str | None) -> str | None:
    """An attribute without what would break a line or a terminal."""
    return None if value is None else CONTROL.sub(" ", value).strip()


def _is_xacro(element: etree._Element) -> bool:
    return element.prefix == "xacro" or str(element.tag).startswith("xacro:")


class _Reading:
    """What is taken from one description."""

    def __init__(self, path: Path, warnings: dict[str, str]) -> None:
        self.path = path
        self.warnings = warnings  # one of each kind, said of the first
        self.xacro: list[str] = []  # its tags that were left in

    def robot(self, root: etree._Element) -> ElementTree.Element:
        self.xacro = [
            _local(element).removeprefix("xacro:") for element in root.iter() if _is_xacro(element)
        ]
        if any(tag in WRITTEN_FOR_XACRO for tag in self.xacro):
            raise self._unexpanded()
        robot = self._copy(root, "robot")
        name = _in_one_line(root.get("name"))
        if not name:
            self._warn(root, "the robot has no name", "named after its file")
        robot.set("name", name or self.path.stem)
        links = self._named(robot, "link")
        if not links:
            raise self._unexpanded() if self.xacro else InputError(f"{self.path} has no link")
        if len(links) > MAX_LINKS:
            raise InputError(f"{self.path} has over {MAX_LINKS} links")
        self._join(robot, self._named(robot, "joint"), links)
        if self.xacro:
            tags = ", ".join(f"<xacro:{tag}>" for tag in dict.fromkeys(self.xacro[:5]))
            self.warnings["xacro"] = f"what xacro left in was passed over: {tags}"
        return robot

    def _unexpanded(self) -> InputError:
        return InputError(
            f"{self.path} is a xacro file; expand it first: xacro {self.path.name} > expanded.urdf"
        )

    def _warn(self, element: etree._Element, what: str, done: str, kind: str = "") -> None:
        self.warnings.setdefault(kind or what, f"line {element.sourceline}: {what}; {done}")

    # --- elements ---
    def _copy(self, element: etree._Element, tag: str) -> ElementTree.Element:
        """An element with what is taken of it, and of what is in it."""
        copy = ElementTree.Element(tag)
        for name in NAMES.get(tag, ()):
            value = _in_one_line(element.get(name))
            if value is not None:
                if EXPRESSION.search(value):
                    raise self._unexpanded()
                copy.set(name, value)
        for name, count in NUMBERS.get(tag, {}).items():
            self._copy_numbers(element, copy, name, count)
        for child in element:
            kind = _local(child)
            if not child.prefix and kind in CHILDREN.get(tag, ()):
                if kind == "visual":
                    copy.extend(list(self._visual(child)))
                elif tag in ("robot", "link") or copy.find(kind) is None:
                    copy.append(self._copy(child, kind))
        return copy

    def _visual(self, element: etree._Element) -> Iterable[ElementTree.Element]:
        """The visual, or nothing where its shape cannot be shown."""
        visual = self._copy(element, "visual")
        inside = [one for one in element.iterfind("{*}geometry/{*}*") if not one.prefix]
        known = next((one for one in inside if _local(one) in SHAPES), None)
        if known is None:
            names = ", ".join(f"<{_local(one)}>" for one in inside[:3]) or "nothing"
            self._warn(element, f"{names} where a shape should be", "left out")
            return
        tag = _local(known)
        shape = self._copy(known, tag)
        sizes = {name for name in NUMBERS[tag] if name != "scale"}
        needed = {"filename"} if tag == "mesh" else sizes
        lacking = [name for name in sorted(needed) if not shape.get(name)]
        if lacking:
            self._warn(known, f"a {tag} without {' and '.join(lacking)}", "left out")
            return
        if any(float(n) < SMALLEST for name in sizes for n in shape.attrib[name].split()):
            self._warn(known, f"a {tag} of no size", "left out")
            return
        if tag == "capsule":  # yourdfpy keeps the name, which tells `meshes.py`
            self._warn(known, "a capsule, which URDF does not know", "drawn as a rounded cylinder")
            shape.tag, visual.attrib["name"] = "cylinder", "capsule"
        for geometry in visual.iterfind("geometry"):
            geometry.append(shape)
        yield visual

    def _named(self, robot: ElementTree.Element, tag: str) -> dict[str, ElementTree.Element]:
        """The links or joints by name; of two with one name the first."""
        found: dict[str, ElementTree.Element] = {}
        for element in robot.findall(tag):
            name = element.get("name")
            if not name:
                raise self._incomplete(f"a {tag} has no name")
            if name in found:
                self.warnings[f"{tag} {name}"] = (
                    f"there are two {tag}s {name}; the second is left out"
                )
                robot.remove(element)
            found.setdefault(name, element)
        return found

    def _incomplete(self, what: str) -> InputError:
        return InputError(f"{self.path} is no complete URDF: {what}")

    # --- joints ---
    def _join(
        self,
        robot: ElementTree.Element,
        joints: dict[str, ElementTree.Element],
        links: dict[str, ElementTree.Element],
    ) -> None:
        """See to it that every joint has a type that is known and joins links that are there."""
        for name, joint in joints.items():
            kind = joint.get("type", "")
            if kind not in JOINT_TYPES:
                what = f"of the type {kind!r}" if kind else "without a type"
                self.warnings[f"type {kind}"] = f"joint {name} is {what}; it stays still"
                joint.set("type", "fixed")
            axis = [float(n) for one in joint.iterfind("axis") for n in one.get("xyz", "1").split()]
            if joint.get("type") != "fixed" and axis and not any(axis):
                self.warnings["axis"] = f"joint {name} has no axis to move about; it stays still"
                joint.set("type", "fixed")
            for end in ("parent", "child"):
                element = joint.find(end)
                link = element.get("link") if element is not None else None
                if not link:
                    raise self._incomplete(f"joint {name} has no <{end} link=...>")
                if link in links:
                    continue
                if end == "child" or joint.get("type") != "fixed":
                    raise InputError(f"{self.path}, joint {name}: there is no link {link!r}")
                # What a robot is fixed to is often not described: world, map, base.
                self.warnings[f"anchor {link}"] = (
                    f"link {link}, to which joint {name} fixes others, is not described; "
                    "taken as empty"
                )
                links[link] = ElementTree.SubElement(robot, "link", name=link)

    # --- numbers ---
    def _copy_numbers(
        self, element: etree._Element, copy: ElementTree.Element, name: str, count: int
    ) -> None:
        text = _in_one_line(element.get(name))
        if text is None:
            return
        if "${" in text:
            raise self._unexpanded()
        said = f'<{copy.tag} {name}="{text[:40]}">'
        values, exact = read_numbers(text, count)
        if name == "scale" and values is None and (single := read_numbers(text, 1)[0]):
            values, exact = single * 3, False
        limit = copy.tag == "limit"
        if values is None or (not limit and max(map(abs, values)) > LARGEST):
            self._warn(element, f"{said} is not {_count(count)}", "passed over", said)
            return
        shown = " ".join(f"{value:.17g}" for value in values)
        if not exact:
            self._warn(element, said, "read as " + " ".join(f"{value:g}" for value in values))
        if not limit or max(map(abs, values)) <= LARGEST:  # beyond it there is no limit
            copy.set(name, shown)


def read_numbers(text: str, count: int) -> tuple[list[float] | None, bool]:
    """Numbers as people write them, and whether they are exactly what the text says.

    Between them stand spaces or commas. A letter behind one (`1.0f`) is dropped, as by C's strtod;
    a comma is a decimal one where there would be twice as many numbers otherwise; a colour may lack
    its opacity.
    """
    text = re.sub(r"([+-])\s+(?=[\d.])", r"\1", text.replace("\N{MINUS SIGN}", "-"))
    parts = re.split(r"[\s,;]+", text.strip(" \t\r\n,;"))
    whole = True
    if len(parts) == 2 * count and text.count(",") == count:
        parts, whole = text.replace(",", ".").split(), False
    found = [NUMBER.match(part) for part in parts]
    values = [float(one[0]) for one in found if one is not None]
    if len(values) < len(parts):
        return None, False
    whole &= all(one is not None and one.end() == len(one.string) for one in found)
    if count == 4 and len(values) == 3:
        return [*values, 1.0], whole
    if len(values) != count or any(map(math.isnan, values)):
        return None, False
    return values, whole


def _count(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"
