"""Motions from files as people have them."""

from .raw import Unclear, Unit
from .reader import SUFFIXES, Reading, Said, joints_in, read_file, read_motion, read_motions
from .units import Hands

__all__ = [
    "SUFFIXES",
    "Hands",
    "Reading",
    "Said",
    "Unclear",
    "Unit",
    "joints_in",
    "read_file",
    "read_motion",
    "read_motions",
]
