"""How torch's threads wait for each other; imports nothing, since it must be set before torch."""

from __future__ import annotations

import os

SPINS = "1000"


def wait_without_spinning() -> None:
    """Let idle OpenMP threads spin for microseconds only, then sleep.

    Call it before torch is imported; a person's own settings stay. By default they spin for
    milliseconds at the end of each of a sequence's steps. Where a browser without a GPU draws on
    the same few cores, that stretched one motion of 3 ms to 140 ms and a landscape fivefold. To
    sleep at once (OMP_WAIT_POLICY=PASSIVE) would double the 3 ms where nothing else runs.
    """
    if "OMP_WAIT_POLICY" not in os.environ:
        os.environ.setdefault("GOMP_SPINCOUNT", SPINS)
