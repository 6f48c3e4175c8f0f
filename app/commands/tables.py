"""Tables of results: for people on stdout, for programs as JSON."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from ...core.files import replacing
from ...core.paper.sweep_table import Entry

Row = dict[str, Any]  # of a table, as JSON has it
PIPE_WIDTH = 140  # columns where stdout is no terminal
FIRST_WIDTH, ENTRY_WIDTH = 17, 13  # of the columns of a sweep's table, borders included


def print_table(table: Table) -> None:
    """Print the table; whoever closes the pipe is met as for every other output."""
    console = Console(width=None if sys.stdout.isatty() else PIPE_WIDTH)
    with console.capture() as text:
        console.print(table)
    print(text.get(), end="")


def write_json(path: str | os.PathLike[str], value: Any) -> None:
    """Write JSON; an existing file is replaced whole or not at all."""
    text = json.dumps(_plain(value), ensure_ascii=False, indent=2, allow_nan=False)
    with replacing(path) as beside:
        beside.write_text(text + "\n", encoding="utf-8")


def _plain(value: Any) -> Any:
    """The same with null for what is no number: JSON has no other word for it."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def reconstruction_table(rows: Sequence[Row]) -> Table:
    """Table I for these checkpoints."""
    first = rows[0]
    table = _table(
        "Reconstruction loss (Table I): mean (sd) of the squared error, averaged over frames and "
        f"joints, of {first['motions']} motions x {first['samples']} samples",
        ("sampled", "at sigma = 0"),
    )
    for row in rows:
        table.add_row(*_facts(row), _spread(row), f"{row['at_sigma_0']:.6f}")
    return table


def recognition_tables(rows: Sequence[Row]) -> list[Table]:
    """Table II for these checkpoints: reconstruction loss, then prediction error.

    A search by Levenberg-Marquardt is one run, which stands in all three columns.
    """
    first = rows[0]
    trials = first["trials"]
    kind = "novel patterns" if first["draws"] else "given motions"
    runs = f"{first['patterns']} {kind} x {trials} trials"
    columns = ("last iterate", "best iterate", f"best of {trials} trials")
    tables = []
    for name, more in (("reconstruction_loss", "explained"), ("prediction_error", "s a motion")):
        title = name.replace("_", " ").capitalize()
        table = _table(f"{title} of {runs} (Table II): mean (sd)", ("warm start", *columns, more))
        for row in rows:
            spreads = (row[name][way] for way in ("last_iterate", "best_iterate", "best_of_trials"))
            last = f"{row['explained']['mean']:.0%}"
            if more != "explained":
                last = f"{row['seconds']:.2f}"
            table.add_row(*_facts(row), row["warm_start"], *map(_spread, spreads), last)
        tables.append(table)
    return tables


def structure_table(rows: Sequence[Row]) -> Table:
    """The latent spaces of these checkpoints, one beside the other."""
    table = _table(
        "Latent space: standard deviation of the learned mu, mean sigma, and landscapes of every "
        "third motion, mean / area / roughness",
        ("sd of mu", "sigma", "window ±1", "window ±0.7 sd"),
    )
    for row in rows:
        windows = (row["landscapes"][window] for window in ("absolute", "sd"))
        table.add_row(
            *_facts(row),
            f"{row['mu_sd']:.2f}",
            f"{row['sigma']:.3f}",
            *(f"{w['mean']:.3f} / {w['area']:.3f} / {w['roughness']:.4f}" for w in windows),
        )
    return table


def hidden_table(rows: Sequence[Row]) -> Table:
    """What these checkpoints make of joints that are not observed."""
    first = rows[0]
    table = _table(
        f"Error of {first['motions']} training motions where {len(first['joints'])} joints are "
        "observed: mean / median",
        ("observed joints", "hidden joints", "the same, observed"),
    )
    for row in rows:
        pairs = (row[name] for name in ("seen", "hidden", "hidden_if_seen"))
        table.add_row(*_facts(row), *(f"{mean:.6f} / {median:.6f}" for mean, median in pairs))
    return table


