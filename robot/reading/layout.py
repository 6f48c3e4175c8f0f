"""What of a file is what: the columns that move joints, and the rows of each motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import InputError
from ..pepper import EYE_COLUMNS
from .columns import Column, columns_of, joint_columns, matched, named_for
from .raw import Raw

Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Layout:
    """joints: (name, column) of each. motions: (name, rows) of each, one without a name where the
    file does not tell several apart. free: the columns that move no joint."""

    joints: tuple[tuple[str, Column], ...]
    motions: tuple[tuple[str, Rows], ...]
    free: tuple[Column, ...]


def layout(raw: Raw, joints: tuple[str, ...] | None, by: str | None = None) -> Layout:
    """
    Args:
        joints: that are looked for; None: all that the file names.
        by: the column that names each row's motion, which must be there.

    Raises:
        InputError: a joint has no column or several, or the column `by` is not there.
    """
    if raw.names is None:
        return _bare(raw, joints)
    columns = columns_of(raw.names)
    motions = [] if by is None else _named(raw, columns, by)
    if joints is not None:
        found = matched(columns, joints, raw.source)
        chosen = list(zip(joints, found, strict=True))
    else:
        chosen = joint_columns(columns, _no_joints(raw, columns), raw.source)
        if not chosen:
            raise InputError(f"{raw.source} names no joints in its header")
    used = {column.index for _, column in chosen}
    free = tuple(column for column in columns if column.index not in used)
    motions = motions or _told_apart(raw, free) or [("", np.arange(raw.length))]
    return Layout(tuple(chosen), tuple(motions), free)


def _bare(raw: Raw, joints: tuple[str, ...] | None) -> Layout:
    """Of a file without a header: one column a joint, in their order."""
    g1 = (
        " (36 columns are a Unitree G1 with its base, as in LAFAN1; add a header with the joints' "
        "names)"
    )
    hint = g1 if raw.width == 36 else ""
    if joints is None:
        raise InputError(f"{raw.source} has no header; expected the names of the joints{hint}")
    if raw.width != len(joints):
        raise InputError(
            f"{raw.source} has no header and {raw.width} columns; without a header there must "
            f"be exactly {len(joints)}{hint}"
        )
    columns = [Column(i, joint, (), "", None) for i, joint in enumerate(joints)]
    chosen = tuple(zip(joints, columns, strict=True))
    return Layout(chosen, (("", np.arange(raw.length)),), ())


def _no_joints(raw: Raw, columns: list[Column]) -> set[int]:
    """Columns that their names or words show to be no joints."""
    none = {column.index for column in columns if column.name in EYE_COLUMNS}
    for what in ("time", "count", "motion"):
        none |= {column.index for column in named_for(columns, what)}
    for column in columns:
        if column.index in none:
            continue
        cells = raw.texts(column.index)
        # A column of words is a label; a joint with a broken cell is a broken file.
        if sum(map(_is_word, cells)) > 0.5 * len(cells):
            none.add(column.index)
    return none


def _is_word(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return True
    return False


def _told_apart(raw: Raw, free: Sequence[Column]) -> list[tuple[str, Rows]]:
    """The rows of each motion, where a column tells several apart."""
    for column in named_for(free, "motion"):
        rows = _rows(raw.texts(column.index))
        if "" not in rows and 1 < len(rows) <= raw.length // 2:
            return [(name, np.array(of)) for name, of in rows.items()]
    return []


def _named(raw: Raw, columns: list[Column], by: str) -> list[tuple[str, Rows]]:
    """The rows of each motion that a column names."""
    column = next((one for one in columns if one.name == by), None)
    if column is None:
        raise InputError(
            f"{raw.source} is not REBL-Pepper's data_raw.csv, it has no column {by}; motions of "
            "one CSV file each go into a folder"
        )
    rows = _rows(raw.texts(column.index))
    if "" in rows:
        raise InputError(f"{raw.where(rows[''][0])}, column {by}: no name of a motion")
    return [(name, np.array(of)) for name, of in rows.items()]


def _rows(cells: list[str]) -> dict[str, list[int]]:
    rows: dict[str, list[int]] = {}
    for i, cell in enumerate(cells):
        rows.setdefault(cell, []).append(i)
    return rows
