"""`rnnpb convert`: a motion file of any kind, understood and written as one of our own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ...core.errors import InputError
from ...core.files import check_writable, replacing
from ...robot.formats import Format
from .flags import Checkpoint, FileFlags, MotionInFile, naming_flags, note

if TYPE_CHECKING:
    from ...robot.reading import Reading

FORMATS: dict[str, Format] = {".csv": "csv", ".json": "json", ".py": "naoqi"}


def run(
    path: Path,
    /,
    file: FileFlags | None = None,
    *,
    ckpt: Checkpoint | None = None,
    motion: MotionInFile = None,
    out: Path,
) -> None:
    """Write the motion, and say on stderr what was understood of the file.

    Args:
        path: the file to read
        ckpt: a model, whose joints and rate the motion gets; default: Pepper's at 25 Hz
        out: M.csv, M.json or M.py
    """
    suffix = out.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(f"--out {out}: a motion is written as {', '.join(FORMATS)}")
    check_writable(out)
    from ...robot.description import load_robot
    from ...robot.export import export_motion
    from ...robot.pepper import PEPPER_JOINTS
    from ...robot.reading import read_file

    file = file or FileFlags()
    joints: tuple[str, ...] = PEPPER_JOINTS
    fps = 25.0
    if ckpt is not None:
        from ...core.checkpoint import load_checkpoint

        info = load_checkpoint(ckpt).info
        joints, fps = info.joints, info.fps
    with naming_flags():
        reading = read_file(path, joints, said=file.said, fps=fps)
        note(f"{path.name}: {understood(reading)}")
        target = reading.motion(motion)
    export = export_motion(target, load_robot("pepper"), FORMATS[suffix], enforce_limits=False)
    with replacing(out) as beside:
        Path(beside).write_text(export.content, encoding="utf-8")
    print(f"{target.name}: {len(target)} frames of {len(joints)} joints at {fps:g} Hz, {out}")


def understood(reading: Reading) -> str:
    """One line on a file."""
    count = len(reading.motions)
    motions = "1 motion" if count == 1 else f"{count} motions"
    rate = f"{reading.fps:g} Hz ({reading.fps_source})"
    unit = f"{reading.unit} ({reading.unit_source})"
    return "; ".join([f"{reading.format}, {motions}, {rate}, {unit}", *reading.remarks])