def smoothness_table(rows: Sequence[Row], pairs: int) -> Table:
    """How smooth models are, a model a column."""
    of = f"{pairs} pairs of motions: median (mean, sd)" if pairs > 1 else "one pair of motions"
    table = Table(title=f"Smoothness over {of}")
    table.add_column("")
    for row in rows:
        table.add_column(_facts(row)[0], justify="right")
    lines = [("sd of the learned mu", [f"{row['mu_sd']:.2f}" for row in rows])]
    for window, label in (("absolute", "±1"), ("sd", "±0.7 sd")):
        for name in ("mean", "area", "roughness"):
            values = [row["landscapes"][window][name] for row in rows]
            lines.append((f"landscape {label}: {name}", [_middle(one, pairs) for one in values]))
    for name, label in (
        ("stretch", "stretch at mu, ° a unit"),
        ("stretch_per_sd", "stretch at mu, ° a sd"),
        ("stretch_between", "stretch half-way, ° a unit"),
        ("stretch_between_per_sd", "stretch half-way, ° a sd"),
        ("condition", "condition at mu"),
        ("wander", "wander"),
        ("cliff", "cliff"),
        ("detour", "detour"),
        ("jerk", "jerk half-way"),
    ):
        lines.append((label, [_middle(row[name], pairs) for row in rows]))
    for label, cells in lines:
        table.add_row(label, *cells)
    return table


def _middle(values: Row, pairs: int) -> str:
    if pairs == 1:
        return f"{values['mean']:.3g}"
    return f"{values['median']:.3g} ({values['mean']:.3g}, {values['sd']:.2g})"


def sweep_table(
    entries: Sequence[Entry], seeds: int, motions: int, samples: int, width: float = math.inf
) -> Table:
    """Table I of a sweep: conditions down, D_PB across; turned where that is too wide."""
    over = f"mean over {seeds} seeds (sd over seeds)" if seeds > 1 else "mean (sd)"
    made = Table(
        title=f"Reconstruction loss (Table I): {over} of the squared error, averaged over frames "
        f"and joints, of {motions} motions x {samples} samples",
        show_lines=True,
    )
    words = {(entry.condition, str(entry.pb_dim)): _entry(entry, seeds) for entry in entries}
    rows, columns = (list(dict.fromkeys(names)) for names in zip(*words, strict=True))
    first = "D_PB"
    if FIRST_WIDTH + len(columns) * ENTRY_WIDTH > width:
        words = {(pb_dim, condition): text for (condition, pb_dim), text in words.items()}
        rows, columns = columns, rows
    for name in (first, *columns):
        made.add_column(name, justify="left" if name is first else "right")
    for row in rows:
        made.add_row(row, *(words[row, column] for column in columns))
    return made


def _entry(entry: Entry, seeds: int) -> str:
    """An entry as the table shows it: several lines keep its column narrow."""
    if entry.mean is None:
        return "failed" if entry.failed else "missing"
    if seeds == 1:
        return f"{entry.mean:.6f}\n({entry.sd:.6f})"
    sd = "-" if entry.sd_over_seeds is None else f"{entry.sd_over_seeds:.6f}"
    absent = "" if len(entry.finished) == seeds else f"\n{len(entry.finished)} of {seeds} seeds"
    return f"{entry.mean:.6f}\n({sd}){absent}"


def _table(title: str, columns: Sequence[str]) -> Table:
    table = Table(title=title)
    for name in ("checkpoint", "behavior", "beta", "D_PB", *columns):
        words = name in ("checkpoint", "behavior", "warm start")
        table.add_column(name, justify="left" if words else "right")
    return table


def _facts(row: Row) -> tuple[str, ...]:
    beta = "-" if row["beta"] is None else f"{row['beta']:g}"
    name = "/".join(Path(row["checkpoint"]).parts[-2:])  # every published one is a model.tar
    return name, row["behavior"], beta, str(row["pb_dim"])


def _spread(values: Row) -> str:
    return f"{values['mean']:.6f} ({values['sd']:.6f})"
