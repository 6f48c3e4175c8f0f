"""`rnnpb sweep`: Table I, one model after the other or on a whole cluster."""

from __future__ import annotations

import argparse
import math
import shutil
import signal
import sys
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import TypeVar

from ...core.errors import InputError
from ...core.files import check_writable
from ...core.paper.sweep import CONDITIONS, PB_DIMS, Attempt, Cell, Result, Sweep, attempt, grid
from ...core.paper.sweep_table import table
from .command import Command, add_data, add_device, note, whole
from .parallel import BACKENDS, parallel_backend
from .progress import progress_bar
from .tables import print_table, sweep_table, write_json

Item = TypeVar("Item")
MAX_SEEDS = 1000
GPU_JOBS = 4  # each takes memory of the GPU for itself before it computes anything


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_data(parser, required=True)
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="keeps a small file of each finished cell"
    )
    parser.add_argument(
        "--pb-dims",
        type=_several(whole(1, 128)),
        default=PB_DIMS,
        metavar="D,..",
        help="default: those of the paper, " + ",".join(map(str, PB_DIMS)),
    )
    parser.add_argument(
        "--conditions",
        type=_several(_condition),
        default=tuple(CONDITIONS),
        metavar="C,..",
        help="default: " + ",".join(CONDITIONS),
    )
    parser.add_argument(
        "--seeds",
        type=_seeds,
        default=(0,),
        metavar="N | S,..",
        help="how many (0 to N - 1), or which ones (a list; 7, is seed 7 alone); default: 1",
    )
    parser.add_argument(
        "--epochs", type=whole(1, 10_000_000), metavar="N", help="default: the recipe's own"
    )
    parser.add_argument(
        "--hidden-size", type=whole(1, 4096), default=256, help="LSTM units; default: 256"
    )
    parser.add_argument(
        "--samples", type=whole(1, 10_000), default=100, help="PBs a motion; default: 100"
    )
    parser.add_argument(
        "--jobs",
        type=whole(1, 10_000),
        metavar="N",
        help=f"cells at a time, one thread each; default: one for each core, {GPU_JOBS} on a GPU",
    )
    parser.add_argument("--backend", choices=BACKENDS, default="loky", help="default: loky")
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of a running Dask or Ray cluster; default: one on this machine, for this sweep",
    )
    add_device(parser)
    parser.add_argument(
        "--keep-checkpoints", action="store_true", help="keep each trained model in DIR, too"
    )
    parser.add_argument(
        "--collect", action="store_true", help="only print what is finished; train nothing"
    )
    parser.add_argument("--json", metavar="F", help="write the table and its cells to F, too")


def _several(parse_one: Callable[[str], Item]) -> Callable[[str], tuple[Item, ...]]:
    """The type of a flag that takes a list; what is named twice counts once."""

    def parse(text: str) -> tuple[Item, ...]:
        return tuple(dict.fromkeys(parse_one(part) for part in text.split(",")))

    return parse


def _condition(text: str) -> str:
    if text not in CONDITIONS:
        raise argparse.ArgumentTypeError(
            f"no condition {text[:40]!r}; there are: {', '.join(CONDITIONS)}"
        )
    return text


def _seeds(text: str) -> tuple[int, ...]:
    if "," in text:
        return _several(whole(0, 2**32 - 1))(text.removesuffix(","))
    return tuple(range(whole(1, MAX_SEEDS)(text)))


@dataclass
class _SoFar:
    """What has become of the cells; filled as they come in."""

    cells: Sequence[Cell]
    results: dict[Cell, Result]
    failures: dict[Cell, str] = field(default_factory=dict)

    @property
    def missing(self) -> list[Cell]:
        return [cell for cell in self.cells if cell not in self.results]


def run(arguments: argparse.Namespace) -> None:
    _check_flags(arguments)
    from ...robot.data import load_dataset

    cells = grid(arguments.conditions, arguments.pb_dims, arguments.seeds)
    sweep = Sweep(
        dataset=load_dataset(arguments.data),
        folder=_folder(arguments.out),
        epochs=arguments.epochs,
        hidden_size=arguments.hidden_size,
        samples=arguments.samples,
        device=arguments.device,
        keep_checkpoints=arguments.keep_checkpoints,
    )
    # Every file is looked at before the first cell is run: a folder of another sweep shows at once.
    so_far = _SoFar(cells, {cell: found for cell in cells if (found := sweep.finished(cell))})
    before = len(so_far.results)
    if so_far.missing and not arguments.collect:
        _run_missing(sweep, so_far, arguments)
    _report(sweep, so_far, arguments)
    print(
        f"{len(cells)} cells: {len(so_far.results) - before} run now, {before} finished before, "
        f"{len(so_far.missing)} missing; kept in {arguments.out}"
    )
    if so_far.failures:
        raise InputError(
            f"{len(so_far.failures)} of {len(cells)} cells failed; "
            "the same command tries them again"
        )


