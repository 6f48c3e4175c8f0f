"""What the screen says of the state, in words that boards and panels share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.verdict import MEANING, explained_words
from ...core.windows import WINDOW_RADIUS
from ...robot.description import Robot, some_names
from ...robot.safety_report import SafetyReport, Violation
from ..state.document import Document
from ..state.facts import ModelFacts
from ..state.picture import Picture
from ..state.wanted import given_target, joint_indices

MOST_LINES = 4  # of faults, or of joints
MOST_RUNS = 3  # of frames in a line
MOST_NEAREST = 3  # learned motions in a line


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


# --- recognition ---
def minimised_line(picture: Picture) -> str:
    """What the next run minimises, in words."""
    settings = picture.document.recognition
    joints = joint_indices(picture.model, settings.joints)
    count = len(joints) or len(picture.model.joints)
    which = f"{count} joints" if joints else "all joints"
    error = f"squared error, averaged over the observed frames and {which}"
    if settings.method == "live":
        return f"Minimised: {error}; held near the learned μ while few frames are there"
    if settings.beta and picture.model.stochastic:
        kl = "KL(N(μ, σ²) ‖ N(0, I))"
        return f"Minimised: {error}, + {settings.beta:g}/{count} · {kl}"
    return f"Minimised: {error}; no KL term"


def run_line(picture: Picture) -> str:
    """How far the run has come."""
    run, trace = picture.document.run, picture.trace
    if run is None:
        return ""
    if picture.run_status == "running":
        unit = "frame" if run.settings.method == "live" else "iteration"
        of = f" of {run.settings.iterations}" if run.settings.method == "paper" else ""
        best = "" if trace is None else f", lowest loss {np.nanmin(trace.loss):.5f}"
        paused = "Paused at" if run.paused else "Recognising:"
        return f"{paused} {unit} {run.done}{of}{best}"
    if picture.run_status == "failed":
        return f"Recognition failed: {picture.run_failure}"
    if picture.run_status == "cancelled":
        return f"Cancelled after {run.done} iterations"
    if trace is None:
        return ""
    iteration, trial = trace.best
    if run.settings.method == "live":
        return f"All {run.done} frames seen, loss {trace.loss[-1, 0]:.5f}"
    return (
        f"Best: iteration {iteration + 1} of trial {trial + 1}, "
        f"loss {trace.loss[iteration, trial]:.5f}"
    )


def verdict_lines(picture: Picture) -> list[str]:
    """Whether to believe what is on the screen; empty before there is a run to speak of."""
    run, share = picture.document.run, picture.explained
    if run is None or run.model != picture.active or share is None or run.done == 0:
        return []
    if not picture.document.revealed:  # nobody has seen the truth of these yet
        share = replace(share, foretold=None, foretold_error=None, hidden=None)
    by_hand = "" if run.follows else " (moved by hand since)"
    verdict = share.verdict
    lines = [f"{verdict.capitalize()}{by_hand}: {explained_words(share)}."]
    lines.append(f"{MEANING[verdict].capitalize()}.")
    if share.foretold_error is not None:
        lines.append(f"Error in the foretold part: {share.foretold_error:.5f} rad².")
    elif run.settings.observed < 1 or run.settings.joints:
        lines.append("Reveal the rest to see how well it foretells.")
    return lines


def nearest_line(picture: Picture) -> str:
    """The learned motions that the observed part is closest to."""
    if picture.belief is None:
        return ""
    nearest = picture.belief.cloud.nearest
    closest = np.argsort(nearest)[:MOST_NEAREST]
    names = [f"{picture.model.motions[i]} ({np.rad2deg(nearest[i]):.0f}°)" for i in closest]
    return f"Closest learned motions, off by: {', '.join(names)}"


def belief_lines(picture: Picture) -> list[str]:
    """What the belief over the codebook rests on, and what it is torn between."""
    book, belief = picture.codebook, picture.belief
    if book is None:
        return []
    if book.entries < book.size:
        lines = [f"The codebook grows: {book.entries} of {book.size} motions; usable meanwhile."]
    else:
        how = f"made in {book.seconds:.0f} s" if book.seconds else "from this computer's cache"
        lines = [f"Codebook of {book.size} motions, {how}."]
    if belief is None:
        return lines
    modes = belief.cloud.modes
    gaps = np.linalg.norm(picture.model.mu - np.array([mode.pb for mode in modes])[:, None], axis=2)
    near = [picture.model.motions[index] for index in gaps.argmin(axis=1)]
    parts = [f"{mode.mass:.0%} near {name}" for mode, name in zip(modes, near, strict=True)]
    return [*lines, f"At the end of the observed part: {', '.join(parts)}."]


def joints_line(document: Document, facts: ModelFacts) -> str:
    """Which joints are not observed."""
    joints = joint_indices(facts, document.recognition.joints)
    hidden = [joint for i, joint in enumerate(facts.joints) if joints and i not in joints]
    return f"Inferred, not observed: {some_names(hidden)}" if hidden else ""


# --- models side by side ---
def smoothness_lines(picture: Picture) -> list[str]:
    """How smooth each of two models is: where its puck is, and on the way to the goal."""
    if not picture.document.compare:
        return []
    lines = []
    for index in picture.document.on_boards:
        facts, stretch, ways = picture.facts[index], picture.stretch(index), picture.ways(index)
        parts = []
        if stretch is not None:
            per_sd = stretch.degrees * facts.mu_sd
            parts.append(f"stretch here {stretch.degrees:.1f}° a unit of μ, {per_sd:.1f}° a sd")
        if ways is not None:
            detour = "…" if ways.detour is None else f"{ways.detour:.2f}"
            goal = picture.document.goal
            parts.append(
                f"to {goal}: wander {ways.wander:.1f}, cliff {ways.cliff:.1f}, detour {detour}"
            )
        if parts:
            lines.append(f"{facts.name}: {'; '.join(parts)}")
    return lines
