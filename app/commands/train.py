"""`rnnpb train`: learn motions; an interrupted run goes on, on a processor bit for bit."""

from __future__ import annotations

import argparse
import contextlib
import math
import shlex
import signal
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from ...core.errors import InputError
from ...core.files import check_writable
from .command import Command, add_data, add_device, real, whole
from .progress import progress_bar

if TYPE_CHECKING:
    from ...core.data import Dataset
    from ...core.model import ModelConfig
    from ...core.training import Trainer, TrainingConfig, TrainingProgress

SAVE_EVERY = 120.0  # seconds between saves of the resumable state: what a power cut may cost


def add_arguments(parser: argparse.ArgumentParser) -> None:
    # No defaults here: --resume must know which flags were given.
    add_data(parser, required=True)
    parser.add_argument(
        "--recipe",
        choices=("strong", "weak", "zero", "deterministic"),
        help="train as the shipped checkpoint of that name was; other flags change it",
    )
    parser.add_argument(
        "--behavior", choices=("stochastic", "deterministic"), help="default: stochastic"
    )
    parser.add_argument(
        "--beta", type=real(0.0, 1e6), help="weight of the KL term (eq. 3); default: 1e-3"
    )
    parser.add_argument("--pb-dim", type=whole(1, 128), help="default: 4")
    parser.add_argument("--hidden-size", type=whole(1, 4096), help="LSTM units; default: 256")
    parser.add_argument("--epochs", type=whole(1, 10_000_000), metavar="N")
    parser.add_argument(
        "--samples",
        type=whole(1, 100),
        metavar="N",
        help="PBs sampled a motion and epoch, in mirrored pairs; default: 1; 2 pays off where "
        "sigma is large, as with beta = 1e-3",
    )
    parser.add_argument("--seed", type=whole(0, 2**32 - 1), help="default: 0")
    parser.add_argument("--resume", metavar="P", help="go on with the interrupted run in P")
    add_device(parser)
    parser.add_argument("--out", required=True, metavar="C.pt")


def run(arguments: argparse.Namespace) -> None:
    out = Path(arguments.out)
    if out.suffix.lower() != ".pt":
        raise InputError(f"--out {out}: the name of a checkpoint ends in .pt")
    check_writable(out)
    from ...core.checkpoint import check_savable, save_checkpoint
    from ...core.device import choose_device
    from ...core.training import Trainer
    from ...robot.data import load_dataset

    dataset = load_dataset(arguments.data)
    config, training = _recipe(arguments) if arguments.resume is None else _resumed(arguments)
    resumable = out.with_suffix(".resume.pt")
    if resumable.exists() and not _same_file(resumable, arguments.resume):
        raise InputError(
            f"{resumable} holds an interrupted run; to go on with it: "
            + _command(data=arguments.data, resume=resumable, out=out)
            + "; to begin anew, remove it first"
        )
    trainer = Trainer(dataset, config, training, choose_device(arguments.device))
    check_savable(trainer.model)
    session = _Session(trainer, dataset, resumable)
    if arguments.resume is not None:
        session.restore(Path(arguments.resume))
    with _stop_asked() as asked:
        for _ in session.epochs():
            if asked and trainer.epoch < training.epochs:
                session.save()
                raise KeyboardInterrupt(
                    f"stopped after epoch {trainer.epoch} of {training.epochs}; to go on: "
                    + _command(data=arguments.data, resume=session.resumable, out=out)
                )
    session.finish()
    save_checkpoint(trainer.model, out)
    session.resumable.unlink(missing_ok=True)
    metrics = trainer.model.info.metrics
    print(
        f"{trainer.epoch} epochs in {session.seconds:.0f} s, sampled error "
        f"{metrics['reconstruction_mean']:.6f} (sd {metrics['reconstruction_sd']:.6f}): {out}"
    )


def _same_file(path: Path, given: str | None) -> bool:
    return given is not None and Path(given).exists() and path.samefile(given)


def _command(**flags: object) -> str:
    words = [word for name, value in flags.items() for word in (f"--{name}", str(value))]
    return shlex.join(["rnnpb", "train", *words])


