"""A recognition's iterations as a path on a board."""

from __future__ import annotations

from collections.abc import Callable

from ...state.facts import Array
from ...state.picture import Picture
from .overlay import RecognitionPath


def recognition_path(picture: Picture, onto: Callable[[Array], Array]) -> RecognitionPath | None:
    """The drawn trial of the active model's recognition.

    Args:
        onto: takes points (..., D) of the latent space to a board's coordinates (..., 1 or 2).
    """
    if picture.drawn_run is None:
        return None
    run, trace = picture.drawn_run
    return RecognitionPath(
        mu=onto(trace.mu[:, run.trial]),
        sigma=trace.sigma[:, run.trial],
        pb=onto(trace.pb[:, run.trial]),
        current=run.shown,
    )
