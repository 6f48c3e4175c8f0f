"""Whether to believe a recognition: how much of what was seen, and of what came, it explains.

The loss alone says little: 0.01 is much for a motion that hardly moves and little for a dance. The
share of the variance that is explained is 1 for a perfect motion, 0 for one that does no better
than the motion's own mean posture, and below 0 for a worse one.

Thresholds (`RECOGNISED`, `PARTLY`) are on the observed part, since of the rest nobody knows the
truth when the verdict is given. They were checked with the shipped models on three kinds of motion
(docs/results.md): learned ones, novel patterns of the paper, and motions of another generator.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

STILL = 1e-6  # rad^2: what varies less does not move, and there is nothing of it to explain
RECOGNISED = 0.9
PARTLY = 0.6

Verdict = Literal["recognised", "partly recognised", "beyond this model"]
MEANING: dict[Verdict, str] = {
    "recognised": "the model can make what was seen; what it foretells is its best guess, no more",
    "partly recognised": "the model finds something like it, and misses a part of what it does",
    "beyond this model": "no PB that was found makes it; what is shown is the closest there is",
}


@dataclass(frozen=True)
class Explained:
    """Shares of the variance that a motion explains; None where there is nothing to explain.

    observed: of the observed joints in the observed part. foretold: of the same joints afterwards.
    hidden: of the joints that were not observed, in the whole motion.
    error, foretold_error: squared, averaged over frames and joints, of the first two.
    """

    observed: float | None
    foretold: float | None
    hidden: float | None
    error: float
    foretold_error: float | None

    @property
    def verdict(self) -> Verdict:
        """From the observed part alone."""
        share = self.observed
        if share is None:  # nothing moves: it is explained if it is met
            return "recognised" if self.error < 1e-3 else "beyond this model"
        if share >= RECOGNISED:
            return "recognised"
        return "partly recognised" if share >= PARTLY else "beyond this model"


def explained(
    output: ArrayLike,
    target: ArrayLike,
    observed: int,
    joints: ArrayLike | None = None,
) -> Explained:
    """How much of a target (T, J) a generated motion (T, J) explains.

    Args:
        observed: frames, from the first.
        joints: indices of those that were observed; None: all.
    """
    truth = np.asarray(target, np.float64)
    seen = np.zeros(truth.shape[1], dtype=bool)
    seen[slice(None) if joints is None else np.asarray(joints, np.intp)] = True
    error = (np.asarray(output, np.float64)[: len(truth)] - truth) ** 2
    # Round the mean posture of the observed part: the one that is known when the verdict is given.
    around = (truth - truth[:observed].mean(axis=0)) ** 2
    later = error[observed:, seen]
    return Explained(
        observed=_share(error[:observed, seen], around[:observed, seen]),
        foretold=_share(later, around[observed:, seen]),
        hidden=_share(error[:, ~seen], (truth[:, ~seen] - truth[:, ~seen].mean(axis=0)) ** 2),
        error=float(error[:observed, seen].mean()),
        foretold_error=float(later.mean()) if later.size else None,
    )


def _share(error: NDArray[np.float64], around: NDArray[np.float64]) -> float | None:
    if not error.size or float(around.mean()) < STILL:
        return None
    return float(1 - error.sum() / around.sum())


def explained_words(share: Explained) -> str:
    """The shares in a line."""
    parts = [f"{_percent(share.observed)} of the observed variance explained"]
    if share.foretold_error is not None:
        parts.append(f"{_percent(share.foretold)} of the foretold")
    if share.hidden is not None:
        parts.append(f"{_percent(share.hidden)} of the joints that were not observed")
    return ", ".join(parts)


def _percent(share: float | None) -> str:
    """A share in words; far below 0 it says nothing more."""
    if share is None:
        return "nothing moves:"
    return f"{share:.0%}" if share > -1 else "less than -100%"
