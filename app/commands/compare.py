"""`rnnpb compare`: how smooth latent spaces are, over the same pairs of motions."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

from cyclopts import Parameter

from ...core.errors import InputError
from ...core.files import check_writable
from .flags import Checkpoints, Seed, load_model, read_by, whole
from .progress import progress_bar
from .tables import print_table, smoothness_table, write_json


def run(
    *,
    ckpt: Checkpoints,
    motion: Annotated[str | None, Parameter(help="one end of the pairs; default: any")] = None,
    to: Annotated[str | None, Parameter(help="the other end; default: several others")] = None,
    pairs: Annotated[
        int, read_by(whole(1, 1_000)), Parameter(help="how many, where not both ends are given")
    ] = 24,
    seed: Seed = 0,
    json: str | None = None,
) -> None:
    """Print how smooth each model is: absolute, and per standard deviation of its learned mu.

    Args:
        json: write the table to this file, too
    """
    if json is not None:
        check_writable(json)
    if to is not None and motion is None:
        raise InputError("--to needs --motion: the other end of the pair")
    models = [load_model(checkpoint)[0] for checkpoint in ckpt]

    from ...core.comparison import shared_pairs, smoothness

    chosen = shared_pairs(models, motion, to, pairs, seed)
    rows: list[dict[str, Any]] = []
    with progress_bar() as bar:
        task = bar.add_task("comparing", total=len(models) * len(chosen))
        for checkpoint, model in zip(ckpt, models, strict=True):
            measured = smoothness(model, chosen, lambda: bar.advance(task))
            facts = {
                "checkpoint": checkpoint,
                "behavior": model.config.behavior,
                "beta": model.config.beta,
                "pb_dim": model.config.pb_dim,
            }
            rows.append(facts | asdict(measured))
    print_table(smoothness_table(rows, len(chosen)))
    if json is not None:
        write_json(json, {"pairs": chosen, "models": rows})