def _given(arguments: argparse.Namespace, *names: str) -> dict[str, Any]:
    """The flags of these names that were given."""
    values = {name: getattr(arguments, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def _recipe(arguments: argparse.Namespace) -> tuple[ModelConfig, TrainingConfig]:
    """What the flags of a fresh run ask for."""
    from ...core.model import ModelConfig
    from ...core.recipes import RECIPES, Recipe
    from ...core.training import TrainingConfig

    recipe = Recipe(ModelConfig(), TrainingConfig())
    if arguments.recipe is not None:
        recipe = RECIPES[arguments.recipe]
        for flag in _given(arguments, "behavior", "beta"):
            raise InputError(f"--{flag}: --recipe {arguments.recipe} decides that; leave it out")
    config = replace(recipe.model, **_given(arguments, "pb_dim", "hidden_size"))
    if arguments.behavior == "deterministic":
        if arguments.beta is not None:
            raise InputError("--beta: a deterministic model has no KL term; leave the flag out")
        config = replace(config, behavior="deterministic", beta=None)
    elif arguments.beta is not None:
        config = replace(config, beta=arguments.beta)
    training = replace(recipe.training, **_given(arguments, "epochs", "samples", "seed"))
    return config, training


def _resumed(arguments: argparse.Namespace) -> tuple[ModelConfig, TrainingConfig]:
    """What the run in --resume was started with.

    Raises:
        InputError: no interrupted run, or a flag asks for another one.
    """
    from ...core.checkpoint import load_checkpoint
    from ...core.training import TrainingConfig

    if arguments.recipe is not None:
        raise InputError("--recipe: the run in --resume has its own; leave the flag out")
    path = Path(arguments.resume)
    config = load_checkpoint(path).config
    try:
        training = TrainingConfig(**_resume_state(path)["training"])
    except (KeyError, TypeError) as error:
        raise InputError(f"{path} was left by another version; train anew ({error})") from error
    known = asdict(config) | asdict(training)
    for name, value in _given(
        arguments, "behavior", "beta", "pb_dim", "hidden_size", "epochs", "samples", "seed"
    ).items():
        if value != known[name]:
            flag = "--" + name.replace("_", "-")
            raise InputError(
                f"{flag} {value}: the run in {path} was started with {known[name]}; "
                "leave the flag out, or train anew"
            )
    return config, training


def _resume_state(path: Path) -> dict[str, Any]:
    from ...core.checkpoint import read_plain

    state = read_plain(path).get("resume")
    if not isinstance(state, dict):
        raise InputError(f"{path} is a finished model, not an interrupted run; nothing to resume")
    return state


class _Session:
    """A training run from its start or its resumption to its end or its interruption."""

    def __init__(self, trainer: Trainer, dataset: Dataset, resumable: Path) -> None:
        self.trainer = trainer
        self.dataset = dataset
        self.resumable = resumable
        self._before = 0.0  # seconds of earlier sessions of the same run
        self._started = self._saved = time.monotonic()
        self._last: TrainingProgress | None = None

    @property
    def seconds(self) -> float:
        return self._before + time.monotonic() - self._started

    def restore(self, path: Path) -> None:
        """Go on where the run in `path` stopped.

        Raises:
            InputError: the run was one on other data, or the file is damaged.
        """
        from ...core.checkpoint import load_checkpoint

        state = _resume_state(path)
        if state.get("data_sha256") != self.dataset.sha256:
            raise InputError(f"the run in {path} was started with other data")
        try:
            self.trainer.restore(load_checkpoint(path), state)
            self._before = float(state["seconds"])
        except InputError:
            raise
        except (AttributeError, LookupError, TypeError, ValueError, RuntimeError) as error:
            raise InputError(f"{path} is damaged and cannot be resumed: {error}") from error

    def epochs(self) -> Iterator[TrainingProgress]:
        """Train epoch by epoch, with a bar on a terminal and a save every other minute."""
        text = "loss {task.fields[loss]:.4f}  error {task.fields[error]:.6f}"
        text += "  KL {task.fields[kl]:.1f}  {task.fields[rate]:.1f} ep/s"
        first = self.trainer.epoch
        total = self.trainer.training.epochs
        with progress_bar(text) as bar:
            task = bar.add_task(
                "training", total=total, completed=first, loss=0.0, error=0.0, kl=0.0, rate=0.0
            )
            for progress in self.trainer.run():
                if not math.isfinite(progress.loss):
                    raise InputError(
                        f"training diverged in epoch {progress.epoch}: the loss is "
                        f"{progress.loss}; another seed or a smaller beta may help"
                    )
                self._last = progress
                rate = (progress.epoch - first) / (time.monotonic() - self._started)
                bar.update(
                    task,
                    completed=progress.epoch,
                    loss=progress.loss,
                    error=progress.error,
                    kl=progress.kl,
                    rate=rate,
                )
                if time.monotonic() - self._saved > SAVE_EVERY and progress.epoch < total:
                    self.save()
                yield progress

    def save(self) -> None:
        """Write what `restore` needs."""
        from ...core.checkpoint import save_checkpoint

        own = {"seconds": self.seconds, "data_sha256": self.dataset.sha256}
        save_checkpoint(self.trainer.model, self.resumable, resume=self.trainer.state() | own)
        self._saved = time.monotonic()

    def finish(self) -> None:
        """Put the training record and the measured error into the model."""
        from ...core.recipes import record

        last = self._last
        record(
            self.trainer.model,
            self.dataset,
            self.trainer.training,
            seconds=round(self.seconds, 3),
            device=self.trainer.model.mu.device.type,
            final_loss=last.loss if last else float("nan"),
            final_error=last.error if last else float("nan"),
        )


@contextlib.contextmanager
def _stop_asked() -> Iterator[list[int]]:
    """A list that is empty until Ctrl-C or SIGTERM; a second Ctrl-C interrupts at once.

    Training looks at it between two epochs: within one, the model and the optimiser do not agree.
    """
    asked: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def ask(number: int, frame: FrameType | None) -> None:
        asked.append(number)
        signal.signal(signal.SIGINT, signal.default_int_handler)

    for number in before:
        signal.signal(number, ask)
    try:
        yield asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


COMMAND = Command("train", "Train a model on motions.", add_arguments, run)
