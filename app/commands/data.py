"""`rnnpb data`: where the training data are, once they have been fetched."""

from __future__ import annotations

from pathlib import Path

from .flags import note


def run(*, path: Path | None = None) -> None:
    """Print where the files are, fetched or taken, and on stderr what their licence asks for.

    Args:
        path: take the files from this folder (or clone of the published repository) instead of
            downloading them
    """
    from ...robot.rebl_pepper import LICENCE, fetch, take

    folder = fetch() if path is None else take(path)
    note(LICENCE)
    print(folder)  # alone on stdout: rnnpb train --data "$(rnnpb data)" ...
