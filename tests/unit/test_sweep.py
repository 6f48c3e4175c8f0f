"""`rnnpb sweep`: Table I on processes of this machine and on a Dask cluster."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from rnnpb_explorer.app.commands.tables import sweep_table
from rnnpb_explorer.core import load_checkpoint
from rnnpb_explorer.core.paper.sweep import Cell, Result, Sweep, attempt, grid
from rnnpb_explorer.core.paper.sweep_table import table
from rnnpb_explorer.core.training import Trainer, TrainingProgress
from rnnpb_explorer.robot import load_dataset

from .cli_harness import Outcome, Rnnpb

SMALL = ("--data", "data", "--hidden-size", 8, "--epochs", 3, "--samples", 4)
TWO = ("--pb-dims", "1,2", "--conditions", "strong,deterministic")
TWO_NAMES = [
    f"{condition}-D{pb_dim}-seed0" for pb_dim in (1, 2) for condition in ("strong", "deterministic")
]


def sweep(rnnpb: Rnnpb, *flags: object) -> Outcome:
    """The small sweep, in this process unless the flags say something else."""
    jobs = () if {"--jobs", "--scheduler"} & set(flags) else ("--jobs", 1)
    return rnnpb("sweep", *SMALL, "--out", "cells", *jobs, *flags)


def swept(rnnpb: Rnnpb, *flags: object) -> Outcome:
    outcome = sweep(rnnpb, *flags)
    assert (outcome.code, outcome.err) == (0, ""), outcome
    return outcome


def cells(folder: str = "cells") -> dict[str, dict[str, Any]]:
    """What the files of the finished cells hold."""
    return {path.stem: json.loads(path.read_text()) for path in sorted(Path(folder).iterdir())}


def errors(folder: str = "cells") -> dict[str, tuple[float, ...]]:
    """The measured errors of the finished cells, to the last digit."""
    names = ("mean", "sd", "at_sigma_0", "final_loss")
    return {
        cell: tuple(content["result"][name] for name in names)
        for cell, content in cells(folder).items()
    }


# On workers


def test_on_processes_of_this_machine(rnnpb: Rnnpb) -> None:
    outcome = swept(rnnpb, *TWO, "--jobs", 2, "--json", "t.json")
    assert "4 cells: 4 run now, 0 finished before, 0 missing; kept in cells" in outcome.out
    found = cells()
    assert sorted(found) == sorted(TWO_NAMES)
    written = json.loads(Path("t.json").read_text())
    assert (written["motions"], written["samples"]) == (3, 4)
    assert [row["epochs"] for row in written["cells"]] == [3] * 4
    assert written["data_sha256"] == load_dataset("data").sha256
    assert [row["state"] for row in written["cells"]] == ["finished"] * 4
    for row, name in zip(written["table"], TWO_NAMES, strict=True):
        result = found[name]["result"]
        assert (row["mean"], row["sd"]) == (result["mean"], pytest.approx(result["sd"]))
        assert f"{row['mean']:.6f}" in outcome.out
        assert f"({row['sd']:.6f})" in outcome.out

    in_this_process = swept(rnnpb, *TWO, "--out", "again")
    assert "4 cells: 4 run now" in in_this_process.out
    assert errors("again") == errors()


@pytest.fixture
def scheduler() -> Iterator[str]:
    """The address of a real Dask cluster of two worker processes on this machine."""
    distributed = pytest.importorskip("distributed", reason="the extra `dask` is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, memory_limit=None, dashboard_address=None
    ) as cluster:
        yield cluster.scheduler_address


def test_on_a_dask_cluster(rnnpb: Rnnpb, scheduler: str) -> None:
    outcome = swept(rnnpb, *TWO, "--backend", "dask", "--scheduler", scheduler)
    assert "4 cells: 4 run now" in outcome.out
    swept(rnnpb, *TWO, "--out", "here")
    assert errors() == errors("here")
    assert len(errors()) == 4

    assert os.getpid() not in (pids := _pids_of_workers(scheduler))
    assert len(pids) == 2
    (Path("cells") / f"{TWO_NAMES[0]}.json").unlink()
    outcome = swept(rnnpb, *TWO, "--backend", "dask", "--scheduler", scheduler)
    assert "4 cells: 1 run now, 3 finished before" in outcome.out
    assert errors() == errors("here")

    said = rnnpb.refuses(
        *("sweep", *SMALL, "--out", "cells", "--jobs", 2),
        *("--backend", "dask", "--scheduler", scheduler),
    )
    assert "--jobs: a Dask cluster has the workers that it has" in said


def test_a_dask_cluster_of_other_software(rnnpb: Rnnpb, scheduler: str) -> None:
    import distributed

    with distributed.Client(scheduler) as client:
        client.run(exec, "import sys; sys.modules['rnnpb_explorer.core.device'] = None")
    said = rnnpb.refuses(
        *("sweep", *SMALL, "--out", "cells", *TWO),
        *("--backend", "dask", "--scheduler", scheduler),
    )
    assert f"the workers of {scheduler} cannot run this: " in said
    assert "rnnpb_explorer" in said
    assert not cells()


def _pids_of_workers(scheduler: str) -> list[int]:
    import distributed

    with distributed.Client(scheduler) as client:
        return list(client.run(os.getpid).values())


def test_a_worker_without_the_folder_hands_the_cell_on(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a cluster without a shared disk: the command writes what the workers cannot."""
    flags = ("--pb-dims", 2, "--conditions", "zero", "--keep-checkpoints")
    swept(rnnpb, *flags)

    def elsewhere(sweep: Sweep, cell: Cell) -> object:
        return attempt(replace(sweep, folder=Path("elsewhere")), cell)

    monkeypatch.setattr("rnnpb_explorer.app.commands.sweep.attempt", elsewhere)
    outcome = swept(rnnpb, *flags, "--out", "handed")
    assert "1 run now" in outcome.out
    names = ["zero-D2-seed0.json", "zero-D2-seed0.pt"]
    assert sorted(path.name for path in Path("handed").iterdir()) == names
    assert not Path("elsewhere").exists()
    assert "0 run now, 1 finished before" in swept(rnnpb, *flags, "--out", "handed").out


