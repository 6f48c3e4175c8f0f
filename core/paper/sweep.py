"""Table I of the paper: the models it takes, which of them are finished, and running one.

A cell is one model, of one condition, D_PB and seed. A finished cell is one small JSON file that
also says what it was made of, so that it is never taken for the cell of another recipe or of other
data. Modules that need torch are imported where they are used: a command checks its flags first.
"""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..files import replacing

if TYPE_CHECKING:
    from ..data import Dataset
    from ..model import RNNPB, ModelConfig
    from ..training import TrainingConfig

PB_DIMS = (1, 2, 4, 8, 16, 32, 64, 128)  # the rows of Table I
CONDITIONS = ("strong", "weak", "zero", "deterministic")  # its columns: keys of RECIPES
FORMAT = 1  # of a cell's file
EVALUATION_SEED = 0  # of the sampled PBs, as `rnnpb train` and `rnnpb evaluate` have it

_log = logging.getLogger(__name__)


@dataclass(frozen=True, order=True)
class Cell:
    """One model of Table I."""

    condition: str  # one of CONDITIONS
    pb_dim: int
    seed: int

    @property
    def name(self) -> str:
        return f"{self.condition}-D{self.pb_dim}-seed{self.seed}"


@dataclass(frozen=True)
class Result:
    """What was measured of a finished cell; errors are squared, mean over frames and joints."""

    mean: float  # over motions x samples, as in Table I
    sd: float
    at_sigma_0: float  # mean over motions, at mu
    final_loss: float  # of the last epoch (eq. 3)
    seconds: float
    device: str


@dataclass(frozen=True)
class Attempt:
    """What became of a cell: a result, or the reason why there is none."""

    cell: Cell
    result: Result | None = None
    failure: str = ""
    model: RNNPB | None = None  # where its checkpoint is to be kept


def grid(
    conditions: Iterable[str], pb_dims: Iterable[int], seeds: Iterable[int]
) -> tuple[Cell, ...]:
    """Every cell, seed by seed: a sweep that is stopped has whole tables of the first seeds."""
    conditions, pb_dims = tuple(conditions), tuple(pb_dims)
    return tuple(
        Cell(condition, pb_dim, seed)
        for seed in seeds
        for pb_dim in pb_dims
        for condition in conditions
    )


@dataclass(frozen=True)
class Sweep:
    """What all cells of a sweep share; it travels to the workers as it is."""

    dataset: Dataset
    folder: Path  # of the finished cells; absolute
    epochs: int | None = None  # None: as many as the recipe has
    hidden_size: int = 256
    samples: int = 100  # PBs a motion
    device: str = "auto"  # of the worker
    keep_checkpoints: bool = False

    def configs(self, cell: Cell) -> tuple[ModelConfig, TrainingConfig]:
        """The model and the recipe that `rnnpb train --recipe` takes for the same flags."""
        from ..recipes import RECIPES

        recipe = RECIPES[cell.condition]
        epochs = {} if self.epochs is None else {"epochs": self.epochs}
        model = replace(
            recipe.model,
            num_joints=len(self.dataset.joints),
            num_motions=len(self.dataset.motions),
            pb_dim=cell.pb_dim,
            hidden_size=self.hidden_size,
        )
        return model, replace(recipe.training, seed=cell.seed, **epochs)

    def recipe(self, cell: Cell) -> dict[str, Any]:
        """Everything that a cell's result depends on, as plain JSON values."""
        from ..training import ALGORITHM, Trainer

        model, training = self.configs(cell)
        values = {
            "data_sha256": self._data_sha256,
            "samples": self.samples,
            "evaluation_seed": EVALUATION_SEED,
            **{f"model.{name}": value for name, value in asdict(model).items()},
            **{f"training.{name}": value for name, value in asdict(training).items()},
            "training.algorithm": ALGORITHM,
            "training.precision": Trainer.precision,
        }
        plain: dict[str, Any] = json.loads(json.dumps(values))
        return plain

    @cached_property
    def _data_sha256(self) -> str:
        return self.dataset.sha256

    def path(self, cell: Cell) -> Path:
        return self.folder / f"{cell.name}.json"

    def checkpoint_path(self, cell: Cell) -> Path:
        return self.folder / f"{cell.name}.pt"

    def finished(self, cell: Cell) -> Result | None:
        """The result of a cell that needs no more work, else None.

        Raises:
            InputError: a file that cannot be read, or one of another recipe or of other data.
        """
        path = self.path(cell)
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            found, result = dict(content["recipe"]), Result(**content["result"])
            if content["format"] != FORMAT or not _finite(result):
                raise ValueError("not a result")
        except FileNotFoundError:
            return None
        except OSError as error:
            raise InputError(f"cannot read {path}: {error.strerror}") from error
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            raise InputError(
                f"{path} is no finished cell, or a damaged one; without it the cell is run again"
            ) from error
        _check_recipe(path, found, self.recipe(cell))
        if self.keep_checkpoints and not self.checkpoint_path(cell).is_file():
            return None
        return result

    def save(self, cell: Cell, result: Result, model: RNNPB | None = None) -> None:
        """Write a finished cell; its checkpoint comes first, since the file says `finished`.

        Raises:
            InputError: a file cannot be written.
        """
        if self.keep_checkpoints and model is not None:
            from ..checkpoint import save_checkpoint

            save_checkpoint(model, self.checkpoint_path(cell))
        content = {
            "format": FORMAT,
            "cell": asdict(cell),
            "result": asdict(result),
            "recipe": self.recipe(cell),
        }
        with replacing(self.path(cell)) as beside:
            text = json.dumps(content, indent=2, allow_nan=False)
            beside.write_text(text + "\n", encoding="utf-8")


