"""A landscape's 400 motions in batches against one after the other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from bench_generation import frame_by_frame
from timing import Table, best_of
from torch import Tensor

from rnnpb_explorer.core.correlation import landscape, landscape_stages, pearson
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.windows import plane, unit_directions

SOME = slice(None, None, 20)  # every twentieth cell, where all would take minutes


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
    table.row("frame by frame / folded", published, batched)
    table.row("folded / folded", folded, batched)
    table.row("frame by frame / coarse stage", published, coarse)
    correlation = landscape(model, target, center).correlation.reshape(-1)[SOME]
    difference = np.abs(one_by_one(frame_by_frame).numpy() - correlation).max()
    table.note(f"largest difference {difference:.1e}; one by one: a twentieth of it was run")
    return table
