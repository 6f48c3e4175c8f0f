"""Pepper's own animation files (.qianim), and Webots' motions (.motion)."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np

from ...core.csv_table import CsvTable
from ...core.errors import InputError
from .keyframes import Key, played
from .raw import Raw, Unit, raw_array

WEBOTS = "#WEBOTS_MOTION"
_CLOCK = re.compile(r"(\d+):(\d+):(\d+)", re.ASCII)
_UNITS: dict[str, Unit | None] = {
    "degree": "degrees",
    "degrees": "degrees",
    "radian": "radians",
    "radians": "radians",
    "dimensionless": None,
}


def read_qianim(text: str, source: str, fps: float) -> Raw:
    """Key frames per actuator, in a unit of their own each.

    Args:
        fps: frames a second that they are turned into.

    Raises:
        InputError: not such a file.
    """
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(f"{source} defines entities, which an animation has no use for")
    try:
        root = ElementTree.fromstring(text.encode())
    except ElementTree.ParseError as error:
        line, column = error.position
        raise InputError(f"{source}, line {line}, column {column + 1}: this is not XML") from error
    curves: dict[str, list[Key]] = {}
    units: list[Unit | None] = []
    for curve in root.iter("ActuatorCurve"):
        joint = curve.get("actuator", "")
        if not joint or joint in curves:
            raise InputError(f"{source}: its actuators are not all different names")
        if curve.get("mute") == "true":
            continue
        unit = curve.get("unit", "degree")
        if unit not in _UNITS:
            raise InputError(f"{source}, {joint}: {unit[:20]!r} is no unit of an angle")
        units.append(_UNITS[unit])
        rate = _number(curve, "fps", f"{source}, {joint}", "25")
        if rate <= 0:
            raise InputError(f"{source}, {joint}: {rate:g} frames a second is no rate")
        curves[joint] = [_key(key, rate, f"{source}, {joint}") for key in curve.iter("Key")]
    if not curves:
        raise InputError(f"{source} has no actuator curves; is it an animation of Pepper?")
    names, values = played(dict(curves), fps, source)
    return raw_array(
        "Pepper animation", source, names, values, fps=fps, units=tuple(units),
        remarks=(f"key frames, played at {fps:g} Hz",),
    )  # fmt: skip


def _key(key: ElementTree.Element, rate: float, where: str) -> Key:
    handles = {"left": None, "right": None}
    for tangent in key.iter("Tangent"):
        side = tangent.get("side", "")
        if side in handles and "bezier" in tangent.get("interpType", "").lower():
            handles[side] = (  # type: ignore[assignment]
                _number(tangent, "abscissaParam", where, "0") / rate,
                _number(tangent, "ordinateParam", where, "0"),
            )
    time = _number(key, "frame", where) / rate
    return Key(time, _number(key, "value", where), handles["left"], handles["right"])


def _number(element: ElementTree.Element, name: str, where: str, otherwise: str = "") -> float:
    text = element.get(name, otherwise)
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{where}: {name} is {text[:20]!r}, which is no number")
    return value


def read_webots(content: bytes, source: str) -> Raw:
    """A pose a row, each with its time.

    Raises:
        InputError: not such a file.
    """
    head, _, body = content.partition(b"\n")
    names = head.decode("latin-1").strip().split(",")[2:]
    header = ",".join(["time", "pose", *names]).encode("latin-1")
    table = CsvTable(header + b"\n" + body, source)
    times, rows = [], []
    for row in table:
        clock = _CLOCK.fullmatch(row.cells[0])
        if clock is None:
            raise InputError(f"{row.where}: {row.cells[0][:20]!r} is no time like 00:01:040")
        minutes, seconds, thousandths = map(float, clock.groups())
        times.append(60 * minutes + seconds + thousandths / 1000)
        rows.append(
            [
                table.number(cell, f"{row.where}, column {name}")
                for cell, name in zip(row.cells[2:], names, strict=True)
            ]
        )
    if not rows or not names:
        raise InputError(f"{source} has no poses")
    return raw_array(
        "Webots motion", source, tuple(name.strip() for name in names), np.array(rows),
        time=np.array(times),
    )  # fmt: skip