def _finite(result: Result) -> bool:
    return all(math.isfinite(value) for value in (result.mean, result.sd, result.at_sigma_0))


def _check_recipe(path: Path, found: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Refuse a cell that was made of something else; say what differs first."""
    if found == wanted:
        return
    advice = "another folder keeps the two sweeps apart"
    if found.get("data_sha256") != wanted["data_sha256"]:
        raise InputError(f"{path} was run on other data; {advice}")
    name = next(n for n in (*wanted, *found) if found.get(n, "-") != wanted.get(n, "-"))
    raise InputError(
        f"{path} was run with another recipe, {name.replace('.', ' ')} {found.get(name, '-')} "
        f"and not {wanted.get(name, '-')}; {advice}"
    )


def run_cell(sweep: Sweep, cell: Cell) -> tuple[Result, RNNPB]:
    """Train one model and measure it, as `rnnpb train` and `rnnpb evaluate` do.

    Raises:
        InputError: the training diverged, or there is no such device.
    """
    from ..checkpoint import check_savable
    from ..device import choose_device
    from ..evaluation import reconstruction, reconstruction_at_mean
    from ..recipes import record
    from ..training import Trainer

    started = time.monotonic()
    trainer = Trainer(sweep.dataset, *sweep.configs(cell), choose_device(sweep.device))
    if sweep.keep_checkpoints:
        check_savable(trainer.model)
    loss = error = math.nan
    for progress in trainer.run():
        loss, error = progress.loss, progress.error
        if not math.isfinite(loss):
            raise InputError(f"training diverged in epoch {progress.epoch}: the loss is {loss}")
    model, motions = trainer.model, sweep.dataset.motions
    mean, sd = reconstruction(model, motions, sweep.samples, seed=EVALUATION_SEED)
    result = Result(
        mean=mean,
        sd=sd,
        at_sigma_0=float(reconstruction_at_mean(model, motions).mean()),
        final_loss=loss,
        seconds=round(time.monotonic() - started, 3),
        device=model.mu.device.type,
    )
    if not _finite(result):
        raise InputError(f"training diverged: the error is {mean}")
    if sweep.keep_checkpoints:
        record(
            model,
            sweep.dataset,
            trainer.training,
            seconds=result.seconds,
            device=result.device,
            final_loss=loss,
            final_error=error,
        )
    return result, model


def attempt(sweep: Sweep, cell: Cell) -> Attempt:
    """Run one cell on one thread in a worker; a failure is told, and the other cells go on.

    The worker writes the cell where it sees the sweep's folder (on the same machine, or on a
    shared disk): what is finished is kept, whatever becomes of the command that waits for it.
    """
    try:
        with _one_thread():
            result, model = run_cell(sweep, cell)
        if sweep.folder.is_dir():
            sweep.save(cell, result, model)
        return Attempt(cell, result, model=model.cpu() if sweep.keep_checkpoints else None)
    except InputError as error:
        return Attempt(cell, failure=str(error))
    except Exception as error:
        # The worker's boundary: out of memory, a fault of a driver, of this program.
        _log.info("cell %s failed", cell.name, exc_info=True)
        return Attempt(cell, failure=f"{type(error).__name__}: {error}")


@contextmanager
def _one_thread() -> Iterator[None]:
    """Many small models at once: a worker more is worth more than a thread more."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
