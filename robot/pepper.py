"""Pepper: its joints, its mirror image, where it stands, and the LEDs around its eyes."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np

from ..core.data import MIRROR_SUFFIX
from ..core.motion import Motion
from ..core.published import PUBLISHED_JOINTS

PEPPER_URDF = Path(str(files("rnnpb_explorer.static"))) / "pepper" / "pepper.urdf"
PEPPER_JOINTS = PUBLISHED_JOINTS  # those that REBL-Pepper moves, in its order
# Joints whose axis lies in or normal to the sagittal plane turn the other way in a mirror.
_SIGN_FLIPPED = {"HeadYaw", "HipRoll"} | {
    side + joint for side in "LR" for joint in ("ShoulderRoll", "ElbowRoll", "ElbowYaw", "WristYaw")
}
_TWIN = {"L": "R", "R": "L"}

# Pepper's standing posture, radians; the hands are openings.
PEPPER_STAND = {
    "HeadYaw": 0.0,
    "HeadPitch": -0.2,
    "HipRoll": 0.0,
    "HipPitch": -0.04,
    "KneePitch": 0.0,
    "LShoulderPitch": 1.56,
    "LShoulderRoll": 0.14,
    "LElbowYaw": -1.23,
    "LElbowRoll": -0.52,
    "LWristYaw": 0.0,
    "LHand": 0.6,
    "RShoulderPitch": 1.56,
    "RShoulderRoll": -0.14,
    "RElbowYaw": 1.23,
    "RElbowRoll": 0.52,
    "RWristYaw": 0.0,
    "RHand": 0.6,
}

EYE_LEDS = 8  # around each eye; a column each for the intensities of red, green and blue
EYE_COLUMNS = tuple(f"{side}{led}{c}" for side in "RL" for led in range(EYE_LEDS) for c in "RGB")


def mirror(motion: Motion) -> Motion:
    """The motion of Pepper as in a mirror: arms swapped, sideways turns reversed."""
    index = {joint: i for i, joint in enumerate(motion.joints)}
    mirrored = np.empty_like(motion.positions)
    for joint, column in index.items():
        twin = _TWIN.get(joint[0], joint[0]) + joint[1:]
        values = motion.positions[:, index.get(twin, column)]
        mirrored[:, column] = -values if joint in _SIGN_FLIPPED else values
    return Motion(motion.name + MIRROR_SUFFIX, motion.joints, mirrored, motion.fps)
