"""Muon: momentum whose matrix is orthogonalised before it is applied.

K. Jordan et al., "Muon: An optimizer for hidden layers in neural networks" (2024). Every direction
of a weight matrix learns at the same speed, which Adam's element-wise scaling cannot give.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import torch
from torch import Tensor

_NEWTON_SCHULZ = (3.4445, -4.7750, 2.0315)  # the quintic that the authors tuned for speed
_STEPS = 5


def orthogonalize(matrix: Tensor) -> Tensor:
    """Nearly U V^T of each matrix U S V^T of a batch (..., m, n): singular values of 0.7 to 1.2."""
    a, b, c = _NEWTON_SCHULZ
    tall = matrix.shape[-2] > matrix.shape[-1]
    x = matrix.mT if tall else matrix
    x = x / (torch.linalg.matrix_norm(x, keepdim=True) + 1e-7)
    x = x.bfloat16()  # a few bits are enough: the values are only pushed towards 1
    for _ in range(_STEPS):
        gram = x @ x.mT
        x = a * x + (b * gram + c * gram @ gram) @ x
    result: Tensor = x.mT if tall else x
    return result.to(matrix.dtype)


class Muon(torch.optim.Optimizer):
    """Muon with Nesterov momentum for matrices that stack ``blocks`` of rows.

    An LSTM's four gates share one weight matrix but are four maps: each is orthogonalised alone.
    """

    def __init__(
        self, params: Iterable[Tensor], lr: float, momentum: float = 0.95, blocks: int = 1
    ) -> None:
        super().__init__(params, {"lr": lr, "momentum": momentum, "blocks": blocks})

    @torch.no_grad()
    def step(self, closure: Any = None) -> None:  # type: ignore[override]
        for group in self.param_groups:
            for parameter in group["params"]:
                if parameter.grad is not None:
                    self._update(parameter, parameter.grad, group)

    def _update(self, parameter: Tensor, gradient: Tensor, group: dict[str, Any]) -> None:
        state = self.state[parameter]
        if not state:
            state["momentum"] = torch.zeros_like(parameter)
        average: Tensor = state["momentum"]
        average.lerp_(gradient, 1 - group["momentum"])
        ahead = gradient.lerp(average, group["momentum"])  # Nesterov
        blocks = ahead.unflatten(0, (group["blocks"], -1))  # (blocks, rows, columns)
        parameter.sub_(orthogonalize(blocks).flatten(0, 1), alpha=group["lr"])