# What a cell is


@pytest.mark.parametrize("condition", ["strong", "weak", "zero", "deterministic"])
def test_a_cell_is_what_train_and_evaluate_give(rnnpb: Rnnpb, condition: str) -> None:
    flags = ("--conditions", condition, "--pb-dims", 3, "--seeds", "5,")
    swept(rnnpb, *flags, "--keep-checkpoints")
    train = ("train", "--recipe", condition, *SMALL[:-2], "--pb-dim", 3, "--seed", 5)
    assert rnnpb(*train, "--out", "C.pt").code == 0
    evaluate = ("evaluate", "--ckpt", "C.pt", "--data", "data", "--samples", 4, "--json", "e.json")
    assert rnnpb(*evaluate).code == 0
    [row] = json.loads(Path("e.json").read_text())["reconstruction"]
    name = f"{condition}-D3-seed5"
    result = json.loads(Path(f"cells/{name}.json").read_text())["result"]
    for measure in ("mean", "sd", "at_sigma_0"):
        assert result[measure] == pytest.approx(row[measure], rel=1e-4)

    trained, kept = load_checkpoint("C.pt"), load_checkpoint(f"cells/{name}.pt")
    assert kept.config == trained.config
    for parameter, value in trained.state_dict().items():
        torch.testing.assert_close(kept.state_dict()[parameter], value)
    assert kept.info.metrics == pytest.approx(trained.info.metrics, rel=1e-4)
    assert kept.info.training.keys() == trained.info.training.keys()


def test_a_cell_takes_one_thread(rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch) -> None:
    run, threads = Trainer.run, []

    def counting(self: Trainer) -> Iterator[TrainingProgress]:
        threads.append(torch.get_num_threads())
        return run(self)

    monkeypatch.setattr(Trainer, "run", counting)
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        swept(rnnpb, "--pb-dims", 1, "--conditions", "zero")
        assert (threads, torch.get_num_threads()) == ([1], 2)
    finally:
        torch.set_num_threads(before)


# Stopped and started again


def test_a_restart_does_what_is_missing(rnnpb: Rnnpb) -> None:
    first = swept(rnnpb, *TWO)
    lost = Path("cells") / f"{TWO_NAMES[1]}.json"
    text = lost.read_text()
    lost.unlink()
    written = {path: path.stat().st_mtime_ns for path in Path("cells").iterdir()}
    seen = swept(rnnpb, *TWO, "--collect").out
    assert "missing" in seen.splitlines()[-4]  # of the row `deterministic`
    assert "4 cells: 0 run now, 3 finished before, 1 missing" in seen
    assert not lost.exists()

    again = swept(rnnpb, *TWO)
    assert "4 cells: 1 run now, 3 finished before, 0 missing" in again.out
    assert {path: path.stat().st_mtime_ns for path in written} == written
    assert _without_seconds(lost.read_text()) == _without_seconds(text)
    nothing = swept(rnnpb, *TWO)
    assert "4 cells: 0 run now, 4 finished before, 0 missing" in nothing.out
    assert nothing.out.splitlines()[:-1] == first.out.splitlines()[:-1]

    more = swept(rnnpb, *TWO, "--seeds", 2)
    assert "8 cells: 4 run now, 4 finished before, 0 missing" in more.out
    assert "mean over 2 seeds (sd over seeds)" in " ".join(more.out.split())


