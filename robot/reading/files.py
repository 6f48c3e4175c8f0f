"""Which format a file is of, by its beginning and its name's end; and tables."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import PurePosixPath

import numpy as np

from ...core.csv_table import CsvTable
from ...core.errors import InputError
from ...core.motion import MAX_CSV_BYTES, MAX_FRAMES
from . import ros
from .animations import WEBOTS, read_qianim, read_webots
from .columns import columns_of, matched
from .documents import read_json
from .foreign import foreign
from .raw import Array, Raw
from .scripts import read_script

SUFFIXES = (".csv", ".tsv", ".txt", ".json", ".py", ".qianim", ".motion", ".yaml")
MAX_SCRIPT_BYTES = 4_000_000  # the longest motion of Pepper's joints takes 1.2 MB
MOST_ROWS = 20 * MAX_FRAMES  # of a faster recording, or of several motions
_SCRIPTS = (b"\nNAMES = [", b"names.append(", b"names = list()")  # what else would write that?


def raw_of(
    content: bytes, name: str, joints: tuple[str, ...], fps: float, many: bool = False
) -> Raw:
    """What a file holds.

    Args:
        joints: that are looked for, which helps to tell a header.
        fps: frames a second that key frames are played at.
        many: whether it may be as large as a whole data set.

    Raises:
        InputError: no motion, or one of a kind that cannot be read here.
    """
    suffix = PurePosixPath(name).suffix.lower()
    if not content.strip():
        raise InputError(f"{name} is empty; expected a header and one row a frame")
    other = foreign(content)
    if other:
        raise InputError(f"{name} {other}")
    start = content.lstrip(b"\xef\xbb\xbf \t\r\n")
    if content.startswith(WEBOTS.encode()):
        return read_webots(content, name)
    script = suffix == ".py" or any(mark in content[:4000] for mark in _SCRIPTS)
    animation = suffix == ".qianim" or start.startswith((b"<?xml", b"<Animation"))
    if script or animation or suffix == ".json" or re.match(rb'\{\s*"', start):
        if len(content) > MAX_SCRIPT_BYTES:
            limit = f"{MAX_SCRIPT_BYTES / 1e6:g} MB"
            raise InputError(f"{name} is too large; at most {limit} can be read")
        text = _text(content, name)
        if script:
            return read_script(text, name, fps)
        if animation:
            return read_qianim(text, name, fps)
        return read_json(text, name)
    if len(content) > MAX_CSV_BYTES and not many:
        raise InputError(f"{name} is too large; a motion has at most {MAX_CSV_BYTES / 1e6:g} MB")
    if suffix in (".yaml", ".yml", ".txt", "") and ros.is_printed(
        content[:20_000].decode("latin-1")
    ):
        return ros.read_printed(_text(content, name), name)
    return _table(content, name, joints, many)


def _text(content: bytes, name: str) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{name} is no UTF-8 text (byte {error.start})") from error


def _table(content: bytes, name: str, joints: tuple[str, ...], many: bool) -> Raw:
    """A table; a motion a file, or several with a column that tells them apart."""
    table = CsvTable(content, name, joints)
    remarks = () if table.encoding == "UTF-8" else (f"not UTF-8, read as {table.encoding}",)
    states = ros.read_table(table)
    if states is not None:
        return replace(states, remarks=remarks)
    cells = table.first.cells
    header = table.first_is_header(joints) or bool(joints and _names_some(cells, joints))
    rows = [] if header else [table.first]
    most = MOST_ROWS * (100 if many else 1)
    for row in table:
        if len(rows) == most:
            raise InputError(f"{name} has more than {most} rows, too many for a motion")
        rows.append(row)

    def label(column: int) -> str:
        return cells[column] if header else joints[column] if joints else str(column + 1)

    def numbers(column: int) -> Array:
        return np.array(
            [table.number(r.cells[column], f"{r.where}, column {label(column)}") for r in rows]
        )

    return Raw(
        format="CSV",
        source=name,
        names=tuple(cells) if header else None,
        length=len(rows),
        numbers=numbers,
        texts=lambda column: [row.cells[column] for row in rows],
        where=lambda row: rows[row].where,
        width=len(cells),
        remarks=remarks,
    )


def _names_some(cells: list[str], joints: tuple[str, ...]) -> bool:
    try:
        return bool(matched(columns_of(cells), joints[:1], ""))
    except InputError:
        return False
