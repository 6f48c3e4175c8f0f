"""Where torch computes: the processor or a GPU."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Literal, get_args

from .errors import InputError

if TYPE_CHECKING:
    import torch

Device = Literal["auto", "cpu", "cuda"]
DEVICES: tuple[Device, ...] = get_args(Device)


def choose_device(name: str) -> torch.device:
    """The device that `--device` names; `auto` takes a GPU where there is one.

    A GPU is made ready for this model: it computes in float32, as the processor does.

    Raises:
        InputError: no such device, or torch sees no GPU here.
    """
    import torch  # takes seconds; the names above are needed at once

    if name not in DEVICES:
        raise InputError(f"no device {name!r}; there are: {', '.join(DEVICES)}")
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    if name == "cuda" and not torch.cuda.is_available():
        raise InputError("device cuda: torch finds no GPU on this machine; auto or cpu will do")
    if name == "cuda":
        # Rounded to TF32, a closed loop drifts, by up to 0.02 radians as emulated for zero.pt.
        torch.backends.cudnn.allow_tf32 = False
        # Folded weights (`RNNPB.generate`) are new at every call and never one block of memory.
        warnings.filterwarnings("ignore", message="RNN module weights are not part of single")
    return torch.device(name)
