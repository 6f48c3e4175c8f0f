"""A landscape's 400 motions: in batches against one by one; the engine against bare products."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np
import torch
from bench_generation import frame_by_frame
from pages import Pages
from timing import Table, bare_products, best_of
from torch import Tensor

from rnnpb_explorer.app.state.document import target_of_motion
from rnnpb_explorer.core.correlation import landscape, landscape_stages, pearson
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.core.windows import plane, unit_directions

SOME = slice(None, None, 20)  # every twentieth cell, where all would take minutes
ROUNDS = 20


def run(model: RNNPB) -> Table:
    target = model.generate(model.mu[:1], 140)[0]
    center = model.mu[0].numpy()
    cells = torch.as_tensor(plane(center, unit_directions(model.config.pb_dim, (0, 1)))[0])
    pbs = cells.float().flatten(0, 1)  # (400, D)

    def one_by_one(generate: Callable[[RNNPB, Tensor, int], Tensor]) -> Tensor:
        return torch.cat([pearson(generate(model, pb[None], 140), target) for pb in pbs[SOME]])

    published = 20 * best_of(lambda: one_by_one(frame_by_frame), at_least=1)
    folded = 20 * best_of(lambda: one_by_one(RNNPB.generate), at_least=1)
    batched = best_of(lambda: landscape(model, target, center))
    coarse = best_of(lambda: next(landscape_stages(model, target, center)))
    table = Table("Landscape, 20x20 motions of 140 frames", "one by one", "batched")
    table.row("frame by frame / folded", published, batched, aim=60)
    table.row("folded / folded", folded, batched)
    table.row("frame by frame / coarse stage", published, coarse)
    correlation = landscape(model, target, center).correlation.reshape(-1)[SOME]
    difference = np.abs(one_by_one(frame_by_frame).numpy() - correlation).max()
    table.note(f"largest difference {difference:.1e}; one by one: a twentieth of it was run")
    table.note(through_the_engine(model, target))
    return table


def through_the_engine(model: RNNPB, target: Tensor) -> str:
    """Both stages on all workers, without the rest between them, against the products they need."""
    bare, engine = bare_products(model, 400, 140), Pages(model, rest_seconds=0.0)
    given = target_of_motion(Motion("given", model.info.joints, target.numpy()))
    times: dict[str, list[float]] = {"bare": [], "engine": []}
    for number in range(ROUNDS):
        work = engine.landscape(number, given)
        for name, run in (("bare", bare), ("engine", partial(engine.complete, work))):
            start = time.perf_counter()
            run()
            times[name].append(time.perf_counter() - start)
    engine.close()
    plain, quick = (min(times[name]) for name in ("bare", "engine"))
    ratios = sorted(b / a for a, b in zip(times["bare"], times["engine"], strict=True))
    return (
        f"through the engine, {engine.workers} workers: {1e3 * quick:.0f} ms; "
        f"140 products of (400, 256) by (256, 1024) on {torch.get_num_threads()} threads: "
        f"{1e3 * plain:.0f} ms; ratio {quick / plain:.2f}, "
        f"median of {ROUNDS} pairs {ratios[len(ratios) // 2]:.2f} (at most 1.15)"
    )
