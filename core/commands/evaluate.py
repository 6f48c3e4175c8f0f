"""`rnnpb evaluate`: the tables of the paper for any checkpoints."""

from __future__ import annotations

import argparse
from typing import Any

from rich.table import Table

from ..errors import InputError
from ..files import check_writable
from .command import Command, add_data, add_device, add_seed, load_model, whole
from .progress import steps_bar
from .tables import print_table, write_json

TASKS = ("reconstruction",)
Row = dict[str, Any]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ckpt",
        required=True,
        nargs="+",
        action="extend",
        metavar="C",
        help="checkpoint files or names of shipped ones",
    )
    add_data(parser, required=True)
    parser.add_argument(
        "--task", type=_tasks, default=TASKS, metavar="T,..", help=f"of {', '.join(TASKS)}"
    )
    parser.add_argument(
        "--samples", type=whole(1, 10_000), default=100, help="PBs a motion; default: 100"
    )
    add_seed(parser)
    add_device(parser)
    parser.add_argument("--json", metavar="F", help="write the tables to F, too")


def _tasks(text: str) -> tuple[str, ...]:
    tasks = tuple(dict.fromkeys(text.split(",")))
    if "recognition" in tasks and "recognition" not in TASKS:
        raise argparse.ArgumentTypeError("recognition cannot be evaluated yet; reconstruction can")
    unknown = [task for task in tasks if task not in TASKS]
    if unknown:
        raise argparse.ArgumentTypeError(f"no task {unknown[0]!r}; there are: {', '.join(TASKS)}")
    return tasks


def run(arguments: argparse.Namespace) -> None:
    if arguments.json is not None:
        check_writable(arguments.json)
    rows = steps_bar(
        (_reconstruction(checkpoint, arguments) for checkpoint in arguments.ckpt),
        len(arguments.ckpt),
        "reconstruction",
    )
    tables = {"reconstruction": list(rows)}
    _print_reconstruction(tables["reconstruction"])
    if arguments.json is not None:
        write_json(arguments.json, tables)


def _reconstruction(checkpoint: str, arguments: argparse.Namespace) -> Row:
    """One cell of Table I, measured."""
    from ..device import choose_device
    from ..evaluation import reconstruction, reconstruction_at_mean

    model, dataset = load_model(checkpoint, arguments.data)
    if dataset is None:
        raise InputError("reconstruction needs --data")
    model.to(choose_device(arguments.device))
    mean, sd = reconstruction(model, dataset.motions, arguments.samples, seed=arguments.seed)
    at_mean = reconstruction_at_mean(model, dataset.motions)
    return {
        "checkpoint": checkpoint,
        "behavior": model.config.behavior,
        "beta": model.config.beta,
        "pb_dim": model.config.pb_dim,
        "mean": mean,
        "sd": sd,
        "at_sigma_0": float(at_mean.mean()),
        "motions": len(dataset.motions),
        "samples": arguments.samples,
        "seed": arguments.seed,
    }


def _print_reconstruction(rows: list[Row]) -> None:
    first = rows[0]
    table = Table(
        title="Reconstruction loss (Table I): mean (sd) of the squared error over frames and "
        f"joints, {first['motions']} motions x {first['samples']} samples"
    )
    for name in ("checkpoint", "behavior", "beta", "D_PB", "sampled", "at sigma = 0"):
        table.add_column(name, justify="left" if name in ("checkpoint", "behavior") else "right")
    for row in rows:
        table.add_row(
            row["checkpoint"],
            row["behavior"],
            "-" if row["beta"] is None else f"{row['beta']:g}",
            str(row["pb_dim"]),
            f"{row['mean']:.6f} ({row['sd']:.6f})",
            f"{row['at_sigma_0']:.6f}",
        )
    print_table(table)


COMMAND = Command("evaluate", "Measure checkpoints as the paper does.", add_arguments, run)
