"""A recognition's iterations as a path on a board."""

from __future__ import annotations

from collections.abc import Callable

from ...state.document import AppState, Array
from .overlay import RecognitionPath


def recognition_path(state: AppState, onto: Callable[[Array], Array]) -> RecognitionPath | None:
    """The drawn trial of the active model's recognition.

    Args:
        onto: takes points (..., D) of the latent space to a board's coordinates (..., 1 or 2).
    """
    recognition = state.recognition
    trace = recognition.trace
    if trace is None or recognition.model != state.active:
        return None
    trial = recognition.trial
    return RecognitionPath(
        mu=onto(trace.mu[:, trial]),
        sigma=trace.sigma[:, trial],
        pb=onto(trace.pb[:, trial]),
        current=recognition.shown,
    )
