"""Lists and numbers out of a Python script's text.

The script is never run, nor is it parsed as Python: a small file can cost that parser gigabytes.
"""

from __future__ import annotations

import json
import re
from typing import Any

MAX_DEPTH = 8
_START = re.compile(r"^[ \t]*([A-Za-z_]\w*)[ \t]*(\.append\(|=)[ \t]*(?=[\[\(\"'\d.+-])", re.M)
_TOKEN = re.compile(
    r"""\s+|\#[^\n]*|[\[\](),]|"[^"\n\\]*"|'[^'\n\\]*'|[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?""",
    re.ASCII,
)


def assigned(text: str) -> dict[str, Any]:
    """What names stand for: numbers, strings, and lists of them; all else is passed over.

    The last `name = value` counts, or else all that `name.append(value)` puts together.
    """
    values: dict[str, Any] = {}
    appended: dict[str, list[Any]] = {}
    for found in _START.finditer(text):
        value = _literal(text, found.end())
        if value is None:
            continue
        if found[2] == "=":
            values[found[1]] = value
        else:
            appended.setdefault(found[1], []).append(value)
    return values | appended


def _literal(text: str, at: int) -> Any:
    """The value that begins there; None where none does."""
    written: list[str] = []
    depth = 0
    while True:
        token = _TOKEN.match(text, at)
        if token is None:
            return None
        at, piece = token.end(), token[0]
        if piece[0].isspace() or piece[0] == "#":
            continue
        if piece in ("[", "("):
            depth += 1
            piece = "["
        elif piece in ("]", ")"):
            depth -= 1
            piece = "]"
            if written and written[-1] == ",":
                written.pop()
        elif piece[0] in "'\"":
            piece = json.dumps(piece[1:-1])
        elif piece != ",":
            piece = repr(float(piece))
        if depth > MAX_DEPTH:
            return None
        written.append(piece)
        if depth <= 0:
            break
    try:
        return json.loads("".join(written))
    except ValueError:
        return None
