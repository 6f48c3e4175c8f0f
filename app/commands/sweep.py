"""`rnnpb sweep`: Table I, one model after the other or on a whole cluster."""

from __future__ import annotations

import math
import shutil
import signal
import sys
import warnings
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated

from ...core.errors import InputError
from ...core.files import check_writable
from ...core.paper.sweep import CONDITIONS, PB_DIMS, Attempt, Cell, Result, Sweep, attempt, grid
from ...core.paper.sweep_table import table
from .flags import FLAGS, SEEDS, Data, DeviceName, FileFlags, note, one_of, read_by, several, whole
from .parallel import Backend, parallel_backend
from .progress import progress_bar
from .tables import print_table, sweep_table, write_json

MAX_SEEDS = 1000
GPU_JOBS = 4  # each takes memory of the GPU for itself before it computes anything


def _seeds(text: str) -> tuple[int, ...]:
    if "," in text:
        return several(SEEDS)(text.removesuffix(","))
    return tuple(range(whole(1, MAX_SEEDS)(text)))


@FLAGS
@dataclass(frozen=True, kw_only=True)
class Flags:
    """Which cells, of which size, and where they are run and kept.

    Args:
        out: a folder that keeps a small file of each finished cell
        pb_dims: dimensions of the PB
        conditions: priors
        seeds: how many (0 to N - 1), or which ones (a list; 7, is seed 7 alone)
        epochs: default: the recipe's own
        hidden_size: LSTM units
        samples: PBs a motion
        jobs: cells at a time, one thread each; default: one for each core, a few on a GPU
        backend: where the cells are run
        scheduler: address of a running Dask or Ray cluster; default: one on this machine, for this
            sweep
        keep_checkpoints: keep each trained model, too
        collect: only print what is finished; train nothing
        json: write the table and its cells to this file, too
    """

    data: Data
    out: str
    pb_dims: Annotated[tuple[int, ...], read_by(several(whole(1, 128)), "D,..")] = PB_DIMS
    conditions: Annotated[
        tuple[str, ...],
        read_by(several(one_of("condition", tuple(CONDITIONS))), "C,.."),
    ] = tuple(CONDITIONS)
    seeds: Annotated[tuple[int, ...], read_by(_seeds, "N|S,..", shown="1")] = (0,)
    epochs: Annotated[int | None, read_by(whole(1, 10_000_000))] = None
    hidden_size: Annotated[int, read_by(whole(1, 4096))] = 256
    samples: Annotated[int, read_by(whole(1, 10_000))] = 100
    jobs: Annotated[int | None, read_by(whole(1, 10_000))] = None
    backend: Backend = "loky"
    scheduler: str | None = None
    device: DeviceName = "auto"
    keep_checkpoints: bool = False
    collect: bool = False
    json: str | None = None


@dataclass
class _SoFar:
    """What has become of the cells; filled as they come in."""

    cells: Sequence[Cell]
    results: dict[Cell, Result]
    failures: dict[Cell, str] = field(default_factory=dict)

    @property
    def missing(self) -> list[Cell]:
        return [cell for cell in self.cells if cell not in self.results]


def run(flags: Flags, file: FileFlags | None = None) -> None:
    _check_flags(flags)
    from ...robot.data import load_dataset

    cells = grid(flags.conditions, flags.pb_dims, flags.seeds)
    sweep = Sweep(
        dataset=load_dataset(flags.data, said=(file or FileFlags()).said),
        folder=_folder(flags.out),
        epochs=flags.epochs,
        hidden_size=flags.hidden_size,
        samples=flags.samples,
        device=flags.device,
        keep_checkpoints=flags.keep_checkpoints,
    )
    # Every file is looked at before the first cell is run: a folder of another sweep shows at once.
    so_far = _SoFar(cells, {cell: found for cell in cells if (found := sweep.finished(cell))})
    before = len(so_far.results)
    if so_far.missing and not flags.collect:
        _run_missing(sweep, so_far, flags)
    _report(sweep, so_far, flags)
    print(
        f"{len(cells)} cells: {len(so_far.results) - before} run now, {before} finished before, "
        f"{len(so_far.missing)} missing; kept in {flags.out}"
    )
    if so_far.failures:
        raise InputError(
            f"{len(so_far.failures)} of {len(cells)} cells failed; "
            "the same command tries them again"
        )


def _check_flags(flags: Flags) -> None:
    """What no flag can see alone: flags that do not go together, files that cannot be written."""
    if flags.scheduler is not None and flags.backend == "loky":
        raise InputError("--scheduler: loky has none; --backend dask or ray goes with it")
    if flags.scheduler is not None and flags.backend == "dask" and flags.jobs:
        raise InputError("--jobs: a Dask cluster has the workers that it has; leave the flag out")
    if flags.json is not None:
        check_writable(flags.json)


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


def _run_missing(sweep: Sweep, so_far: _SoFar, flags: Flags) -> None:
    cells, results, failures = so_far.cells, so_far.results, so_far.failures
    try:
        with (
            _sigterm_interrupts(),
            progress_bar("{task.fields[failed]}") as bar,
            closing(_attempts(sweep, so_far.missing, flags)) as attempts,
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
            f"stopped; {kept} of {len(cells)} cells are finished and kept in {flags.out}; "
            "to go on: the same command again"
        ) from None


def _attempts(sweep: Sweep, cells: Sequence[Cell], flags: Flags) -> Generator[Attempt]:
    """What becomes of the cells, in the order in which they finish."""
    import joblib

    from ...core.device import choose_device

    ready = partial(choose_device, flags.device)
    jobs = flags.jobs
    if jobs is None and flags.scheduler is None and ready().type == "cuda":
        jobs = GPU_JOBS
    with parallel_backend(flags.backend, flags.scheduler, jobs, ready):
        # Ray's backend for joblib hands results on at the end only; workers write their cells.
        way = "list" if flags.backend == "ray" else "generator_unordered"
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
                f"--backend {flags.backend} failed, {type(error).__name__}: {error}; finished "
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


def _report(sweep: Sweep, so_far: _SoFar, flags: Flags) -> None:
    """Print Table I, and write it where it is asked for."""
    cells, results, failures = so_far.cells, so_far.results, so_far.failures
    entries = table(cells, results, failures)
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else math.inf
    motions = len(sweep.dataset.motions)
    print_table(sweep_table(entries, len(flags.seeds), motions, sweep.samples, width))
    if flags.json is None:
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
    write_json(flags.json, facts | {"table": [asdict(e) for e in entries], "cells": rows})
