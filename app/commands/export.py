"""`rnnpb export`: a motion as a file for a real robot, after the checks of robot/safety.py."""

from __future__ import annotations

import sys
from pathlib import Path

from ...core.files import check_writable, replacing
from ...robot.formats import Format
from .flags import Robot
from .generate import ChosenPB, motions_of

LINES = 5  # of violations that are named one by one


def run(
    chosen: ChosenPB,
    *,
    format: Format = "csv",
    robot: Robot = "pepper",
    safe_posture: bool = False,
    beyond_limits: bool = False,
    out: Path,
) -> None:
    """Write the motion, and name on stderr the limits that it broke as it was generated.

    Args:
        format: of the file
        safe_posture: start from and return to a safe posture
        beyond_limits: export the motion as it was generated, whatever limits it breaks
        out: the file to write
    """
    check_writable(out)
    from ...robot.description import load_robot, some_names
    from ...robot.export import export_motion

    description = load_robot(robot)
    (motion,) = motions_of(chosen, samples=1)
    export = export_motion(
        motion,
        description,
        format,
        safe_posture=safe_posture,
        enforce_limits=not beyond_limits,
    )
    with replacing(out) as beside:
        Path(beside).write_text(export.content, encoding="utf-8")
    report = export.report
    for violation in report.violations[:LINES]:
        print(violation, file=sys.stderr)
    if len(report.violations) > LINES:
        print(f"and {len(report.violations) - LINES} more", file=sys.stderr)
    if report.unchecked:
        print(f"not checked: {some_names(report.unchecked)}", file=sys.stderr)
    what = "as generated" if beyond_limits else "within the limits"
    print(
        f"{motion.name}, generated {report.light}, exported {what}: "
        f"{len(export.motion)} frames, {out}"
    )
