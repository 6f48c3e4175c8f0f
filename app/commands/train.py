"""`rnnpb train`: learn motions; an interrupted run goes on, on a processor bit for bit."""

from __future__ import annotations

import contextlib
import math
import shlex
import signal
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from ...core.errors import InputError
from ...core.files import check_writable
from ...core.paper.sweep import CONDITIONS
from .flags import (
    FLAGS,
    SEEDS,
    Data,
    DeviceName,
    FileFlags,
    naming_flags,
    note,
    read_by,
    real,
    whole,
)
from .progress import progress_bar

if TYPE_CHECKING:
    from ...core.data import Dataset
    from ...core.model import ModelConfig
    from ...core.training import Trainer, TrainingConfig, TrainingProgress

MOST_NAMES = 6  # of motions, in a line
SAVE_EVERY = 120.0  # seconds between saves of the resumable state: what a power cut may cost


@FLAGS
@dataclass(frozen=True, kw_only=True)
class Flags:
    """What is trained. None is not given, which --resume and --recipe must know.

    Args:
        recipe: train as the shipped checkpoint of that name was; other flags change it
        behavior: default: stochastic
        beta: weight of the KL term (eq. 3); default: 1e-3
        pb_dim: dimensions of the PB; default: 4
        hidden_size: LSTM units; default: 256
        samples: PBs sampled a motion and epoch, in mirrored pairs; default: 1; 2 pays off where
            sigma is large, as with beta = 1e-3
        seed: of the random numbers; default: 0
        resume: go on with the interrupted run in this file
        out: C.pt
    """

    data: Data
    recipe: Annotated[str | None, Parameter(choices=CONDITIONS)] = None
    behavior: Literal["stochastic", "deterministic"] | None = None
    beta: Annotated[float | None, read_by(real(0.0, 1e6))] = None
    pb_dim: Annotated[int | None, read_by(whole(1, 128))] = None
    hidden_size: Annotated[int | None, read_by(whole(1, 4096))] = None
    epochs: Annotated[int | None, read_by(whole(1, 10_000_000))] = None
    samples: Annotated[int | None, read_by(whole(1, 100))] = None
    seed: Annotated[int | None, read_by(SEEDS)] = None
    resume: Path | None = None
    device: DeviceName = "auto"
    out: Path


def run(flags: Flags, file: FileFlags | None = None) -> None:
    out = flags.out
    if out.suffix.lower() != ".pt":
        raise InputError(f"--out {out}: the name of a checkpoint ends in .pt")
    check_writable(out)
    from ...core.checkpoint import check_savable, save_checkpoint
    from ...core.device import choose_device
    from ...core.training import Trainer
    from ...robot.data import load_dataset

    with naming_flags():
        dataset = load_dataset(flags.data, said=(file or FileFlags()).said)
    config, training = _recipe(flags) if flags.resume is None else _resumed(flags.resume, flags)
    resumable = out.with_suffix(".resume.pt")
    if resumable.exists() and not _same_file(resumable, flags.resume):
        raise InputError(
            f"{resumable} holds an interrupted run; to go on with it: "
            + _command(data=flags.data, resume=resumable, out=out)
            + "; to begin anew, remove it first"
        )
    trainer = Trainer(dataset, config, training, choose_device(flags.device))
    check_savable(trainer.model)
    session = _Session(trainer, dataset, resumable)
    if flags.resume is not None:
        session.restore(flags.resume)
    for line in described(dataset):
        note(line)
    with _stop_asked() as asked:
        for _ in session.epochs():
            if asked and trainer.epoch < training.epochs:
                session.save()
                raise KeyboardInterrupt(
                    f"stopped after epoch {trainer.epoch} of {training.epochs}; to go on: "
                    + _command(data=flags.data, resume=session.resumable, out=out)
                )
    session.finish()
    save_checkpoint(trainer.model, out)
    session.resumable.unlink(missing_ok=True)
    metrics = trainer.model.info.metrics
    print(
        f"{trainer.epoch} epochs in {session.seconds:.0f} s, sampled error "
        f"{metrics['reconstruction_mean']:.6f} (sd {metrics['reconstruction_sd']:.6f}): {out}"
    )


def described(dataset: Dataset) -> list[str]:
    """What will be learned, and what was not plain in the files."""
    lengths = [len(motion) for motion in dataset.motions]
    names = [motion.name for motion in dataset.motions]
    shown = ", ".join(names[:MOST_NAMES]) + (", …" if len(names) > MOST_NAMES else "")
    frames = f"{min(lengths)} to {max(lengths)} frames at {dataset.fps:g} Hz"
    return [
        *dataset.remarks,
        f"{len(names)} motions of {frames}: {shown}",
        f"{len(dataset.joints)} joints: {', '.join(dataset.joints)}",
    ]


def _same_file(path: Path, given: Path | None) -> bool:
    return given is not None and given.exists() and path.samefile(given)


def _command(**given: object) -> str:
    words = [word for name, value in given.items() for word in (f"--{name}", str(value))]
    return shlex.join(["rnnpb", "train", *words])


def _given(flags: Flags, *names: str) -> dict[str, Any]:
    """The flags of these names that were given."""
    values = {name: getattr(flags, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def _recipe(flags: Flags) -> tuple[ModelConfig, TrainingConfig]:
    """What the flags of a fresh run ask for."""
    from ...core.model import ModelConfig
    from ...core.recipes import RECIPES, Recipe
    from ...core.training import TrainingConfig

    recipe = Recipe(ModelConfig(), TrainingConfig())
    if flags.recipe is not None:
        recipe = RECIPES[flags.recipe]
        for flag in _given(flags, "behavior", "beta"):
            raise InputError(f"--{flag}: --recipe {flags.recipe} decides that; leave it out")
    config = replace(recipe.model, **_given(flags, "pb_dim", "hidden_size"))
    if flags.behavior == "deterministic":
        if flags.beta is not None:
            raise InputError("--beta: a deterministic model has no KL term; leave the flag out")
        config = replace(config, behavior="deterministic", beta=None)
    elif flags.beta is not None:
        config = replace(config, beta=flags.beta)
    training = replace(recipe.training, **_given(flags, "epochs", "samples", "seed"))
    return config, training


def _resumed(path: Path, flags: Flags) -> tuple[ModelConfig, TrainingConfig]:
    """What the run in `path` was started with.

    Raises:
        InputError: no interrupted run, or a flag asks for another one.
    """
    from ...core.checkpoint import load_checkpoint
    from ...core.training import TrainingConfig

    if flags.recipe is not None:
        raise InputError("--recipe: the run in --resume has its own; leave the flag out")
    config = load_checkpoint(path).config
    try:
        training = TrainingConfig(**_resume_state(path)["training"])
    except (KeyError, TypeError) as error:
        raise InputError(f"{path} was left by another version; train anew ({error})") from error
    known = asdict(config) | asdict(training)
    for name, value in _given(
        flags, "behavior", "beta", "pb_dim", "hidden_size", "epochs", "samples", "seed"
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