def _without_seconds(text: str) -> list[str]:
    return [line for line in text.splitlines() if '"seconds"' not in line]


def test_checkpoints_that_were_not_kept_are_missing(rnnpb: Rnnpb) -> None:
    flags = ("--pb-dims", 1, "--conditions", "zero")
    swept(rnnpb, *flags)
    assert "1 run now" in swept(rnnpb, *flags, "--keep-checkpoints").out
    assert "0 run now" in swept(rnnpb, *flags, "--keep-checkpoints").out
    assert "0 run now" in swept(rnnpb, *flags).out


def test_ctrl_c_keeps_finished_cells(rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch) -> None:
    run = Trainer.run

    def interrupted(self: Trainer) -> Iterator[TrainingProgress]:
        for progress in run(self):
            if (self.model.config.pb_dim, progress.epoch) == (2, 2):
                signal.raise_signal(signal.SIGTERM)  # ends it in the same way
            yield progress

    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(Trainer, "run", interrupted)
    outcome = sweep(rnnpb, *TWO)
    assert (outcome.code, outcome.out) == (130, "")
    assert outcome.err == (
        "rnnpb sweep: stopped; 2 of 4 cells are finished and kept in cells; "
        "to go on: the same command again\n"
    )
    assert signal.getsignal(signal.SIGTERM) is before
    assert sorted(cells()) == sorted(TWO_NAMES[:2])  # and no half of another
    monkeypatch.setattr(Trainer, "run", run)
    assert "4 cells: 2 run now, 2 finished before, 0 missing" in swept(rnnpb, *TWO).out


def test_ctrl_c_in_a_terminal(rnnpb: Rnnpb) -> None:
    """It reaches the workers, too: they end, and add nothing to the one line."""
    # A shell has what it starts in the background ignore Ctrl-C, and children would take that over.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    terminal, other_end = pty.openpty()
    many = ("--pb-dims", 1, "--conditions", "zero", "--seeds", 1000, "--jobs", 2)
    command = ("sweep", *SMALL, "--out", "cells", *many)
    shown = b""
    with subprocess.Popen(
        [sys.executable, "-m", "rnnpb_explorer.app.commands.main", *map(str, command)],
        stdin=other_end,
        stdout=other_end,
        stderr=other_end,
        env=os.environ | {"COLUMNS": "140", "TERM": "xterm"},
        start_new_session=True,
    ) as process:
        os.close(other_end)
        try:
            while part := os.read(terminal, 4096):
                shown += part
                if process.poll() is None and b"/1000" in shown and any(Path("cells").glob("z*")):
                    os.killpg(process.pid, signal.SIGINT)
                    break
            while part := os.read(terminal, 4096):
                shown += part
        except OSError:  # the end of a terminal
            pass
        finally:
            os.close(terminal)
    assert process.returncode == 130
    said = shown.decode()
    kept = len(cells())
    assert 0 < kept < 1000
    assert f"rnnpb sweep: stopped; {kept} of 1000 cells are finished and kept in cells" in said
    assert "Traceback" not in said
    assert "Warning" not in said


def _diverges(self: Trainer, progress: TrainingProgress) -> TrainingProgress:
    return replace(progress, loss=float("nan"))


def _breaks(self: Trainer, progress: TrainingProgress) -> TrainingProgress:
    raise RuntimeError("out of\nmemory")


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        (_diverges, "training diverged in epoch 1: the loss is nan"),
        (_breaks, "RuntimeError: out of memory"),
    ],
)
def test_a_failing_cell_leaves_the_others_alone(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch, fault: Callable[..., Any], reason: str
) -> None:
    run = Trainer.run

    def failing(self: Trainer) -> Iterator[TrainingProgress]:
        fails = (self.model.config.pb_dim, self.model.stochastic) == (1, True)
        return (fault(self, progress) if fails else progress for progress in run(self))

    monkeypatch.setattr(Trainer, "run", failing)
    outcome = sweep(rnnpb, *TWO, "--json", "t.json")
    assert outcome.code == 2
    assert outcome.err.splitlines() == [
        f"strong-D1-seed0 failed: {reason}",
        "rnnpb sweep: 1 of 4 cells failed; the same command tries them again",
    ]
    assert "failed" in outcome.out
    assert "4 cells: 3 run now, 0 finished before, 1 missing" in outcome.out
    assert sorted(cells()) == sorted(TWO_NAMES[1:])
    row = json.loads(Path("t.json").read_text())["cells"][0]
    assert (row["state"], row["condition"], row["pb_dim"]) == ("failed", "strong", 1)
    assert " ".join(row["failure"].split()) == reason
    monkeypatch.setattr(Trainer, "run", run)
    assert "4 cells: 1 run now, 3 finished before, 0 missing" in swept(rnnpb, *TWO).out


