"""What the screen says of the state, in words that boards and panels share."""

from __future__ import annotations

from ...core.windows import WINDOW_RADIUS
from ...robot.description import Robot, some_names
from ...robot.safety_report import SafetyReport, Violation
from ..state.facts import ModelFacts
from ..state.picture import Picture
from ..state.wanted import given_target

MOST_LINES = 4  # of faults, or of joints
MOST_RUNS = 3  # of frames in a line


def window_label(picture: Picture) -> str:
    if picture.document.window == "absolute":
        return "±1"
    radius = WINDOW_RADIUS["sd"]
    return f"±{radius} sd (±{radius * picture.model.mu_sd:.2f})"


def target_label(picture: Picture) -> str:
    """What the motion and the landscape are compared with."""
    target = given_target(picture.facts, picture.document, picture.active)
    if target is not None:
        return target.name
    facts, motion = picture.model, picture.choice.latent.motion
    if facts.data[motion] is not None:
        return f"{facts.motions[motion]} (data)"
    return f"{facts.motions[motion]} (own reconstruction, σ = 0)"


def safety_lines(report: SafetyReport, most: int = MOST_LINES) -> list[str]:
    """The joints that break limits, one line a joint and limit, the worst first."""
    groups: dict[tuple[str, str], list[Violation]] = {}
    for violation in report.violations:
        groups.setdefault((violation.joint, violation.kind), []).append(violation)
    lines = [f"{found[0].fault}, {_frames(found)}" for found in groups.values()]
    rest = len(lines) - most
    return lines if rest <= 0 else [*lines[:most], f"and {rest} more"]


def _frames(found: list[Violation]) -> str:
    runs = [one.span for one in sorted(found, key=lambda one: one.first)]
    more = f" and {len(runs) - MOST_RUNS} more times" if len(runs) > MOST_RUNS else ""
    word = "frame" if len(found) == 1 and found[0].first == found[0].last else "frames"
    return f"{word} {', '.join(runs[:MOST_RUNS])}{more}"


def light_words(report: SafetyReport) -> str:
    """What the light says, for those who do not tell its colours apart."""
    left = len(report.unchecked)
    unchecked = f"{left} joint{'s' if left > 1 else ''} not checked" if left else ""
    if report.light == "green":
        return "within the robot's limits"
    if report.light == "grey":
        return f"nothing beyond the limits, but {unchecked}"
    joints = {one.joint for one in report.violations if one.light == report.light}
    how = "a little beyond" if report.light == "amber" else "far beyond"
    words = f"{len(joints)} joint{'s' if len(joints) > 1 else ''} {how} the limits"
    return f"{words}; {unchecked}" if left else words


def none_matches(robot: Robot, facts: ModelFacts) -> str:
    """A robot that stands still, and why."""
    joints = some_names(facts.joints, 3)
    return f"{robot.name} stands still: it has none of the joints of {facts.name} ({joints})"
