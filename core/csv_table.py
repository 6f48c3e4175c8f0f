"""Reading CSV files of joint values, whatever program wrote them.

UTF-8 with or without BOM; comma, semicolon or tab; where a comma does not separate, it is a decimal
comma. Messages name the row as an editor counts lines, and the column.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from .errors import InputError

MAX_ANGLE = 4 * math.pi  # no joint turns twice around; more is degrees or rubbish
# A network may overshoot 0 and 1 a little; more is a percentage, degrees or rubbish.
OPENING_RANGE = (-1.0, 2.0)

Unit = Literal["radians", "degrees"]

_MAX_EMPTY_ROWS = 5_000
# No two parts can take the same digits: what is no number shows after one look at each character.
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[-+]?(nan|inf|infinity)", re.IGNORECASE | re.ASCII)


@dataclass(frozen=True)
class Row:
    """Cells without the spaces around them, and where they stand."""

    cells: list[str]
    where: str  # 'walk.csv, row 7'


class CsvTable:
    """The rows of a CSV file; iterating reads on.

    Blank lines, and empty rows at the end, are left out.
    """

    def __init__(self, content: bytes, source: str, names: Sequence[str] = ()) -> None:
        """
        Args:
            source: what to call the file in messages.
            names: of columns that should be there; they help to tell what separates cells.

        Raises:
            InputError: no UTF-8 text, or nothing in it.
        """
        self.source = source
        text = _decode(content, source)
        self._delimiter = _delimiter(text, names)
        self._rows = _rows(text, self._delimiter, source)
        first = next(self._rows, None)
        if first is None:
            raise InputError(f"{source} is empty; expected a header and one row a frame")
        self.first = first

    def __iter__(self) -> Iterator[Row]:
        """The rows after the first.

        Raises:
            InputError: a row is no CSV, or not as wide as the first.
        """
        width = len(self.first.cells)
        for row in self._rows:
            if len(row.cells) != width:
                raise InputError(f"{row.where}: {len(row.cells)} columns, expected {width}")
            yield row

    def first_is_header(self, names: Sequence[str] = ()) -> bool:
        """Whether the first row has all the names, or at least as many words as numbers."""
        cells = [cell for cell in self.first.cells if cell]
        if names and set(names) <= set(cells):
            return True
        numbers = sum(
            bool(_NUMBER.fullmatch(self._point(cell)) or _NOT_FINITE.fullmatch(cell))
            for cell in cells
        )
        return 2 * numbers <= len(cells)

    def columns(self, names: Sequence[str]) -> list[int]:
        """Where the header has these names.

        Raises:
            InputError: one is missing, or there more than once.
        """
        header = self.first.cells
        missing = [name for name in names if name not in header]
        if missing:
            raise InputError(f"{self.source} has no column for {', '.join(missing)}")
        twice = [name for name in names if header.count(name) > 1]
        if twice:
            raise InputError(f"{self.source} has more than one column for {', '.join(twice)}")
        return [header.index(name) for name in names]

    def values(
        self,
        row: Row,
        columns: Sequence[int],
        joints: Sequence[str],
        unit: Unit = "radians",
        openings: Collection[str] = frozenset(),
    ) -> list[float]:
        """One frame: the values of `joints`, which stand in `columns`, in the file's unit.

        Raises:
            InputError: a cell is no number, not finite, or beyond any angle or opening.
        """
        values = []
        for column, joint in zip(columns, joints, strict=True):
            where = f"{row.where}, column {joint}"
            value = self.number(row.cells[column], where)
            fault = implausible(value, None if joint in openings else unit)
            if fault:
                raise InputError(f"{where}: {fault}")
            values.append(value)
        return values

    def number(self, cell: str, where: str) -> float:
        """
        Raises:
            InputError: the cell is no number, or not finite.
        """
        text = self._point(cell)
        value = float(text) if _NUMBER.fullmatch(text) else math.nan
        if not math.isfinite(value):
            raise InputError(f"{where}: {_fault(cell)}")
        return value

    def _point(self, cell: str) -> str:
        """The cell with a decimal point for a decimal comma, where the comma does not separate."""
        return cell if self._delimiter == "," else cell.replace(",", ".", 1)


def implausible(value: float, unit: Unit | None) -> str:
    """Why the value is none of a joint in this unit, None for an opening; "" where it may be."""
    if unit is None:
        low, high = OPENING_RANGE
        return "" if low <= value <= high else f"{value:g} is no plausible opening (from 0 to 1)"
    limit = MAX_ANGLE if unit == "radians" else math.degrees(MAX_ANGLE)
    if abs(value) <= limit:
        return ""
    hint = "; is the file in degrees?" if unit == "radians" else ""
    return f"{value:g} is no plausible angle in {unit} (at most {limit:.4g}){hint}"


def read_csv_bytes(path: Path, limit: int) -> bytes:
    """The content of a file that is to be parsed as CSV.

    Raises:
        InputError: no such file, or larger than `limit` bytes.
    """
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"cannot read {path}: it is no file")
        with path.open("rb") as file:
            content = file.read(limit + 1)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:  # a null character in the name; InputError is one, too
        raise InputError(str(error)) from error
    if len(content) > limit:
        raise InputError(f"{path} is too large; at most {limit / 1e6:g} MB can be read")
    return content


def _decode(content: bytes, source: str) -> str:
    """UTF-8 text with plain newlines, whatever ends its lines."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{source} is no UTF-8 text (byte {error.start}); save it as CSV in UTF-8"
        ) from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _delimiter(text: str, names: Sequence[str]) -> str:
    """The one that brings the names to light, else the first of tab, semicolon, comma in use.

    In that order: where one of the others separates, a comma is a decimal comma.
    """
    first = next((line for line in io.StringIO(text) if line.strip()), "")
    in_use = [delimiter for delimiter in "\t;," if delimiter in first]
    for delimiter in [*in_use, ","] if names else ():  # a lone column may be called ';'
        try:
            cells = {cell.strip() for cell in next(csv.reader([first], delimiter=delimiter))}
        except csv.Error:
            continue
        if cells.issuperset(names):
            return delimiter
    return in_use[0] if in_use else ","


def _rows(text: str, delimiter: str, source: str) -> Iterator[Row]:
    reader = csv.reader(io.StringIO(text), delimiter=delimiter, strict=True)
    empty: list[Row] = []  # rows of nothing but delimiters: left out if nothing follows
    try:
        for cells in reader:
            row = Row([cell.strip() for cell in cells], f"{source}, row {reader.line_num}")
            if any(row.cells):
                yield from empty
                empty.clear()
                yield row
            elif len(cells) > 1 and len(empty) < _MAX_EMPTY_ROWS:
                empty.append(row)
    except csv.Error as error:
        raise InputError(f"{source}, row {reader.line_num}: this is not CSV: {error}") from error


def _fault(cell: str) -> str:
    if not cell:
        return "the cell is empty, expected a number"
    if _NOT_FINITE.fullmatch(cell) or _NUMBER.fullmatch(cell):  # 1e999 is infinity, too
        return f"{cell[:20]} is not finite, expected a number"
    return f"{cell[:20]!r} is no number"
