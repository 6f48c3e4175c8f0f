"""Train a shipped checkpoint with the kernel: `python scripts/fast_training/train.py strong DATA`.

`rnnpb train --recipe strong` learns the same way on any machine.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import torch
from packed_lstm import QUICK, PackedTrainer

from rnnpb_explorer.core.checkpoint import load_checkpoint, read_plain, save_checkpoint
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.files import check_writable
from rnnpb_explorer.core.recipes import RECIPES, record
from rnnpb_explorer.robot.data import load_dataset


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=RECIPES)
    parser.add_argument("data", help="REBL-Pepper's data_raw.csv, or a folder of motions")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--save-every", type=int, default=250, metavar="EPOCHS")
    arguments = parser.parse_args()
    check_writable(arguments.out)
    torch.set_num_threads(1)

    dataset = load_dataset(arguments.data)
    recipe = RECIPES[arguments.name]
    trainer = PackedTrainer(dataset, recipe.model, recipe.training)
    precision = trainer.precision
    if arguments.name == "strong":  # its error is far above what bfloat16 adds
        trainer.exact_from, precision = 1.0, QUICK
    unfinished = arguments.out.with_suffix(".resume.pt")
    before = 0.0
    if unfinished.exists():
        state = read_plain(unfinished)["resume"]
        if state["data_sha256"] != dataset.sha256:
            raise InputError(f"{unfinished} was begun on other data")
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
            own = {
                "seconds": before + time.monotonic() - started,
                "data_sha256": dataset.sha256,
            }
            save_checkpoint(trainer.model, unfinished, resume=trainer.state() | own)
    model = trainer.model
    seconds = round(before + time.monotonic() - started, 1)
    record(model, dataset, recipe.training, seconds=seconds, precision=precision)
    model.info.attribution = f"learnt from {dataset.attribution}"
    save_checkpoint(model, arguments.out)
    unfinished.unlink(missing_ok=True)
    print(model.info.metrics)


if __name__ == "__main__":
    main()
