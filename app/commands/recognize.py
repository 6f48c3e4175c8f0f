"""`rnnpb recognize`: find the PB that explains a motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from ...core.errors import InputError
from ...core.files import check_writable, replacing
from ...core.motion import Motion
from ...core.verdict import explained, explained_words
from .codebooks import whole_codebook
from .flags import (
    FLAGS,
    Checkpoint,
    DeviceName,
    FileFlags,
    Joints,
    MotionInFile,
    Seed,
    WarmStart,
    joint_indices,
    load_model,
    read_by,
    read_target,
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


@FLAGS
@dataclass(frozen=True, kw_only=True)
class Settings:
    """How to recognise.

    Args:
        candidates: draws of the warm start random
        observed: share of the frames that is seen
        method: global is Levenberg-Marquardt without sampling, whose trials start from the closest
            entries of a codebook, which is made once a model; lm the same from the closest learned
            mu; paper is the published procedure, which --init asks for, too
        joints: that are seen, by name; the others are inferred
        beta: weight of the KL term, which is no part of what is minimised by default
    """

    init: WarmStart | None = None
    candidates: Annotated[int, read_by(whole(1, MAX_CANDIDATES))] = 100
    observed: Annotated[float, read_by(real(above=0.0, maximum=1.0))] = 0.8
    iterations: Annotated[int, read_by(whole(1, MAX_ITERATIONS))] = 100
    trials: Annotated[int, read_by(whole(1, MAX_TRIALS))] = 10
    method: Literal["global", "lm", "paper"] | None = None
    joints: Joints = ()
    beta: Annotated[float, read_by(real(0.0, 1e6))] = 0.0
    seed: Seed = 0

    @property
    def chosen(self) -> Literal["global", "lm", "paper"]:
        """The method; a warm start belongs to the published one."""
        if self.init is not None and self.method not in (None, "paper"):
            raise InputError(f"--init is a matter of --method paper, not of {self.method}")
        return self.method or ("paper" if self.init else "global")


def run(
    path: Path,
    /,
    settings: Settings | None = None,
    file: FileFlags | None = None,
    *,
    ckpt: Checkpoint,
    motion: MotionInFile = None,
    device: DeviceName = "auto",
    out: Path,
) -> None:
    """Write every trial's path, and print how well they explain the motion, and the verdict.

    Args:
        path: the file with the motion to recognise
        out: R.npz
    """
    settings = settings or Settings()
    method = settings.chosen
    if out.suffix.lower() != ".npz":
        raise InputError(f"--out {out}: the name of a result ends in .npz")
    check_writable(out)
    model, _ = load_model(ckpt)
    info = model.info
    target = read_target(path, info.joints, info.fps, file or FileFlags(), motion)

    seen = joint_indices(settings.joints, info.joints)

    from ...core.device import choose_device
    from ...core.observation import Observation
    from ...core.recognition_run import RecognitionResult

    model.to(choose_device(device))
    Observation.of(model, target.positions, settings.observed, seen)  # or it is refused now
    steps = _steps(model, target, settings, method, seen)
    result = RecognitionResult.from_steps(steps_bar(steps, settings.iterations, "recognising"))
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
    observed = int(settings.observed * len(target))
    best_output = result.best_output[result.best_trial]
    share = explained(best_output, target.positions, observed, seen or None)
    print(f"{share.verdict}: {explained_words(share)}")


def _steps(
    model: RNNPB, motion: Motion, settings: Settings, method: str, joints: tuple[int, ...]
) -> Iterator[RecognitionStep]:
    from ...core.recognition import recognize
    from ...core.recognition_lm import LMConfig, recognize_lm
    from ...core.recognition_run import RecognitionConfig

    if method != "paper":
        lm = LMConfig(
            settings.trials,
            settings.observed,
            settings.iterations,
            joints=joints,
            beta=settings.beta,
        )
        codebook = whole_codebook(model) if method == "global" else None
        return recognize_lm(model, motion.positions, lm, codebook=codebook)
    config = RecognitionConfig(
        init=settings.init or "learned",
        candidates=settings.candidates,
        observed=settings.observed,
        iterations=settings.iterations,
        trials=settings.trials,
        seed=settings.seed,
        joints=joints,
        beta=settings.beta,
    )
    return recognize(model, motion.positions, config)
