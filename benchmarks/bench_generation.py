"""Folded generation with a fused kernel against one frame after the other."""

from __future__ import annotations

from collections.abc import Callable

import torch
from timing import Table, bare_products, best_of
from torch import Tensor

from rnnpb_explorer.core.model import RNNPB


def frame_by_frame(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """A cell called once a frame on [previous frame, PB].

    The published code calls nn.LSTM there, which oneDNN makes several times slower still on one
    frame: its weights are packed anew in every call. That would flatter the ratio.
    """
    weight = torch.cat([model.weight_frame, model.weight_pb], dim=1)
    zeros = torch.zeros_like(model.bias)
    h = c = pb.new_zeros(len(pb), model.config.hidden_size)
    frame = pb.new_zeros(len(pb), model.config.num_joints)
    frames = []
    for _ in range(steps):
        inputs = torch.cat([frame, pb], dim=1)
        h, c = torch.lstm_cell(inputs, (h, c), weight, model.weight_hidden, model.bias, zeros)
        frame = h @ model.weight_out.T + model.bias_out
        frames.append(frame)
    return torch.stack(frames, dim=1)


def gradient(
    generate: Callable[[RNNPB, Tensor, int], Tensor], model: RNNPB, pb: Tensor, steps: int
) -> Tensor:
    leaf = pb.clone().requires_grad_()
    return torch.autograd.grad(generate(model, leaf, steps).square().sum(), leaf)[0]


def run(model: RNNPB) -> Table:
    pb, steps = model.mu[:1], 140
    table = Table("Generation of one motion, 140 frames", "frame by frame", "folded")
    difference = (frame_by_frame(model, pb, steps) - model.generate(pb, steps)).abs().max().item()
    motion = best_of(lambda: model.generate(pb, steps))
    slope = best_of(lambda: gradient(RNNPB.generate, model, pb, steps))
    table.row("motion", best_of(lambda: frame_by_frame(model, pb, steps)), motion, aim=12)
    table.row(
        "gradient with respect to the PB",
        best_of(lambda: gradient(frame_by_frame, model, pb, steps)),
        slope,
        aim=15,
    )
    products = best_of(bare_products(model, 1, steps))
    table.limit("motion", motion, products)
    table.limit("gradient", slope, 3 * products)
    table.note(f"largest difference {difference:.1e}")
    return table
