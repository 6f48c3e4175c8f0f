"""`rnnpb evaluate`: the two tables of the paper, and what kind of space a model has."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from ...core.files import check_writable
from .command import Command, add_checkpoints, add_data, add_device, add_seed, load_model, whole
from .progress import progress_bar
from .tables import (
    Row,
    print_table,
    recognition_tables,
    reconstruction_table,
    structure_table,
    write_json,
)

if TYPE_CHECKING:
    from ...core.model import RNNPB
    from ...core.motion import Motion
    from ...core.paper.recognition_table import Procedure

TASKS = ("reconstruction", "recognition", "structure")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_checkpoints(parser)
    add_data(parser, required=True)
    parser.add_argument(
        "--task",
        type=_tasks,
        default=TASKS[:1],
        metavar="T,..",
        help="reconstruction (Table I), recognition (Table II), structure (scale and landscapes of "
        "the latent space), or several of them; default: reconstruction",
    )
    parser.add_argument(
        "--samples",
        type=whole(1, 10_000),
        default=100,
        help="reconstruction: PBs a motion; default: 100",
    )
    parser.add_argument(
        "--draws",
        type=whole(1, 1_000),
        default=1,
        help="recognition: sets of ten novel patterns, by seed, seed + 1, ..; default: 1",
    )
    parser.add_argument(
        "--trials", type=whole(1, 1_000), default=10, help="recognition: of a pattern; default: 10"
    )
    parser.add_argument(
        "--iterations", type=whole(1, 100_000), default=100, help="recognition; default: 100"
    )
    parser.add_argument(
        "--lm",
        action="store_true",
        help="recognition: Levenberg-Marquardt, too, from as many learned mu as there are trials",
    )
    add_seed(parser)
    add_device(parser)
    parser.add_argument("--json", metavar="F", help="write the tables to F, too")


def _tasks(text: str) -> tuple[str, ...]:
    tasks = tuple(dict.fromkeys(text.split(",")))
    unknown = [task for task in tasks if task not in TASKS]
    if unknown:
        raise argparse.ArgumentTypeError(f"no task {unknown[0]!r}; there are: {', '.join(TASKS)}")
    return tasks


def run(arguments: argparse.Namespace) -> None:
    if arguments.json is not None:
        check_writable(arguments.json)

    # Every checkpoint is read before the first is measured: a mistyped one shows at once.
    subjects = [_subject(checkpoint, arguments) for checkpoint in arguments.ckpt]
    measured: dict[str, list[Row]] = {task: [] for task in TASKS if task in arguments.task}
    with progress_bar("{task.fields[doing]}") as bar:
        steps = sum(_steps(each, task, arguments) for each in subjects for task in measured)
        progress = bar.add_task("evaluating", total=steps, doing="")
        for subject in subjects:
            for task, rows in measured.items():
                bar.update(progress, doing=f"{task} of {subject.facts['checkpoint']}")
                rows += [
                    subject.facts | row
                    for row in _MEASURES[task](subject, arguments, lambda: bar.advance(progress))
                ]
    if "reconstruction" in measured:
        print_table(reconstruction_table(measured["reconstruction"]))
    if "recognition" in measured:
        for table in recognition_tables(measured["recognition"]):
            print_table(table)
    if "structure" in measured:
        print_table(structure_table(measured["structure"]))
    if arguments.json is not None:
        write_json(arguments.json, measured)


@dataclass(frozen=True)
class _Subject:
    """A checkpoint to measure, and what it is measured with."""

    model: RNNPB
    motions: Sequence[Motion]
    patterns: Sequence[Motion]  # novel ones, where recognition is asked for
    facts: Row


def _subject(checkpoint: str, arguments: argparse.Namespace) -> _Subject:
    from ...core.device import choose_device
    from ...core.paper.novel_patterns import novel_patterns

    model, dataset = load_model(checkpoint, arguments.data)
    motions = dataset.motions if dataset else ()
    patterns: list[Motion] = []
    if "recognition" in arguments.task:
        for draw in _draws(arguments):
            patterns += novel_patterns(motions, draw)
    facts = {
        "checkpoint": checkpoint,
        "behavior": model.config.behavior,
        "beta": model.config.beta,
        "pb_dim": model.config.pb_dim,
    }
    return _Subject(model.to(choose_device(arguments.device)), motions, patterns, facts)


def _draws(arguments: argparse.Namespace) -> range:
    """The seeds of the sets of novel patterns."""
    return range(arguments.seed, arguments.seed + arguments.draws)


def _steps(subject: _Subject, task: str, arguments: argparse.Namespace) -> int:
    """How often a measure says that it has come farther."""
    from ...core.paper.structure import landscape_count

    if task == "recognition":
        return len(subject.patterns) * len(_procedures(arguments))
    return landscape_count(len(subject.motions)) if task == "structure" else 1


def _procedures(arguments: argparse.Namespace) -> tuple[Procedure, ...]:
    """The rows of Table II."""
    from ...core.paper.recognition_table import WARM_STARTS

    return (*WARM_STARTS, "lm") if arguments.lm else WARM_STARTS


def _reconstruction(
    subject: _Subject, arguments: argparse.Namespace, done: Callable[[], object]
) -> list[Row]:
    """One cell of Table I."""
    from ...core.evaluation import reconstruction, reconstruction_at_mean

    model, motions = subject.model, subject.motions
    mean, sd = reconstruction(model, motions, arguments.samples, seed=arguments.seed)
    row = {
        "mean": mean,
        "sd": sd,
        "at_sigma_0": float(reconstruction_at_mean(model, motions).mean()),
        "motions": len(motions),
        "samples": arguments.samples,
        "seed": arguments.seed,
    }
    done()
    return [row]


def _recognition(
    subject: _Subject, arguments: argparse.Namespace, done: Callable[[], object]
) -> list[Row]:
    """The cells of Table II in one column: a row for each warm start."""
    from ...core.paper.recognition_table import recognition_row

    settings = {"trials": arguments.trials, "iterations": arguments.iterations}
    return [
        asdict(
            recognition_row(
                subject.model,
                warm_start,
                subject.patterns,
                **settings,
                seed=arguments.seed,
                recognized=done,
            )
        )
        | settings
        | {"draws": list(_draws(arguments)), "patterns": len(subject.patterns)}
        for warm_start in _procedures(arguments)
    ]


def _structure(
    subject: _Subject, arguments: argparse.Namespace, done: Callable[[], object]
) -> list[Row]:
    """Scale, uncertainty and landscapes of the latent space."""
    from ...core.paper.structure import structure

    return [asdict(structure(subject.model, subject.motions, done))]


_MEASURES = {
    "reconstruction": _reconstruction,
    "recognition": _recognition,
    "structure": _structure,
}

COMMAND = Command("evaluate", "Measure checkpoints as the paper does.", add_arguments, run)
