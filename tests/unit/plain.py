"""The model stated as plainly as the paper does: one frame after the other."""

from __future__ import annotations

import torch
from torch import Tensor

from rnnpb_explorer.core.model import RNNPB


def plain_generate(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """(T, J) from one PB (D,): an LSTM cell fed with [PB; previous frame], eqs. 6 to 8."""
    weight_input = torch.cat([model.weight_pb, model.weight_frame], dim=1)
    frame = torch.zeros_like(model.bias_out)
    h = c = torch.zeros_like(model.weight_out[0])
    frames = []
    for _ in range(steps):
        gates = weight_input @ torch.cat([pb, frame]) + model.weight_hidden @ h + model.bias
        i, f, g, o = gates.chunk(4)
        c = torch.sigmoid(f) * c + torch.sigmoid(i) * torch.tanh(g)
        h = torch.sigmoid(o) * torch.tanh(c)
        frame = model.weight_out @ h + model.bias_out
        frames.append(frame)
    return torch.stack(frames)
