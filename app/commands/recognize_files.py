"""`rnnpb recognize`, which takes what `rnnpb export` wrote as well."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path

from ...core.csv_table import Unit, read_csv_bytes
from ...core.errors import InputError
from ...core.motion import MAX_CSV_BYTES, Motion
from ...robot.importing import read_motion
from . import recognize


def run(arguments: argparse.Namespace) -> None:
    recognize.run(arguments, read_motion_file)


def read_motion_file(
    path: str | os.PathLike[str], joints: tuple[str, ...], *, fps: float, unit: Unit
) -> Motion:
    """A motion from a CSV file, or from a JSON or NAOqi export; arguments as `read_motion`."""
    path = Path(path)
    if path.suffix.lower() not in (".json", ".py"):
        return read_motion(path, joints, fps=fps, unit=unit)
    if unit != "radians":
        raise InputError(f"{path.name} is an export and in radians")
    from ...robot.importing import import_motion  # the robot takes a second to import

    content = read_csv_bytes(path, MAX_CSV_BYTES)
    return import_motion(content, path.suffix, joints, name=path.stem, source=path.name, fps=fps)


RECOGNIZE = replace(recognize.COMMAND, run=run)
