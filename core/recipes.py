"""How the shipped checkpoints were trained: a recipe for each condition, and what is recorded."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from .data import Dataset
from .evaluation import reconstruction, reconstruction_at_mean
from .model import RNNPB, ModelConfig
from .training import TrainingConfig

METRIC_SAMPLES = 100  # PBs a motion, as in Table I


@dataclass(frozen=True)
class Recipe:
    """All that a training run takes besides the data."""

    model: ModelConfig
    training: TrainingConfig


RECIPES = {
    # sigma is large: most of a gradient is noise, much of which cancels in mirrored pairs, and a
    # few far samples make most of the error. A short memory of squared gradients (beta2) forgets
    # them between two of their kind, scales them down each time, and lets the KL term win. While
    # the motions find their places, that makes a smoother space; afterwards, a larger error. Slow
    # weights and quick mu help the motions to find their places, too.
    "strong": Recipe(
        ModelConfig(beta=1e-3),
        TrainingConfig(
            epochs=7000,
            samples=2,
            recurrent_rate=0.02,
            learning_rate=0.006,
            pb_rate_factor=4.0,
            sigma_rate_factor=4.0,
            late_beta2=0.999,
        ),
    ),
    "weak": Recipe(ModelConfig(beta=1e-6), TrainingConfig(epochs=7000)),
    # Nothing holds sigma up; at the rate of mu it would end at a tenth of the published one's.
    "zero": Recipe(ModelConfig(beta=0.0), TrainingConfig(epochs=9000, sigma_rate_factor=0.5)),
    "deterministic": Recipe(
        ModelConfig(behavior="deterministic", beta=None), TrainingConfig(epochs=5000)
    ),
}


def record(model: RNNPB, dataset: Dataset, training: TrainingConfig, **facts: str | float) -> None:
    """Put into a trained model how it was trained and how well it learned.

    Args:
        facts: what the recipe does not say: how long it took, on which device, ...
    """
    motions = dataset.motions
    mean, sd = reconstruction(model, motions, METRIC_SAMPLES, seed=0)
    at_mean = reconstruction_at_mean(model, motions)
    model.info.training |= asdict(training) | {
        "dataset": dataset.attribution or f"{len(motions)} motions",
        "data_sha256": dataset.sha256,
        **facts,
    }
    model.info.metrics = {
        "reconstruction_mean": mean,
        "reconstruction_sd": sd,
        "reconstruction_samples": METRIC_SAMPLES,
        "reconstruction_at_mean": float(at_mean.mean()),
        "reconstruction_at_mean_worst": float(at_mean.max()),
    }
