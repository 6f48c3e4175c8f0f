"""Train a shipped checkpoint with the kernel: `python scripts/fast_training/train.py strong DATA`.

`rnnpb train` learns the same way on any machine.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict
from pathlib import Path

import torch
from packed_lstm import PackedTrainer

from rnnpb_explorer.core.checkpoint import load_checkpoint, read_plain, save_checkpoint
from rnnpb_explorer.core.data import load_dataset
from rnnpb_explorer.core.evaluation import reconstruction, reconstruction_at_mean
from rnnpb_explorer.core.model import ModelConfig
from rnnpb_explorer.core.training import TrainingConfig

PRIORS = {"strong": 1e-3, "weak": 1e-6, "zero": 0.0, "deterministic": None}
PRECISION = (
    "products in bfloat16 summed in float32, forward exact to 2^-16 over the last 40 % of epochs"
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=PRIORS)
    parser.add_argument("data", help="REBL-Pepper's data_raw.csv, or a folder of motions")
    parser.add_argument("--epochs", type=int, default=TrainingConfig.epochs)
    parser.add_argument("--samples", type=int, default=TrainingConfig.samples)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--save-every", type=int, default=250, metavar="EPOCHS")
    arguments = parser.parse_args()
    torch.set_num_threads(1)

    dataset = load_dataset(arguments.data)
    beta = PRIORS[arguments.name]
    behavior = "deterministic" if beta is None else "stochastic"
    recipe = TrainingConfig(arguments.epochs, arguments.samples, arguments.seed)
    trainer = PackedTrainer(dataset, ModelConfig(behavior=behavior, beta=beta), recipe)
    unfinished = arguments.out.with_suffix(".resume.pt")
    before = 0.0
    if unfinished.exists():
        state = read_plain(unfinished)["resume"]
        trainer.restore(load_checkpoint(unfinished), state)
        before = state["seconds"]
    started = time.monotonic()
    for progress in trainer.run():
        if progress.epoch % 100 == 0:
            print(
                f"{progress.epoch} error {progress.error:.7f} KL {progress.kl:.1f} "
                f"{progress.seconds_left:.0f} s left",
                flush=True,
            )
        if progress.epoch % arguments.save_every == 0:
            seconds = {"seconds": before + time.monotonic() - started}
            save_checkpoint(trainer.model, unfinished, resume=trainer.state() | seconds)
    model = trainer.model
    mean, sd = reconstruction(model, dataset.motions, 100, seed=0)
    at_mean = reconstruction_at_mean(model, dataset.motions)
    model.info.attribution = f"learnt from {dataset.attribution}"
    model.info.training = asdict(recipe) | {
        "seconds": round(before + time.monotonic() - started, 1),
        "precision": PRECISION,
        "dataset": dataset.attribution,
        "data_sha256": dataset.sha256,
    }
    model.info.metrics = {
        "reconstruction_mean": mean,
        "reconstruction_sd": sd,
        "reconstruction_samples": 100,
        "reconstruction_at_mean": float(at_mean.mean()),
        "reconstruction_at_mean_worst": float(at_mean.max()),
    }
    save_checkpoint(model, arguments.out)
    unfinished.unlink(missing_ok=True)
    print(f"sampled error {mean:.7f} (sd {sd:.7f}), at sigma = 0 {at_mean.mean():.7f}")


if __name__ == "__main__":
    main()
