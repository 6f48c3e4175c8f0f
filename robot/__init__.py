"""Pepper and other robots: joints, description, motion to joint rotations, the 3D view."""
