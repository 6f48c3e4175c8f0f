"""`rnnpb data`: where the training data are, once they have been fetched."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .flags import note


def run(
    *,
    path: Annotated[
        Path | None,
        Parameter(
            metavar="P",
            help="take the files from this folder (or clone of the published repository) instead "
            "of downloading them",
        ),
    ] = None,
) -> None:
    from ...core.rebl_pepper import LICENCE, fetch, take

    folder = fetch() if path is None else take(path)
    note(LICENCE)
    print(folder)  # alone on stdout: rnnpb train --data "$(rnnpb data)" ...
