"""Motions from files as people have them."""

from .columns import NoJoints
from .files import SUFFIXES
from .raw import Unclear, Unit
from .reader import NOTHING_SAID, Reading, Said, joints_in, read_file, read_motion, read_motions
from .units import Hands

__all__ = [
    "NOTHING_SAID",
    "SUFFIXES",
    "Hands",
    "NoJoints",
    "Reading",
    "Said",
    "Unclear",
    "Unit",
    "joints_in",
    "read_file",
    "read_motion",
    "read_motions",
]