# Refused


def test_a_cell_of_another_version(rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch) -> None:
    one = ("--pb-dims", 2, "--conditions", "strong")
    swept(rnnpb, *one)
    monkeypatch.setattr("rnnpb_explorer.core.training.ALGORITHM", 99)
    said = rnnpb.refuses("sweep", *SMALL, "--out", "cells", *one)
    assert "with another recipe, training algorithm 4 and not 99; another folder" in said
    monkeypatch.undo()
    monkeypatch.chdir(rnnpb.folder)
    monkeypatch.setattr("rnnpb_explorer.core.training.Trainer.precision", "bfloat16")
    said = rnnpb.refuses("sweep", *SMALL, "--out", "cells", *one)
    assert "with another recipe, training precision float32 and not bfloat16" in said


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--epochs 4", "with another recipe, training epochs 3 and not 4; another folder"),
        ("--hidden-size 9", "with another recipe, model hidden_size 8 and not 9; another folder"),
        ("--samples 5", "with another recipe, samples 4 and not 5; another folder"),
        ("--data other", "was run on other data; another folder"),
    ],
)
def test_a_cell_of_another_sweep(rnnpb: Rnnpb, flags: str, words: str) -> None:
    Path("other").mkdir()
    for path in Path("data").iterdir():
        (Path("other") / path.name).write_text(path.read_text())
    with Path("other/bow.csv").open("a") as file:
        file.write("0,0,0,0,0\n")
    one = ("--pb-dims", 2, "--conditions", "strong")
    swept(rnnpb, *one)
    before = cells()
    # The unfinished cell D1 is not run either: every file is looked at first.
    said = rnnpb.refuses("sweep", *SMALL, "--out", "cells", *TWO, *flags.split())
    assert f"cells{os.sep}strong-D2-seed0.json was run" in said
    assert words in said
    assert cells() == before


@pytest.mark.parametrize(
    "change",
    [
        lambda cell: cell.clear(),
        lambda cell: cell["result"].clear(),
        lambda cell: cell.update(format=2),
        lambda cell: cell.update(recipe=None),
        lambda cell: cell.update(recipe="strong"),
        lambda cell: cell["result"].update(mean=10**400),
        lambda cell: cell["result"].update(mean="0.1"),
        lambda cell: cell["result"].update(mean=float("nan")),
    ],
)
def test_a_cell_with_rubbish_in_it(
    rnnpb: Rnnpb, change: Callable[[dict[str, Any]], object]
) -> None:
    swept(rnnpb, "--pb-dims", 1, "--conditions", "strong")
    path = Path("cells/strong-D1-seed0.json")
    cell = json.loads(path.read_text())
    change(cell)
    path.write_text(json.dumps(cell))
    said = rnnpb.refuses("sweep", *SMALL, "--out", "cells", "--jobs", 1, *TWO)
    assert "strong-D1-seed0.json is no finished cell, or a damaged one; without it" in said


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"format": 1, "recipe": {}, "result": {}}'])
def test_a_damaged_cell(rnnpb: Rnnpb, text: str) -> None:
    Path("cells").mkdir()
    Path("cells/strong-D1-seed0.json").write_text(text)
    said = rnnpb.refuses("sweep", *SMALL, "--out", "cells", "--jobs", 1, *TWO)
    assert "strong-D1-seed0.json is no finished cell, or a damaged one; without it" in said


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--pb-dims 1,0", "argument --pb-dims: must be from 1 to 128, got 0"),
        ("--pb-dims 129", "argument --pb-dims: must be from 1 to 128, got 129"),
        ("--pb-dims 1,,2", "argument --pb-dims: '' is no whole number"),
        ("--conditions strong,loud", "no condition 'loud'; there are: strong, weak, zero, determ"),
        ("--seeds 0", "argument --seeds: must be from 1 to 1000, got 0"),
        ("--seeds 1,x", "argument --seeds: 'x' is no whole number"),
        ("--epochs 0", "argument --epochs: must be from 1"),
        ("--samples 0", "argument --samples: must be from 1"),
        ("--jobs 0", "argument --jobs: must be from 1"),
        ("--backend slurm", "argument --backend: invalid choice: 'slurm'"),
        ("--scheduler tcp://x", "--scheduler: loky has none; --backend dask or ray goes with it"),
        ("--data none", "no data at none"),
        ("--out tiny.pt", "--out tiny.pt: it is a file; give the name of a folder"),
        ("--out none/cells", "--out none/cells: cannot make this folder: No such file"),
        ("--json none/t.json", "there is no folder"),
    ],
)
def test_sweep_refuses(rnnpb: Rnnpb, flags: str, words: str) -> None:
    assert words in rnnpb.refuses("sweep", *SMALL, "--out", "cells", *flags.split())
    assert not list(Path().glob("cells/*"))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nowhere"])
