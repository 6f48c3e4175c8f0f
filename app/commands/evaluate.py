"""`rnnpb evaluate`: the two tables of the paper, and what kind of space a model has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from ...core.errors import InputError
from ...core.files import check_writable
from .codebooks import whole_codebook
from .flags import (
    FLAGS,
    Checkpoints,
    Data,
    DeviceName,
    FileFlags,
    Joints,
    Seed,
    joint_indices,
    load_model,
    one_of,
    read_by,
    read_target,
    several,
    whole,
)
from .progress import progress_bar
from .tables import (
    Row,
    hidden_table,
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

TASKS = ("reconstruction", "recognition", "structure", "hidden")


@FLAGS
@dataclass(frozen=True, kw_only=True)
class Flags:
    """What to measure, and how.

    Args:
        task: reconstruction (Table I), recognition (Table II), structure (scale and landscapes of
            the latent space), hidden (what is inferred of joints that are not observed), or several
            of them
        samples: reconstruction: PBs a motion
        draws: recognition: sets of ten novel patterns, by seed, seed + 1, ..
        trials: recognition: of a pattern
        iterations: recognition: of a trial
        targets: recognition: of this motion, or of those in this folder, instead of novel patterns
        joints: hidden: those that are observed
        lm: recognition: Levenberg-Marquardt from the closest learned mu, too
        json: write the tables to this file, too
    """

    ckpt: Checkpoints
    data: Data
    task: Annotated[tuple[str, ...], read_by(several(one_of("task", TASKS)), "T,..")] = TASKS[:1]
    samples: Annotated[int, read_by(whole(1, 10_000))] = 100
    draws: Annotated[int, read_by(whole(1, 1_000))] = 1
    trials: Annotated[int, read_by(whole(1, 1_000))] = 10
    iterations: Annotated[int, read_by(whole(1, 100_000))] = 100
    targets: Path | None = None
    joints: Joints = ()
    lm: bool = False
    seed: Seed = 0
    device: DeviceName = "auto"
    json: str | None = None


def run(flags: Flags, file: FileFlags | None = None) -> None:
    if flags.json is not None:
        check_writable(flags.json)

    if "hidden" in flags.task and not flags.joints:
        raise InputError("--task hidden needs --joints: those that are observed")

    # Every checkpoint is read before the first is measured: a mistyped one shows at once.
    subjects = [_subject(checkpoint, flags, file) for checkpoint in flags.ckpt]
    measured: dict[str, list[Row]] = {task: [] for task in TASKS if task in flags.task}
    with progress_bar("{task.fields[doing]}") as bar:
        steps = sum(_steps(each, task, flags) for each in subjects for task in measured)
        progress = bar.add_task("evaluating", total=steps, doing="")
        for subject in subjects:
            for task, rows in measured.items():
                bar.update(progress, doing=f"{task} of {subject.facts['checkpoint']}")
                rows += [
                    subject.facts | row
                    for row in _MEASURES[task](subject, flags, lambda: bar.advance(progress))
                ]
    if "reconstruction" in measured:
        print_table(reconstruction_table(measured["reconstruction"]))
    if "recognition" in measured:
        for table in recognition_tables(measured["recognition"]):
            print_table(table)
    if "structure" in measured:
        print_table(structure_table(measured["structure"]))
    if "hidden" in measured:
        print_table(hidden_table(measured["hidden"]))
    if flags.json is not None:
        write_json(flags.json, measured)


@dataclass(frozen=True)
class _Subject:
    """A checkpoint to measure, and what it is measured with."""

    model: RNNPB
    motions: Sequence[Motion]
    patterns: Sequence[Motion]  # novel ones, where recognition is asked for
    facts: Row


def _subject(checkpoint: str, flags: Flags, file: FileFlags | None) -> _Subject:
    from ...core.device import choose_device
    from ...core.paper.novel_patterns import novel_patterns

    model, dataset = load_model(checkpoint, flags.data, file)
    motions = dataset.motions if dataset else ()
    patterns: list[Motion] = []
    if "recognition" in flags.task and flags.targets is not None:
        patterns = _targets(flags.targets, model, file or FileFlags())
    elif "recognition" in flags.task:
        for draw in _draws(flags):
            patterns += novel_patterns(motions, draw)
    facts = {
        "checkpoint": checkpoint,
        "behavior": model.config.behavior,
        "beta": model.config.beta,
        "pb_dim": model.config.pb_dim,
    }
    return _Subject(model.to(choose_device(flags.device)), motions, patterns, facts)


def _targets(path: Path, model: RNNPB, file: FileFlags) -> list[Motion]:
    """The motions of a file, or of all files in a folder."""
    info = model.info
    paths = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
    motions = [read_target(one, info.joints, info.fps, file) for one in paths]
    if not motions:
        raise InputError(f"--targets {path}: no file lies there")
    return motions


def _draws(flags: Flags) -> range:
    """The seeds of the sets of novel patterns."""
    return range(flags.seed, flags.seed + flags.draws)


def _steps(subject: _Subject, task: str, flags: Flags) -> int:
    """How often a measure says that it has come farther."""
    from ...core.paper.structure import landscape_count

    if task == "recognition":
        return len(subject.patterns) * len(_procedures(flags))
    if task == "hidden":
        return len(subject.motions)
    return landscape_count(len(subject.motions)) if task == "structure" else 1


def _procedures(flags: Flags) -> tuple[Procedure, ...]:
    """The rows of Table II."""
    from ...core.paper.recognition_table import WARM_STARTS

    return (*WARM_STARTS, "lm", "global") if flags.lm else (*WARM_STARTS, "global")


def _reconstruction(subject: _Subject, flags: Flags, done: Callable[[], object]) -> list[Row]:
    """One cell of Table I."""
    from ...core.evaluation import reconstruction, reconstruction_at_mean

    model, motions = subject.model, subject.motions
    mean, sd = reconstruction(model, motions, flags.samples, seed=flags.seed)
    row = {
        "mean": mean,
        "sd": sd,
        "at_sigma_0": float(reconstruction_at_mean(model, motions).mean()),
        "motions": len(motions),
        "samples": flags.samples,
        "seed": flags.seed,
    }
    done()
    return [row]


def _recognition(subject: _Subject, flags: Flags, done: Callable[[], object]) -> list[Row]:
    """The cells of Table II in one column: a row for each warm start."""
    from ...core.paper.recognition_table import recognition_row

    codebook = whole_codebook(subject.model)
    settings = {"trials": flags.trials, "iterations": flags.iterations}
    return [
        asdict(
            recognition_row(
                subject.model,
                warm_start,
                subject.patterns,
                **settings,
                seed=flags.seed,
                codebook=codebook,
                recognized=done,
            )
        )
        | settings
        | {
            "draws": [] if flags.targets else list(_draws(flags)),
            "patterns": len(subject.patterns),
        }
        for warm_start in _procedures(flags)
    ]


def _structure(subject: _Subject, flags: Flags, done: Callable[[], object]) -> list[Row]:
    """Scale, uncertainty and landscapes of the latent space."""
    from ...core.paper.structure import structure

    return [asdict(structure(subject.model, subject.motions, done))]


def _hidden(subject: _Subject, flags: Flags, done: Callable[[], object]) -> list[Row]:
    """What the model makes of the joints that are not observed."""
    from ...core.evaluation import hidden_joints

    model = subject.model
    seen = joint_indices(flags.joints, model.info.joints)
    if len(seen) == len(model.info.joints):
        raise InputError("--joints: all joints are observed, and none is hidden")
    measured = hidden_joints(model, subject.motions, seen, whole_codebook(model), done)
    return [asdict(measured) | {"joints": list(flags.joints), "motions": len(subject.motions)}]


_MEASURES = {
    "reconstruction": _reconstruction,
    "recognition": _recognition,
    "structure": _structure,
    "hidden": _hidden,
}
