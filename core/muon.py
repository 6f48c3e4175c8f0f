"""Muon: momentum whose every direction steps by the same length (K. Jordan et al., 2024).

The step of a matrix is the nearest orthogonal one to its momentum, by the quintic Newton-Schulz
iteration of https://kellerjordan.github.io/posts/muon. torch.optim.Muon always works in bfloat16.
A processor without units for it emulates these products and takes 30 to 50 times as long as in
float32; where there are such units without tiles (AVX512-BF16), float32 takes about as long.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import torch
from torch import Tensor

COEFFICIENTS = (3.4445, -4.7750, 2.0315)  # of X, X X^T X and (X X^T)^2 X
ITERATIONS = 5
TINY = 1e-7  # a norm that is no longer divided by

Each = Callable[[Callable[[Tensor], Tensor], Iterable[Tensor]], Iterable[Tensor]]


class Muon(torch.optim.Optimizer):
    """Nesterov momentum, orthogonalised; no weight decay.

    Args:
        params: matrices (M N, N), each a stack of M square ones that are orthogonalised one by one.
        lr: spectral norm of a step, about.
        matrices: M; an LSTM's four gates share a parameter but are four maps.
        dtype: of the products.
        each: applies a function to every matrix; `map`, or one that does so on several cores.
    """

    def __init__(
        self,
        params: Iterable[torch.nn.Parameter],
        lr: float,
        momentum: float,
        *,
        matrices: int = 1,
        dtype: torch.dtype = torch.float32,
        each: Each = map,
    ) -> None:
        super().__init__(params, {"lr": lr, "momentum": momentum})
        self._matrices = matrices
        self._orthogonal = partial(orthogonal, dtype=dtype)
        self._each = each

    @torch.no_grad()
    def step(self, closure: Any = None) -> None:  # type: ignore[override]
        for group in self.param_groups:
            for parameter in group["params"]:
                gradient = parameter.grad
                if gradient is None:
                    continue
                state = self.state[parameter]
                if not state:
                    state["momentum_buffer"] = torch.zeros_like(gradient)
                momentum = state["momentum_buffer"].lerp_(gradient, 1 - group["momentum"])
                ahead = gradient.lerp(momentum, group["momentum"])
                steps = self._each(self._orthogonal, ahead.chunk(self._matrices))
                parameter.sub_(torch.cat(list(steps)), alpha=group["lr"])


def orthogonal(matrix: Tensor, dtype: torch.dtype = torch.float32) -> Tensor:
    """A square matrix (N, N) with its singular values brought to between 0.7 and 1.2, about.

    Those below a hundredth of the norm end lower.
    """
    a, b, c = COEFFICIENTS
    x = matrix.to(dtype)
    x = x / x.norm().clamp(min=TINY)
    for _ in range(ITERATIONS):
        gram = x @ x.T
        x = torch.addmm(x, torch.addmm(gram, gram, gram, beta=b, alpha=c), x, beta=a)
    return x.to(matrix)
