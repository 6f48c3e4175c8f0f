"""Makes the example motions in static/examples: gestures drawn by hand, as key postures over time.

They are nobody's recordings: the numbers below are all that there is to them.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from rnnpb_explorer.core.data import PEPPER_JOINTS
from rnnpb_explorer.core.motion import Motion, write_motion

FPS = 25.0
STANDING = {
    "HeadPitch": -0.15,
    "HipPitch": -0.03,
    "LShoulderPitch": 1.55,
    "RShoulderPitch": 1.55,
    "LShoulderRoll": 0.14,
    "RShoulderRoll": -0.14,
    "LElbowRoll": -0.52,
    "RElbowRoll": 0.52,
    "LElbowYaw": -1.22,
    "RElbowYaw": 1.22,
    "LHand": 0.6,
    "RHand": 0.6,
}
Keys = list[tuple[float, dict[str, float]]]  # seconds, and what differs from standing


def wave() -> Keys:
    """The right hand goes up and waves three times."""
    up = {
        "RShoulderPitch": -0.6,
        "RShoulderRoll": -0.35,
        "RElbowYaw": 1.6,
        "RWristYaw": 0.2,
        "RHand": 0.95,
        "HeadYaw": -0.15,
        "HeadPitch": -0.3,
    }
    keys: Keys = [(0.0, {}), (1.1, {**up, "RElbowRoll": 0.9})]
    for beat in range(6):
        keys.append((1.5 + 0.4 * beat, {**up, "RElbowRoll": 0.35 if beat % 2 else 1.25}))
    return [*keys, (5.0, {})]


def nod() -> Keys:
    """Two nods with a small bow of the whole body."""
    keys: Keys = [(0.0, {})]
    for beat in range(4):
        down = beat % 2 == 0
        pitch = {"HeadPitch": 0.3 if down else -0.25, "HipPitch": -0.16 if down else -0.05}
        keys.append((0.6 + 0.5 * beat, pitch))
    return [*keys, (3.4, {})]


def cheer() -> Keys:
    """Both arms up, a sway from side to side, and down again."""
    up = {
        "LShoulderPitch": -0.9,
        "RShoulderPitch": -0.9,
        "LShoulderRoll": 0.4,
        "RShoulderRoll": -0.4,
        "LHand": 1.0,
        "RHand": 1.0,
        "HeadPitch": -0.4,
    }
    keys: Keys = [(0.0, {}), (0.9, up)]
    for beat in range(4):
        sway = 0.12 if beat % 2 else -0.12
        keys.append((1.4 + 0.5 * beat, {**up, "HipRoll": sway, "HeadYaw": 2 * sway}))
    return [*keys, (4.6, {})]


def motion(name: str, keys: Keys) -> Motion:
    """Smooth curves through the key postures, without overshooting them."""
    times = [time for time, _ in keys]
    frames = np.arange(0.0, times[-1] + 1e-9, 1 / FPS)
    columns = []
    for joint in PEPPER_JOINTS:
        rest = STANDING.get(joint, 0.0)
        columns.append(PchipInterpolator(times, [k.get(joint, rest) for _, k in keys])(frames))
    return Motion(name, PEPPER_JOINTS, np.stack(columns, axis=1).astype(np.float32), FPS)


if __name__ == "__main__":
    folder = Path(str(files("rnnpb_explorer.static"))) / "examples"
    folder.mkdir(exist_ok=True)
    for make in (wave, nod, cheer):
        write_motion(motion(make.__name__, make()), folder / f"{make.__name__}.csv")
