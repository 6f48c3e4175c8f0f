"""The Robot panel: is the motion safe, the limited one beside it, and a file for a real robot."""

from __future__ import annotations

import re
from collections.abc import Callable
from html import escape

import viser

from ....robot.description import JointMatch, Robot, match_joints, some_names
from ....robot.formats import Format
from ....robot.safety_report import Light
from ...state import intents as do
from ...state.document import ExportOptions
from ...state.facts import ModelFacts
from ...state.picture import Picture
from ...state.results import CheckedMotion
from ..words import light_words, none_matches, safety_lines
from .bound import Bound, on_click
from .text import TEXT_STYLE, text_lines, write

Send = Callable[[do.Intent], None]

FORMAT_LABELS: dict[str, Format] = {"CSV": "csv", "JSON": "json", "NAOqi script": "naoqi"}
LIGHTS: dict[Light, str] = {
    "green": "#2f9e44",
    "grey": "#868e96",
    "amber": "#f08c00",
    "red": "#e03131",
}
MOST_WARNINGS = 3
INSISTED = (
    "The file will hold the motion as generated, limits or not. A real robot may stop, "
    "overheat or hurt somebody."
)


class SafetyLight:
    """One line that is always in view; below it, what the robot lacks."""

    def __init__(self, gui: viser.GuiApi, robot: Robot) -> None:
        self._robot = robot
        self._html = gui.add_html("")
        self._shown: tuple[object, ...] = ()

    def show(self, picture: Picture) -> None:
        checked = picture.checked
        if checked is None or (checked, picture.active) == self._shown:
            return
        self._shown = (checked, picture.active)
        report = checked.report
        matched = match_joints(self._robot, picture.model.joints).columns
        words = light_words(report) if matched else none_matches(self._robot, picture.model)
        html = _light(LIGHTS[report.light], words) + text_lines(missing_line(self._robot))
        write(self._html, f'<div style="padding-bottom:0.4em">{html}</div>')  # above the tabs


def missing_line(robot: Robot) -> str:
    """Which mesh files are not there; empty where all are."""
    missing = robot.missing_meshes
    if not missing:
        return ""
    files = "mesh" if len(missing) == 1 else "meshes"
    names = [re.split(r"[\\/]", name)[-1] for name in missing]
    return f"{len(missing)} {files} missing, joints drawn instead: {some_names(names, 3)}"


class RobotPanel:
    """Safety, export, and how the joints of model and robot go together."""

    def __init__(self, gui: viser.GuiApi, robot: Robot, send: Send) -> None:
        self._robot = robot
        with gui.add_folder("Safety"):
            self._report = gui.add_html("")
            self._side_by_side = Bound(
                gui.add_checkbox(
                    "Side by side", False, hint="a second robot moves within the limits"
                ),
                lambda value: send(do.SetSideBySide(value)),
            )
        with gui.add_folder("Export"):
            self._format = Bound(
                gui.add_dropdown("Format", list(FORMAT_LABELS)),
                lambda label: send(do.SetExportOption("file_format", FORMAT_LABELS[label])),
            )
            self._safe = Bound(
                gui.add_checkbox(
                    "Safe posture", False, hint="start from it and return to it, slowly"
                ),
                lambda value: send(do.SetExportOption("safe_posture", value)),
            )
            self._beyond = Bound(
                gui.add_checkbox(
                    "Beyond limits", False, hint="export the motion as it was generated"
                ),
                lambda value: send(do.SetExportOption("beyond_limits", value)),
            )
            self._note = gui.add_html("")
            export = gui.add_button("Export the motion", icon=viser.Icon.DOWNLOAD)
            on_click(export, lambda: send(do.ExportMotion()))
            self._written = gui.add_html("")
        with gui.add_folder("Joints"):
            self._joints = gui.add_html("")
        self._shown: tuple[object, ...] = ()
        self._checked: CheckedMotion | None = None

    def show(self, picture: Picture) -> None:
        self._side_by_side.show(picture.document.side_by_side)
        export, exported = picture.document.export, picture.exported
        label = next(label for label, known in FORMAT_LABELS.items() if known == export.file_format)
        self._format.show(label)
        self._safe.show(export.safe_posture)
        self._beyond.show(export.beyond_limits)
        checked = picture.checked or self._checked  # a new motion's comes a moment later
        what = (checked, export, exported, picture.model.name)
        if what == self._shown:  # thirty times a second
            return
        self._shown, self._checked = what, checked
        if checked is not None:
            write(self._report, report_html(checked))
            write(self._note, note_html(checked, export))
        write(self._written, text_lines(exported))
        match = match_joints(self._robot, picture.model.joints)
        lines = joint_lines(self._robot, picture.model, match)
        write(self._joints, text_lines(*lines))


def report_html(checked: CheckedMotion) -> str:
    """The light, and what is wrong in short lines."""
    report = checked.report
    return _light(LIGHTS[report.light], light_words(report)) + text_lines(*safety_lines(report))


def note_html(checked: CheckedMotion, export: ExportOptions) -> str:
    """What the export will do to the motion."""
    if export.beyond_limits:
        return _light(LIGHTS["red"], INSISTED)
    joints = checked.report.joints
    if not joints:
        within = "within the limits" if not checked.report.unchecked else "beyond no limit known"
        return text_lines(f"The motion is {within}; it is exported as it is.")
    return text_lines(f"Limited in the file: {some_names(joints)}.")


def joint_lines(robot: Robot, facts: ModelFacts, match: JointMatch) -> list[str]:
    """How the joints of a model and a robot go together; what does not is named."""
    lines = [f"{robot.name}: {len(match.columns)} of the {len(facts.joints)} joints of the model."]
    if match.missing:
        lines.append(f"Not on this robot, so not seen: {some_names(match.missing)}.")
    if match.unmoved:
        lines.append(f"Not moved by the model: {some_names(match.unmoved)}.")
    lines += robot.warnings[:MOST_WARNINGS]
    rest = len(robot.warnings) - MOST_WARNINGS
    return [*lines, f"and {rest} more remarks; rnnpb robot lists them"] if rest > 0 else lines


def _light(color: str, words: str) -> str:
    dot = f"width:0.9em;height:0.9em;border-radius:50%;flex:none;background:{color}"
    return (
        f'<div style="{TEXT_STYLE};display:flex;align-items:center;gap:0.6em">'
        f'<span style="{dot}"></span><span>{escape(words)}</span></div>'
    )
