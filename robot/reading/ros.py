"""Joint states as ROS prints them: `rostopic echo` and `ros2 topic echo`, plain, -p and --csv."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.csv_table import CsvTable, Row
from ...core.errors import InputError
from .raw import Array, Raw, raw_array

MAX_BYTES = 4_000_000  # of printed messages; a longer one is better a table
_JOINT_STATE = re.compile(r"^name:", re.M)
_NAME, _POSITION = re.compile(r"(.*\.)?name(\d+)"), re.compile(r"(.*\.)?position(\d+)")
_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", re.ASCII)
_NANO = 1e-9
_FANCY = set("{}&*!|>?@`\t")
MOST_INDENT = 8  # spaces


def is_printed(text: str) -> bool:
    """Whether a text looks like printed joint states."""
    head = text[:20_000]
    return bool(_JOINT_STATE.search(head)) and "position:" in head


def read_printed(text: str, source: str) -> Raw:
    """Messages as YAML, with `---` between them.

    Raises:
        InputError: not such a text.
    """
    if len(text) > MAX_BYTES:
        raise InputError(
            f"{source} is too large to be read as printed messages (at most {MAX_BYTES / 1e6:g} "
            "MB); print them as a table (rostopic echo -p, ros2 topic echo --csv)"
        )
    for number, line in enumerate(text.splitlines(), start=1):
        if not _is_plain(line):
            raise InputError(f"{source}, line {number}: this is no line of a printed joint state")
    import yaml  # for printed messages alone

    try:
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        messages = [one for one in yaml.load_all(text, loader) if one is not None]
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f", line {mark.line + 1}" if mark is not None else ""
        raise InputError(f"{source}{where}: these are no printed joint states") from error
    names: tuple[str, ...] = ()
    times, rows = [], []
    for number, message in enumerate(messages, start=1):
        where = f"{source}, message {number}"
        if not isinstance(message, dict) or not {"name", "position"} <= message.keys():
            raise InputError(f"{where}: it has no name and position")
        held = dict(
            zip(_strings(message["name"], where), _floats(message["position"], where), strict=False)
        )
        names = names or tuple(held)
        if set(names) != set(held):
            raise InputError(f"{where}: it has other joints than the first")
        rows.append([held[name] for name in names])
        times.append(_stamp(message, where))
    if not rows:
        raise InputError(f"{source} has no joint states")
    return _joint_states(source, names, np.array(rows), np.array(times))


def _is_plain(line: str) -> bool:
    """Whether a line is a name, a value or a flat list.

    YAML has ways to make much of little, and nesting that goes deep ends the whole process.
    """
    indent = len(line) - len(line.lstrip(" "))
    item = line.strip(" ").removeprefix("- ")
    flat = item.count("[") == item.count("]") <= 1
    nested = item.startswith(("- ", "-\t")) or item == "-"
    return indent <= MOST_INDENT and flat and not nested and not _FANCY & set(item)


def read_table(table: CsvTable) -> Raw | None:
    """A table that has the names of joints in its cells; None where it is another one.

    Raises:
        InputError: a row of it is not like the first.
    """
    header = table.first.cells
    named = [i for i, cell in enumerate(header) if _NAME.fullmatch(cell)]
    placed = [i for i, cell in enumerate(header) if _POSITION.fullmatch(cell)]
    if named and len(named) == len(placed):
        stamps = [i for i, cell in enumerate(header) if cell.endswith(("header.stamp", "%time"))]
        return _rows(table, list(table), named, placed, stamps[-1:], _NANO)
    run = _names_in(table.first)
    if run is None:
        return None
    first, last = run
    count = last - first
    if len(header) < last + count:
        return None
    rows = [table.first, *table]
    return _rows(
        table, rows, range(first, last), range(last, last + count), [0, 1] if first > 1 else [], 1.0
    )


def _names_in(row: Row) -> tuple[int, int] | None:
    """Where the longest run of words in a row is that numbers come after: [first, last)."""
    words = [bool(re.fullmatch(r"[A-Za-z_]\w*", cell, re.ASCII)) for cell in row.cells]
    best = (0, 0)
    start = None
    for i, word in enumerate([*words, False]):
        if word and start is None:
            start = i
        elif not word and start is not None:
            if i - start > best[1] - best[0]:
                best = (start, i)
            start = None
    first, last = best
    rest = row.cells[last:]
    for begin in (first, first + 1):  # the frame's name stands before those of the joints
        count = last - begin
        numbers = rest[:count]
        whole = count > 1 and len(numbers) == count and len(rest) % count == 0
        if whole and all(_NUMBER.fullmatch(cell) for cell in numbers):
            return begin, last
    return None


def _rows(
    table: CsvTable,
    rows: Sequence[Row],
    named: Sequence[int],
    placed: Sequence[int],
    stamps: Sequence[int],
    unit: float,
) -> Raw:
    if not rows:
        raise InputError(f"{table.source} has a header and no rows")
    names = tuple(rows[0].cells[i] for i in named)
    if "" in names or len(set(names)) < len(names):
        raise InputError(f"{rows[0].where}: its joints are not all different names")
    values, times = [], []
    for row in rows:
        if tuple(row.cells[i] for i in named) != names:
            raise InputError(f"{row.where}: it has other joints than the first row")
        values.append(
            [
                table.number(row.cells[i], f"{row.where}, {name}")
                for i, name in zip(placed, names, strict=True)
            ]
        )
        parts = [table.number(row.cells[i], f"{row.where}, its time") for i in stamps]
        times.append(parts[0] + _NANO * parts[1] if len(parts) == 2 else unit * sum(parts))
    known = np.array(times) if stamps else None
    return _joint_states(table.source, names, np.array(values), known)


def _joint_states(source: str, names: tuple[str, ...], values: Array, times: Array | None) -> Raw:
    return raw_array("ROS joint states", source, names, values, time=times)


def _stamp(message: dict[str, Any], where: str) -> float:
    header = message.get("header")
    stamp = header.get("stamp") if isinstance(header, dict) else None
    if not isinstance(stamp, dict):
        raise InputError(f"{where}: it has no stamp")
    seconds = stamp.get("secs", stamp.get("sec"))
    parts = stamp.get("nsecs", stamp.get("nanosec", 0))
    [whole], [part] = _floats([seconds], where), _floats([parts], where)
    return whole + _NANO * part


def _strings(value: Any, where: str) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise InputError(f"{where}: name is no list of names")
    return value


def _floats(value: Any, where: str) -> list[float]:
    plain = isinstance(value, list) and all(
        isinstance(one, int | float) and not isinstance(one, bool) for one in value
    )
    if not plain:
        raise InputError(f"{where}: there is something else where numbers should be")
    try:
        return [float(one) for one in value]
    except OverflowError as error:
        raise InputError(f"{where}: a number is too large") from error
