"""What the screen says of the state, in words that boards and panels share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.verdict import MEANING, explained_words
from ...core.walk import STEPS
from ...core.windows import WINDOW_RADIUS
from ...robot.description import Robot, some_names
from ...robot.safety_report import SafetyReport, Violation
from ..state.document import Document
from ..state.facts import ModelFacts
from ..state.picture import Picture
from ..state.results import StretchResult
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
def smoothness_table(picture: Picture) -> list[list[str]]:
    """How smooth each model is: where its puck is, and on the way to the goal; rows of cells.

    Nothing where neither is asked for.
    """
    document = picture.document
    there = [picture.of(index) for index in document.on_boards]
    goal = any(one.ways_wanted for one in there)
    if not (document.compare or goal):
        return []
    rows = [["", *(one.model.name for one in there)]]
    if document.compare:
        values = [one.landscape[1] if one.landscape else None for one in there]
        window = "±1" if document.window == "absolute" else f"±{WINDOW_RADIUS['sd']} sd"
        for name in ("mean", "area", "roughness"):
            digits = 3 if name == "roughness" else 2
            cells = [_number(None if one is None else getattr(one, name), digits) for one in values]
            rows.append([f"{name}, {window}", *cells])
    stretches = [(one.model, picture.stretch(one.active)) for one in there]
    rows.append(["stretch, °/unit of μ", *(_stretch(found, 1.0) for _, found in stretches)])
    rows.append(
        ["stretch, °/sd of μ", *(_stretch(found, model.mu_sd) for model, found in stretches)]
    )
    if goal:
        ways = [picture.ways(one.active) for one in there]
        rows.append(["wander", *(_number(one.straight.wander if one else None, 1) for one in ways)])
        rows.append(
            ["detour", *(_number(one.detour if one and one.sought else None) for one in ways)]
        )
        rows.append(["cliff", *(_number(one.straight.cliff if one else None, 1) for one in ways)])
    return rows


def _stretch(found: StretchResult | None, sd: float) -> str:
    return _number(None if found is None else found.degrees * sd, 1)


def _number(value: float | None, digits: int = 2) -> str:
    """NaN: it has no value; None: it is not there yet."""
    return "…" if value is None else "–" if np.isnan(value) else f"{value:z.{digits}f}"


def way_line(picture: Picture) -> str:
    """What walks where."""
    document = picture.document
    if document.walk is None:
        return "Click on the curve, or move the step, to walk from the one motion to the other."
    start = picture.model.motions[picture.choice.latent.motion]
    morphs = document.walk == "morph"
    what = f"{start} becomes {document.goal}" if morphs else f"Step {document.walk} of {STEPS}"
    return f"{what}: the robot on the straight line, its ghost on the shortest way found."
