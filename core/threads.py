"""How torch's threads wait for each other; imports nothing, since it must be set before torch."""

from __future__ import annotations

import os


def wait_without_spinning() -> None:
    """Let idle OpenMP threads sleep. Call it before torch is imported; a person's setting stays.

    By default they spin at the end of each of a sequence's steps. Where a browser without a GPU
    draws on the same few cores, that stretched one motion of 3 ms to 140 ms and more, and a
    landscape fivefold.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
