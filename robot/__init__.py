"""Pepper and other robots: joints, data, description, motion to joint rotations, the 3D view."""

from .data import load_dataset

__all__ = ["load_dataset"]
