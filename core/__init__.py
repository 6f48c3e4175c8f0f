"""The model and all its numerics: torch and numpy, no screen, no robot."""

from .checkpoint import load_checkpoint, save_checkpoint, shipped_checkpoints
from .errors import InputError
from .model import ModelConfig, ModelInfo, MotionLabel, RNNPB
from .motion import Motion, parse_motion, read_motion, write_motion

__all__ = [
    "RNNPB",
    "InputError",
    "ModelConfig",
    "ModelInfo",
    "Motion",
    "MotionLabel",
    "load_checkpoint",
    "parse_motion",
    "read_motion",
    "save_checkpoint",
    "shipped_checkpoints",
    "write_motion",
]
