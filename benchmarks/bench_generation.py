"""Folded generation with a fused kernel against one frame after the other."""

from __future__ import annotations

from collections.abc import Callable

import torch
from timing import Table, best_of
from torch import Tensor

from rnnpb_explorer.core.model import RNNPB


def frame_by_frame(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """As the published code does it: nn.LSTM called once a frame on [previous frame, PB]."""
    config = model.config
    lstm = torch.nn.LSTM(config.num_joints + config.pb_dim, config.hidden_size)
    lstm.weight_ih_l0 = torch.nn.Parameter(torch.cat([model.weight_frame, model.weight_pb], dim=1))
    lstm.weight_hh_l0, lstm.bias_ih_l0 = model.weight_hidden, model.bias
    lstm.bias_hh_l0 = torch.nn.Parameter(torch.zeros_like(model.bias))
    lstm.requires_grad_(False)
    state = (torch.zeros(1, len(pb), config.hidden_size),) * 2
    frame = torch.zeros(1, len(pb), config.num_joints)
    frames = []
    for _ in range(steps):
        h, state = lstm(torch.cat([frame, pb[None]], dim=2), state)
        frame = h @ model.weight_out.T + model.bias_out
        frames.append(frame)
    return torch.cat(frames).transpose(0, 1)


def gradient(
    generate: Callable[[RNNPB, Tensor, int], Tensor], model: RNNPB, pb: Tensor, steps: int
) -> Tensor:
    leaf = pb.clone().requires_grad_()
    return torch.autograd.grad(generate(model, leaf, steps).square().sum(), leaf)[0]


def run(model: RNNPB) -> Table:
    pb, steps = model.mu[:1], 140
    table = Table("Generation of one motion, 140 frames", "frame by frame", "folded")
    difference = (frame_by_frame(model, pb, steps) - model.generate(pb, steps)).abs().max().item()
    table.row(
        "motion",
        best_of(lambda: frame_by_frame(model, pb, steps)),
        best_of(lambda: model.generate(pb, steps)),
    )
    table.row(
        "gradient with respect to the PB",
        best_of(lambda: gradient(frame_by_frame, model, pb, steps)),
        best_of(lambda: gradient(RNNPB.generate, model, pb, steps)),
    )
    table.note(f"largest difference {difference:.1e}")
    return table
