"""Training on one core with AMX: the whole epoch as one packed batch in a kernel of our own.

About four times as fast as `rnnpb train` on one such core. It needs g++ and an Intel processor
of the Sapphire Rapids generation or later; the recipe and the loss are those of core/training.py.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import torch
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.training import Trainer

HIDDEN = 256  # the kernel is written for this many units
QUICK = "products in bfloat16 summed in float32"
EXACT = f"{QUICK}, forward exact to 2^-16 over the last 40 % of epochs"
SAVED = 6  # values a unit and frame that the forward pass keeps for the way back


@cache
def build() -> ctypes.CDLL:
    """Compile the kernel and ask the system for the tile registers.

    Raises:
        OSError, subprocess.CalledProcessError: no compiler, or a processor without AMX.
    """
    source = Path(__file__).with_name("packed_lstm.cpp")
    flags = ["-O3", "-march=sapphirerapids", "-std=c++17", "-shared", "-fPIC"]
    with tempfile.TemporaryDirectory() as folder:  # once loaded, the file is not needed
        library = str(Path(folder) / "packed_lstm.so")
        subprocess.run(["g++", *flags, str(source), "-o", library], check=True)
        kernel = ctypes.CDLL(library)
    if kernel.use_tiles() != 0:
        raise OSError("this processor or system has no AMX tiles")
    return kernel


def _pointer(array: Tensor) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.data_ptr())


class PackedLSTM(torch.autograd.Function):
    """h (F, H) of all frames; see packed_lstm.cpp for the shapes and the order of frames."""

    @staticmethod
    def forward(
        ctx: Any,
        first: Tensor,
        later: Tensor,
        weight: Tensor,
        active: Tensor,
        kernel: ctypes.CDLL,
        exact: bool,
    ) -> Tensor:
        first, later, weight = first.contiguous(), later.contiguous(), weight.contiguous()
        frames, motions = int(active.sum()), len(first)
        h = torch.empty(frames, HIDDEN)
        h_before = torch.empty(frames - motions, HIDDEN, dtype=torch.bfloat16)
        saved = torch.empty(frames, SAVED * HIDDEN, dtype=torch.bfloat16)
        arrays = (first, later, weight, active)
        outputs = (h, h_before, saved)
        kernel.forward(*map(_pointer, arrays), len(active), int(exact), *map(_pointer, outputs))
        ctx.save_for_backward(weight, active, h_before, saved)
        ctx.kernel = kernel
        return h

    @staticmethod
    def backward(ctx: Any, grad_h: Tensor) -> tuple[Tensor | None, ...]:  # type: ignore[override]
        weight, active, h_before, saved = ctx.saved_tensors
        grad_h = grad_h.contiguous()
        motions = int(active[0])
        gates = torch.empty(len(grad_h), 4 * HIDDEN, dtype=torch.bfloat16)
        first, later = torch.empty(2, motions, 4 * HIDDEN)
        arrays = (grad_h, weight, active)
        outputs = (saved, gates, first, later)
        ctx.kernel.backward(*map(_pointer, arrays), len(active), *map(_pointer, outputs))
        grad_weight = (h_before.T @ gates[motions:]).T.float()
        return first, later, grad_weight, None, None, None


class PackedTrainer(Trainer):
    """A `Trainer` whose epochs run in the kernel."""

    precision: ClassVar[str] = EXACT
    muon_dtype: ClassVar[torch.dtype] = torch.bfloat16  # tiles multiply it ten times as fast
    exact_from = 0.6  # the share of a run after which the forward pass is exact to 2^-16

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        if self.model.config.hidden_size != HIDDEN:
            raise InputError(f"the kernel is made for {HIDDEN} units")
        if self.model.mu.device.type != "cpu":
            raise InputError("the kernel runs on a processor; --device cpu")
        self._kernel = build()
        targets = {  # by motion
            int(row): target[: int(mask.sum())]
            for bucket in self._buckets
            for row, target, mask in zip(bucket.rows, bucket.target, bucket.mask, strict=True)
        }
        samples = self.training.samples if self.model.stochastic else 1
        rows = [  # every sample of a motion is a sequence, S N of them
            row
            for row in sorted(targets, key=lambda row: -len(targets[row]))
            for _ in range(samples)
        ]
        # Where they lie in PBs (S, N, D) without their first axis.
        offsets = torch.arange(samples).repeat(len(targets)) * len(targets)
        self._order = torch.tensor(rows) + offsets
        padded = pad_sequence([targets[row] for row in rows])  # (T, S N, J)
        lengths = torch.tensor([len(targets[row]) for row in rows])
        running = torch.arange(len(padded))[:, None] < lengths  # (T, S N)
        self._active = running.sum(dim=1).int()
        self._target = padded[running]  # (F, J)

    def generate_packed(self, pb: Tensor, exact: bool) -> Tensor:
        """(F, J): `RNNPB.generate` for PBs (S, N, D) at once, each to its motion's length."""
        model = self.model
        first = pb.flatten(0, 1)[self._order] @ model.weight_pb.T + model.bias
        later = first + model.weight_frame @ model.bias_out
        folded = model.weight_hidden + model.weight_frame @ model.weight_out
        h = PackedLSTM.apply(first, later, folded, self._active, self._kernel, exact)
        return torch.addmm(model.bias_out, h, model.weight_out.T)

    def _backward_error(self, pb: Tensor) -> float:
        exact = self.epoch > self.exact_from * self.training.epochs
        error = self.generate_packed(pb, exact) - self._target
        loss = error.square().sum() / (self._frames * len(pb))
        loss.backward()
        return loss.item()