def _check_flags(arguments: argparse.Namespace) -> None:
    """What argparse cannot see: flags that do not go together, files that cannot be written."""
    if arguments.scheduler is not None and arguments.backend == "loky":
        raise InputError("--scheduler: loky has none; --backend dask or ray goes with it")
    if arguments.scheduler is not None and arguments.backend == "dask" and arguments.jobs:
        raise InputError("--jobs: a Dask cluster has the workers that it has; leave the flag out")
    if arguments.json is not None:
        check_writable(arguments.json)


def _folder(out: str) -> Path:
    """The folder of the cells, made where it is not there yet."""
    path = Path(out).absolute()
    try:
        path.mkdir(exist_ok=True)
    except FileExistsError as error:
        raise InputError(f"--out {out}: it is a file; give the name of a folder") from error
    except OSError as error:
        raise InputError(f"--out {out}: cannot make this folder: {error.strerror}") from error
    check_writable(path / "cell.json")
    return path


def _run_missing(sweep: Sweep, so_far: _SoFar, arguments: argparse.Namespace) -> None:
    cells, results, failures = so_far.cells, so_far.results, so_far.failures
    try:
        with (
            _sigterm_interrupts(),
            progress_bar("{task.fields[failed]}") as bar,
            closing(_attempts(sweep, so_far.missing, arguments)) as attempts,
        ):
            task = bar.add_task("cells", total=len(cells), completed=len(results), failed="")
            for done in attempts:
                if done.result is None:
                    failures[done.cell] = done.failure
                    note(f"{done.cell.name} failed: {_one_line(done.failure)}")
                    bar.update(task, failed=f"{len(failures)} failed")
                    continue
                if sweep.finished(done.cell) is None:  # the worker does not see this folder
                    sweep.save(done.cell, done.result, done.model)
                results[done.cell] = done.result
                bar.advance(task)
    except KeyboardInterrupt:
        kept = sum(sweep.finished(cell) is not None for cell in cells)
        raise KeyboardInterrupt(
            f"stopped; {kept} of {len(cells)} cells are finished and kept in {arguments.out}; "
            "to go on: the same command again"
        ) from None


def _attempts(
    sweep: Sweep, cells: Sequence[Cell], arguments: argparse.Namespace
) -> Generator[Attempt]:
    """What becomes of the cells, in the order in which they finish."""
    import joblib

    from ...core.device import choose_device

    ready = partial(choose_device, arguments.device)
    jobs = arguments.jobs
    if jobs is None and arguments.scheduler is None and ready().type == "cuda":
        jobs = GPU_JOBS
    with parallel_backend(arguments.backend, arguments.scheduler, jobs, ready):
        # Ray's backend for joblib hands results on at the end only; workers write their cells.
        way = "list" if arguments.backend == "ray" else "generator_unordered"
        parallel = joblib.Parallel(n_jobs=jobs or -1, batch_size=1, return_as=way)
        try:
            # After an interruption joblib would warn that not all its results were taken.
            warnings.filterwarnings("ignore", module="joblib")
            yield from parallel(joblib.delayed(attempt)(sweep, cell) for cell in cells)
        except InputError:
            raise
        except Exception as error:
            # `attempt` lets no cell raise: it is the backend that failed, a worker that was killed.
            raise InputError(
                f"--backend {arguments.backend} failed, {type(error).__name__}: {error}; finished "
                "cells are kept, the same command goes on"
            ) from error


@contextmanager
def _sigterm_interrupts() -> Iterator[None]:
    """SIGTERM ends a sweep as Ctrl-C does, workers included."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _report(sweep: Sweep, so_far: _SoFar, arguments: argparse.Namespace) -> None:
    """Print Table I, and write it where it is asked for."""
    cells, results, failures = so_far.cells, so_far.results, so_far.failures
    entries = table(cells, results, failures)
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else math.inf
    motions = len(sweep.dataset.motions)
    print_table(sweep_table(entries, len(arguments.seeds), motions, sweep.samples, width))
    if arguments.json is None:
        return
    rows = []
    for cell in cells:
        state = "finished" if cell in results else "failed" if cell in failures else "missing"
        measured = asdict(results[cell]) if cell in results else {}
        reason = {"failure": failures[cell]} if cell in failures else {}
        epochs = {"epochs": sweep.configs(cell)[1].epochs}
        rows.append(asdict(cell) | {"state": state} | epochs | measured | reason)
    facts = {
        "motions": motions,
        "samples": sweep.samples,
        "hidden_size": sweep.hidden_size,
        "data_sha256": sweep.dataset.sha256,
    }
    write_json(arguments.json, facts | {"table": [asdict(e) for e in entries], "cells": rows})


COMMAND = Command("sweep", "Train and measure every model of Table I.", add_arguments, run)
