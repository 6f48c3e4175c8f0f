"""The ten novel patterns of the recognition task (section IV.C), after the authors' own script.

Each is a training motion on its own first principal components, with a slow sine on every
component, scaled and shifted a little. The authors' draw of the scales and shifts is not published;
here it follows from a seed, and results are worth stating over several.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from ..motion import Motion

SOURCES = (  # sorted: the order in which the random numbers are drawn
    "Angry_3",
    "Bored_01",
    "Curious_01",
    "Disappointed_1",
    "Excited_01",
    "Frustrated_1",
    "Happy_01",
    "Interested_2",
    "Puzzled_1",
    "Surprised_01",
)
COMPONENTS = 5
SINE_HEIGHT, SINE_FREQUENCY = 0.1, 0.01  # of the components; cycles a frame
SCALE, SHIFT = 0.1, 0.1  # the scale is 1 + U(-0.1, 0.1), the shift U(-0.1, 0.1)


def novel_patterns(motions: Sequence[Motion], seed: int = 0) -> tuple[Motion, ...]:
    """Ten motions like, but not among, the training motions.

    Args:
        motions: those of REBL-Pepper; others than the ten sources do not matter.

    Raises:
        InputError: a source is not among the motions.
    """
    by_name = {motion.name: motion for motion in motions}
    missing = [name for name in SOURCES if name not in by_name]
    if missing:
        raise InputError(
            "the novel patterns are made from REBL-Pepper's motions; the data lack "
            + ", ".join(missing)
        )
    random = np.random.default_rng(seed)
    return tuple(_vary(by_name[name], random) for name in SOURCES)


def novel_pattern(motion: Motion, seed: int = 0) -> Motion:
    """One motion like, but not equal to, any motion that was trained on."""
    return _vary(motion, np.random.default_rng(seed))


def _vary(motion: Motion, random: np.random.Generator) -> Motion:
    from sklearn.decomposition import PCA  # its signs of the components matter to the shift

    pca = PCA(min(COMPONENTS, *motion.positions.shape))
    components = pca.fit_transform(motion.positions.astype(np.float64))  # (T, at most 5)
    frames = len(motion)
    phase = np.linspace(0.0, 2 * np.pi * SINE_FREQUENCY * frames, frames)
    components += SINE_HEIGHT * np.sin(phase)[:, None]
    scale = 1 + random.uniform(-SCALE, SCALE)
    shift = random.uniform(-SHIFT, SHIFT)
    positions = pca.inverse_transform(components * scale + shift)
    return Motion(f"{motion.name}_noisy", motion.joints, positions.astype(np.float32), motion.fps)