def test_no_cluster_at_this_address(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    pytest.importorskip("distributed", reason="the extra `dask` is not installed")
    monkeypatch.setattr("rnnpb_explorer.app.commands.parallel.CONNECT_SECONDS", 0.2)
    flags = ("sweep", *SMALL, "--out", "cells", "--backend", "dask", "--scheduler", address)
    assert f"--scheduler {address}: no Dask cluster could be reached" in rnnpb.refuses(*flags)


@pytest.mark.parametrize(("backend", "package"), [("dask", "distributed"), ("ray", "ray")])
def test_a_backend_that_is_not_installed(
    rnnpb: Rnnpb, monkeypatch: pytest.MonkeyPatch, backend: str, package: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    said = rnnpb.refuses("sweep", *SMALL, "--out", "cells", "--backend", backend)
    assert f"{backend} is not installed; pip install 'rnnpb-explorer[{backend}]'" in said


def test_other_commands_do_not_wait_for_it(rnnpb: Rnnpb) -> None:
    code = (
        "import sys; from rnnpb_explorer.app.commands.main import main;"
        "slow = {'torch', 'joblib', 'dask', 'distributed', 'ray'};"
        "bad = main(['sweep', '--data', 'd', '--out', 'o', '--seeds', '0']);"
        "early = slow & set(sys.modules);"
        "good = main(['info', '--ckpt', 'tiny.pt']);"
        "late = slow & set(sys.modules) - {'torch'};"
        "sys.exit(f'{bad} {early} {good} {late}')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stderr.splitlines()[1:] == ["2 set() 0 set()"]


# Table I


def test_cells_come_seed_by_seed() -> None:
    assert grid(["weak", "zero"], [1, 2], [7, 8])[:5] == (
        Cell("weak", 1, 7),
        Cell("zero", 1, 7),
        Cell("weak", 2, 7),
        Cell("zero", 2, 7),
        Cell("weak", 1, 8),
    )


def _result(mean: float, sd: float) -> Result:
    return Result(mean, sd, at_sigma_0=0.0, final_loss=0.0, seconds=1.0, device="cpu")


def test_an_entry_over_seeds() -> None:
    asked = grid(["weak"], [1, 2], [0, 1, 2])
    results = {Cell("weak", 1, 0): _result(3.0, 0.0), Cell("weak", 1, 2): _result(5.0, 2.0)}
    both, none = table(asked, results, [Cell("weak", 2, 1)])
    assert (both.condition, both.pb_dim, both.mean) == ("weak", 1, 4.0)
    assert both.sd == pytest.approx(3**0.5)  # of the pool: (0 + 4) / 2 within, 1 between
    assert both.sd_over_seeds == pytest.approx(2**0.5)
    assert (both.finished, both.failed, both.missing) == ((0, 2), (), (1,))
    assert (none.mean, none.sd, none.sd_over_seeds) == (None, None, None)
    assert (none.finished, none.failed, none.missing) == ((), (1,), (0, 2))

    [one, _] = table(asked, {Cell("weak", 1, 0): _result(3.0, 0.5)})
    assert (one.mean, one.sd, one.sd_over_seeds) == (3.0, 0.5, None)


def test_a_narrow_terminal_turns_the_table() -> None:
    entries = table(grid(["weak", "zero"], [1, 2, 4, 8], [0]), {})
    wide = sweep_table(entries, 1, 72, 100)
    assert [column.header for column in wide.columns] == ["D_PB", "1", "2", "4", "8"]
    narrow = sweep_table(entries, 1, 72, 100, width=60)
    assert [column.header for column in narrow.columns] == ["D_PB", "weak", "zero"]
