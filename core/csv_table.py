"""Reading CSV files of joint values, whatever program wrote them.

UTF-8, UTF-16 with a byte order mark, or else Latin 1; comma, semicolon, tab or spaces; where a
comma does not separate, it is a decimal comma. Comments (#), a first line `sep=;` and separators at
a row's end are passed over; a header may be the last comment before the data. Messages name the row
as an editor counts lines, and the column.
"""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from .errors import InputError

_MAX_EMPTY_ROWS = 5_000
_CONTROL = [chr(i) for i in range(32) if chr(i) not in "\t\n\r\f\v"]
_LINE = re.compile(r"^.*\S.*$", re.M)
_COMMENT = re.compile(r"^[ \t]*#.*$", re.M)
_DATA = re.compile(r"^(?![ \t]*#).*\S.*$", re.M)
_SEPARATOR_LINE = re.compile(r"sep=(.)", re.IGNORECASE)
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
            InputError: no text, or nothing in it.
        """
        self.source = source
        text, self.encoding = _decode(content, source)
        text, told = _without_separator_line(text)
        text = _without_comments(text, names)
        self._delimiter = told or _delimiter(text, names)
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
            cells = row.cells
            if len(cells) > width and not any(cells[width:]):
                row = Row(cells[:width], row.where)
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


def _decode(content: bytes, source: str) -> tuple[str, str]:
    """Text with plain newlines, whatever ends its lines, and its encoding in words."""
    encoding, words = "utf-8-sig", "UTF-8"
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding, words = "utf-16", "UTF-16"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        # Names of joints and numbers are ASCII; what else is in the file need not be readable.
        text, words = content.decode("latin-1"), "Latin 1"
    if "\0" in text or sum(map(text[:4000].count, _CONTROL)) > 8:
        raise InputError(f"{source} is no text; save it as CSV in UTF-8")
    return text.replace("\r\n", "\n").replace("\r", "\n"), words


def _without_separator_line(text: str) -> tuple[str, str]:
    """What a first line for a spreadsheet says separates the cells; it is left blank."""
    first, _, rest = text.partition("\n")
    found = _SEPARATOR_LINE.fullmatch(first.strip())
    return ("\n" + rest, found[1]) if found else (text, "")


def _without_comments(text: str, names: Sequence[str]) -> str:
    """Comments left blank, so that rows keep their numbers; a header among them stays."""
    if "#" not in text:
        return text
    top, data = _LINE.search(text), _DATA.search(text)
    kept, header = None, ""
    if top is not None and _holds(top[0], names):  # a header, whatever it begins with
        kept, header = top, top[0]
    elif data is not None:
        kept = max(_COMMENT.finditer(text, 0, data.start()), key=re.Match.start, default=None)
        header = "" if kept is None else kept[0].lstrip().removeprefix("#").lstrip()
        if not _is_header(header, data[0], names):
            kept = None
    if kept is None:
        return _COMMENT.sub("", text)
    before, after = text[: kept.start()], text[kept.end() :]
    return _COMMENT.sub("", before) + header + _COMMENT.sub("", after)


def _holds(line: str, names: Sequence[str]) -> bool:
    """Whether all names are cells of a line as it stands, be they as odd as a comment's sign."""
    return bool(names) and any(
        set(names) <= {cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])}
        for delimiter in "\t;,"
    )


def _is_header(line: str, data: str, names: Sequence[str]) -> bool:
    """Whether a comment names the columns of the row of data after it."""
    delimiter = _delimiter(line, names)
    cells, values = (next(csv.reader([one], delimiter=delimiter), []) for one in (line, data))
    words = [cell for cell in cells if cell.strip() and not _NUMBER.fullmatch(cell.strip())]
    numbers = [value for value in values if _NUMBER.fullmatch(value.strip().replace(",", "."))]
    return (
        len(cells) > 1
        and len(cells) == len(values) == len(numbers)
        and len(words) > 0.5 * len(cells)
    )


def _delimiter(text: str, names: Sequence[str]) -> str:
    """The one that brings the names to light, else the first in use of all.

    Tab, semicolon, comma, space, in that order: where one of the others separates, a comma is a
    decimal comma.
    """
    first = next((line for line in io.StringIO(text) if line.strip()), "").strip(" \n")
    in_use = [delimiter for delimiter in "\t;, " if delimiter in first]
    for delimiter in [*in_use, ","] if names else ():  # a lone column may be called ';'
        try:
            cells = {cell.strip() for cell in next(csv.reader([first], delimiter=delimiter))}
        except csv.Error:
            continue
        if cells.issuperset(names):
            return delimiter
    return in_use[0] if in_use else ","


def _rows(text: str, delimiter: str, source: str) -> Iterator[Row]:
    reader = csv.reader(
        io.StringIO(text), delimiter=delimiter, skipinitialspace=delimiter == " ", strict=True
    )
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
