"""The codebook of a model for a command: from the user's cache, or made now, with a bar."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from .flags import note
from .progress import progress_bar

if TYPE_CHECKING:
    from ...core.codebook import Codebook
    from ...core.model import RNNPB


def whole_codebook(model: RNNPB) -> Codebook:
    """All of it; how long it took to make is said."""
    from ...core.codebook import Codebook

    codebook = Codebook(model)
    if codebook.restore():
        return codebook
    started = time.monotonic()
    with progress_bar() as bar:
        task = bar.add_task("making the codebook, once for this model", total=len(codebook))
        while not codebook.complete:
            for _ in codebook.grow():
                pass
            bar.update(task, completed=codebook.entries)
    codebook.save()
    note(f"codebook of {len(codebook)} motions made in {time.monotonic() - started:.0f} s")
    return codebook
