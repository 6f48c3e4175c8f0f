"""`rnnpb figures`: the paper's Figs. 2 to 6 for any checkpoints, as PNG and SVG."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from ...core.errors import InputError
from .flags import FLAGS, Checkpoints, Data, FileFlags, Seed, WarmStart, load_model, read_by, whole
from .progress import progress_bar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...core.data import Dataset
    from ...core.model import RNNPB
    from ...core.motion import Motion
    from ...core.recognition_run import RecognitionConfig

# What the paper draws; of other data, the first six.
DENSITIES_OF = (
    "Alienated_1",
    "Curious_01",
    "Disappointed_1",
    "Frustrated_1",
    "Hot_1",
    "Innocent_1_tr",
)
LANDSCAPES_OF = ("Alienated_1", "Angry_3", "Angry_4", "AskForAttention_3", "Bored_01", "Chill_01")
PATTERN_OF = "Curious_01"
MOTIONS = 6
TRIALS = 4  # in Fig. 6
MAX_MODELS = 8  # rows of a page


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split(","))


@FLAGS
@dataclass(frozen=True, kw_only=True)
class Flags:
    """What is drawn, and where.

    Args:
        motions: of Figs. 2 and 4; default: those of the paper, of other data the first six
        pattern: motion of which Figs. 5 and 6 recognise a novel variant; default: the paper's, of
            other data the first motion
        iterations: of Figs. 5 and 6
        out: a folder; made if missing
    """

    ckpt: Checkpoints
    data: Data
    motions: Annotated[tuple[str, ...] | None, read_by(_names, "NAME,..")] = None
    pattern: str | None = None
    init: WarmStart = "baseline"
    iterations: Annotated[int, read_by(whole(2, 100_000))] = 100
    seed: Seed = 0
    out: Path


def run(flags: Flags, file: FileFlags | None = None) -> None:
    out = flags.out
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out}: it is no folder")
    models, dataset = _load(flags.ckpt, flags.data, file)
    plan = _Plan(models, dataset, flags)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out {out}: {error.strerror or error}") from error

    from ...core.paper.figures.style import write_figure

    written: list[str] = []
    with progress_bar("{task.fields[doing]}") as bar:
        task = bar.add_task("drawing", total=plan.steps, doing="")

        def advance() -> None:
            bar.advance(task)

        for name, draw in plan.figures(advance):
            bar.update(task, doing=name)
            paths = write_figure(draw(), out, name)
            written += paths
            advance()
    print("\n".join(written))


def _load(
    ckpts: Sequence[str], data: str, file: FileFlags | None
) -> tuple[dict[str, RNNPB], Dataset]:
    """The models by the names to print, and the motions that all of them know."""
    if len(ckpts) > MAX_MODELS:
        raise InputError(f"--ckpt: a figure has room for {MAX_MODELS} models, got {len(ckpts)}")
    models: dict[str, RNNPB] = {}
    common: Dataset | None = None
    for ckpt in ckpts:
        name = _name(ckpt)
        if name in models:
            raise InputError(f"--ckpt {ckpt}: another checkpoint has the name {name!r} already")
        models[name], dataset = load_model(ckpt, data, file)
        assert dataset is not None  # --data is required
        common = dataset if common is None else _common(common, dataset, ckpt)
    assert common is not None  # so is --ckpt
    return models, common


def _common(first: Dataset, other: Dataset, ckpt: str) -> Dataset:
    """The motions that both know."""
    if first.joints != other.joints:
        raise InputError(f"--ckpt {ckpt}: its joints, or their order, are not those of the first")
    names = {motion.name for motion in other.motions}
    motions = tuple(motion for motion in first.motions if motion.name in names)
    if not motions:
        raise InputError(f"--ckpt {ckpt}: it shares no motion with those before it")
    return replace(first, motions=motions)


def _name(ckpt: str) -> str:
    """What to call a checkpoint: every published one is a model.tar in a folder with its name."""
    path = Path(ckpt)
    return path.parent.name if path.name == "model.tar" and path.parent.name else path.stem


class _Plan:
    """Which figures there are, of what; what does not fit is said before the first is drawn."""

    def __init__(self, models: dict[str, RNNPB], dataset: Dataset, flags: Flags) -> None:
        self._models = models
        self._by_name = {motion.name: motion for motion in dataset.motions}
        chosen = flags.motions
        self._densities_of = self._motions("--motions", chosen, DENSITIES_OF)
        self._landscapes_of = self._motions("--motions", chosen, LANDSCAPES_OF)
        pattern = None if flags.pattern is None else [flags.pattern]
        self._source = self._motions("--pattern", pattern, (PATTERN_OF,))[0]
        self._flags = flags
        self._stochastic = {name: model for name, model in models.items() if model.stochastic}

    def _motions(
        self, flag: str, chosen: Sequence[str] | None, default: Sequence[str]
    ) -> list[Motion]:
        names = chosen
        if names is None:
            known = all(name in self._by_name for name in default)
            names = default if known else list(self._by_name)[:MOTIONS]
        unknown = [name for name in names if name not in self._by_name]
        if unknown:
            raise InputError(f"{flag}: no motion {unknown[0]!r} in the data that all models know")
        if len(names) > MOTIONS:
            raise InputError(f"{flag}: a figure has room for {MOTIONS} motions, got {len(names)}")
        return [self._by_name[name] for name in names]

    @property
    def steps(self) -> int:
        """Of the progress bar: figures and landscapes."""
        figures = 6 if self._stochastic else 4
        return figures + 2 * len(self._models) * len(self._landscapes_of)

    def figures(self, advance: Callable[[], object]) -> Iterator[tuple[str, Callable[[], Figure]]]:
        """The name of each figure's file and what draws it."""
        from ...core.paper.figures.components import components_figure
        from ...core.paper.figures.densities import densities_figure
        from ...core.paper.figures.landscapes import landscapes_figure

        models = self._models
        if self._stochastic:
            names = [motion.name for motion in self._densities_of]
            yield "figure2", lambda: densities_figure(models, names)
        yield "figure3", lambda: components_figure(models, self._flags.seed)
        yield (
            "figure4_absolute",
            lambda: landscapes_figure(models, self._landscapes_of, "absolute", advance),
        )
        yield "figure4_sd", lambda: landscapes_figure(models, self._landscapes_of, "sd", advance)
        if self._stochastic:
            yield "figure5", self._iterations
        yield "figure6", self._paths

    def _iterations(self) -> Figure:
        """Fig. 5, of the first stochastic model."""
        from ...core.paper.figures.recognition import iterations_figure
        from ...core.recognition import recognize

        name, model = next(iter(self._stochastic.items()))
        target, config = self._pattern(), self._config(trials=1)
        steps = list(recognize(model, target.positions, config))
        shown = sorted({0, *(int(share * config.iterations) for share in (0.45, 0.9))})
        return iterations_figure(name, model, target, steps, shown, config.observed)

    def _paths(self) -> Figure:
        """Fig. 6."""
        from ...core.paper.figures.recognition import paths_figure
        from ...core.recognition import recognize
        from ...core.recognition_run import RecognitionResult

        target, config = self._pattern(), self._config(trials=TRIALS)
        return paths_figure(
            {
                name: (
                    model,
                    RecognitionResult.from_steps(recognize(model, target.positions, config)),
                )
                for name, model in self._models.items()
            }
        )

    def _pattern(self) -> Motion:
        from ...core.paper.novel_patterns import novel_pattern

        return novel_pattern(self._source, self._flags.seed)

    def _config(self, trials: int) -> RecognitionConfig:
        from ...core.recognition_run import RecognitionConfig

        return RecognitionConfig(
            init=self._flags.init,
            iterations=self._flags.iterations,
            trials=trials,
            seed=self._flags.seed,
        )
