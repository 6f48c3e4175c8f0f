"""What the checkpoints that the paper's authors published mean without saying it."""

from __future__ import annotations

# The outputs of their network, in its order: the joints of REBL-Pepper.
PUBLISHED_JOINTS = (
    "HeadPitch",
    "HeadYaw",
    "HipPitch",
    "HipRoll",
    "KneePitch",
    "LElbowRoll",
    "LElbowYaw",
    "LHand",
    "LShoulderPitch",
    "LShoulderRoll",
    "LWristYaw",
    "RElbowRoll",
    "RElbowYaw",
    "RHand",
    "RShoulderPitch",
    "RShoulderRoll",
    "RWristYaw",
)
