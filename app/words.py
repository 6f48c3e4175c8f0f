"""What the screen says of the state, in words that boards and panels share."""

from __future__ import annotations

from .slices import RELATIVE_RADIUS
from .state import AppState, ModelFacts


def window_label(facts: ModelFacts, state: AppState) -> str:
    if state.window == "absolute":
        return "±1"
    return f"±{RELATIVE_RADIUS} sd (±{RELATIVE_RADIUS * facts.mu_sd:.2f})"


def target_label(facts: ModelFacts, state: AppState) -> str:
    """What the motion and the landscape are compared with."""
    target = state.recognition.target
    if target is not None and state.use_target and target.joints == facts.joints:
        return target.name
    motion = state.current.latent.motion
    if facts.data[motion] is not None:
        return f"{facts.motions[motion]} (data)"
    return f"{facts.motions[motion]} (own reconstruction, σ = 0)"
