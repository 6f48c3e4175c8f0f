"""`rnnpb recognize`: find the PB that explains a motion."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.errors import InputError
from ...core.files import check_writable, replacing
from ...core.motion import Motion
from ...robot.importing import read_motion
from .command import (
    Command,
    add_checkpoint,
    add_device,
    add_init,
    add_seed,
    add_unit,
    load_model,
    real,
    whole,
)
from .progress import steps_bar

if TYPE_CHECKING:
    from ...core.model import RNNPB
    from ...core.recognition_run import RecognitionStep

MAX_CANDIDATES = 100_000
MAX_ITERATIONS = 100_000
MAX_TRIALS = 1_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_checkpoint(parser)
    parser.add_argument("motion", metavar="x.csv", help="the motion to recognise")
    add_unit(parser)
    add_init(parser, default="learned")
    parser.add_argument(
        "--candidates",
        type=whole(1, MAX_CANDIDATES),
        default=100,
        help="draws of the warm start random; default: 100",
    )
    parser.add_argument(
        "--observed",
        type=real(above=0.0, maximum=1.0),
        default=0.8,
        help="share of the frames that is seen; default: 0.8",
    )
    parser.add_argument("--iterations", type=whole(1, MAX_ITERATIONS), default=100)
    parser.add_argument("--trials", type=whole(1, MAX_TRIALS), default=10)
    parser.add_argument(
        "--method",
        choices=("paper", "lm"),
        default="paper",
        help="paper: the published procedure (default); lm: Levenberg-Marquardt without sampling, "
        "its trials start from the closest learned mu",
    )
    add_seed(parser)
    add_device(parser)
    parser.add_argument("--out", required=True, metavar="R.npz")


def run(arguments: argparse.Namespace, read: Callable[..., Motion] = read_motion) -> None:
    """`read` takes the arguments of `read_motion`, and may know more kinds of files."""
    out = Path(arguments.out)
    if out.suffix.lower() != ".npz":
        raise InputError(f"--out {out}: the name of a result ends in .npz")
    check_writable(out)
    model, _ = load_model(arguments.ckpt)
    motion = read(arguments.motion, model.info.joints, fps=model.info.fps, unit=arguments.unit)

    from ...core.device import choose_device
    from ...core.recognition_run import RecognitionResult

    model.to(choose_device(arguments.device))
    steps = _steps(model, motion, arguments)
    result = RecognitionResult.from_steps(steps_bar(steps, arguments.iterations, "recognising"))
    with replacing(out) as beside:
        result.save(beside)
    trials, iterations = result.loss.shape
    print(f"{trials} trials of {iterations} iterations: {out}")
    for what in ("reconstruction_loss", "prediction_error"):
        last, best = getattr(result, what), getattr(result, f"best_{what}")
        print(
            f"{what.replace('_', ' ')}: last iterate {last.mean():.6f} (sd {last.std():.6f}), "
            f"best iterate {best.mean():.6f} (sd {best.std():.6f}), "
            f"best trial {best[result.best_trial]:.6f}"
        )


def _steps(
    model: RNNPB, motion: Motion, arguments: argparse.Namespace
) -> Iterator[RecognitionStep]:
    from ...core.recognition import recognize
    from ...core.recognition_lm import LMConfig, recognize_lm
    from ...core.recognition_run import RecognitionConfig

    if arguments.method == "lm":
        lm = LMConfig(arguments.trials, arguments.observed, arguments.iterations)
        return recognize_lm(model, motion.positions, lm)
    config = RecognitionConfig(
        init=arguments.init,
        candidates=arguments.candidates,
        observed=arguments.observed,
        iterations=arguments.iterations,
        trials=arguments.trials,
        seed=arguments.seed,
    )
    return recognize(model, motion.positions, config)


COMMAND = Command("recognize", "Find the PB that explains a motion.", add_arguments, run)
