"""Tables of results: for people on stdout, for programs as JSON."""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from rich.console import Console
from rich.table import Table

from ..files import replacing

PIPE_WIDTH = 140  # columns where stdout is no terminal


def print_table(table: Table) -> None:
    """Print the table; whoever closes the pipe is met as for every other output."""
    console = Console(width=None if sys.stdout.isatty() else PIPE_WIDTH)
    with console.capture() as text:
        console.print(table)
    print(text.get(), end="")


def write_json(path: str | os.PathLike[str], value: Any) -> None:
    """Write JSON; an existing file is replaced whole or not at all."""
    text = json.dumps(value, ensure_ascii=False, indent=2, allow_nan=False)
    with replacing(path) as beside:
        beside.write_text(text + "\n", encoding="utf-8")
