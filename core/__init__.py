"""The model and all its numerics: torch and numpy, no screen, no robot.

Names are imported on first use: torch takes seconds, and `rnnpb --help` or a mistyped flag should
not wait for it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .checkpoint import load_checkpoint, save_checkpoint, shipped_checkpoints
    from .codebook import Codebook, complete_codebook
    from .correlation import landscape
    from .data import Dataset
    from .errors import InputError
    from .following import Follower
    from .model import RNNPB, ModelConfig, ModelInfo
    from .motion import Motion, MotionLabel, write_motion
    from .recognition import recognize
    from .recognition_lm import LMConfig, recognize_lm
    from .recognition_run import RecognitionConfig, RecognitionResult
    from .verdict import explained
    from .windows import Landscape

__all__ = [
    "RNNPB",
    "Codebook",
    "Dataset",
    "Follower",
    "InputError",
    "LMConfig",
    "Landscape",
    "ModelConfig",
    "ModelInfo",
    "Motion",
    "MotionLabel",
    "RecognitionConfig",
    "RecognitionResult",
    "complete_codebook",
    "explained",
    "landscape",
    "load_checkpoint",
    "recognize",
    "recognize_lm",
    "save_checkpoint",
    "shipped_checkpoints",
    "write_motion",
]

_MODULES = {
    "checkpoint": ("load_checkpoint", "save_checkpoint", "shipped_checkpoints"),
    "codebook": ("Codebook", "complete_codebook"),
    "correlation": ("landscape",),
    "data": ("Dataset",),
    "errors": ("InputError",),
    "following": ("Follower",),
    "model": ("RNNPB", "ModelConfig", "ModelInfo"),
    "motion": ("Motion", "MotionLabel", "write_motion"),
    "recognition": ("recognize",),
    "recognition_lm": ("LMConfig", "recognize_lm"),
    "recognition_run": ("RecognitionConfig", "RecognitionResult"),
    "verdict": ("explained",),
    "windows": ("Landscape",),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value
