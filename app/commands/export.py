"""`rnnpb export`: a motion as a file for a real robot, after the checks of robot/safety.py."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ...core.files import check_writable, replacing
from .command import Command
from .generate import add_pb_arguments, motions_of

FORMATS = ("csv", "json", "naoqi")  # as in robot/export.py, which is not imported for --help
LINES = 5  # of violations that are named one by one


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_pb_arguments(parser)
    parser.add_argument("--format", choices=FORMATS, default="csv", help="default: csv")
    parser.add_argument(
        "--robot", default="pepper", metavar="R", help="pepper, PATH.urdf or NAME_description"
    )
    parser.add_argument(
        "--safe-posture", action="store_true", help="start from and return to a safe posture"
    )
    parser.add_argument(
        "--beyond-limits",
        action="store_true",
        help="export the motion as it was generated, whatever limits of the robot it breaks",
    )
    parser.add_argument("--out", required=True, metavar="F")


def run(arguments: argparse.Namespace) -> None:
    out = check_writable(arguments.out)
    from ...robot.description import load_robot
    from ...robot.export import export_motion

    robot = load_robot(arguments.robot)
    (motion,) = motions_of(arguments, samples=1)
    export = export_motion(
        motion,
        robot,
        arguments.format,
        safe_posture=arguments.safe_posture,
        enforce_limits=not arguments.beyond_limits,
    )
    with replacing(out) as beside:
        Path(beside).write_text(export.content, encoding="utf-8")
    report = export.report
    for violation in report.violations[:LINES]:
        print(violation, file=sys.stderr)
    if len(report.violations) > LINES:
        print(f"and {len(report.violations) - LINES} more", file=sys.stderr)
    what = "as generated" if arguments.beyond_limits else "within the limits"
    print(
        f"{motion.name}, generated {report.light}, exported {what}: "
        f"{len(export.motion)} frames, {out}"
    )


EXPORT = Command("export", "Write a motion for a real robot.", add_arguments, run)
