"""`rnnpb follow`: recognise a motion while it arrives."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Annotated, TextIO

import msgspec
import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from ...core.errors import InputError
from .codebooks import whole_codebook
from .flags import FPS, Checkpoint, Joints, joint_indices, load_model, read_by, real

MAX_LINE = 100_000  # characters of a frame
MAX_FRAMES = 100_000


def run(
    path: Annotated[
        str, Parameter(allow_leading_hyphen=True, help="a CSV file, or - for standard input")
    ] = "-",
    /,
    *,
    ckpt: Checkpoint,
    joints: Joints = (),
    fps: Annotated[
        float | None,
        read_by(real(*FPS)),
        Parameter(help="frames a second that arrive; default: the model's"),
    ] = None,
) -> None:
    """Write a line of JSON a frame: frame, mu, sigma, loss, explained, milliseconds.

    The first line names the joints, in any order; each further one is a frame, in radians. Frames
    of another rate than the model's are brought to it: one that falls between two of the model's
    steps is used with the next.

    Args:
        joints: that are seen, by name; the others are inferred
    """
    model, _ = load_model(ckpt)
    seen = joint_indices(joints, model.info.joints)

    from ...core.following import Follower

    with ExitStack() as stack:
        lines = _opened(path, stack)
        frames = _frames(lines, model.info.joints, seen)
        follower = stack.enter_context(Follower(model, joints=seen, codebook=whole_codebook(model)))
        for frame in _at_rate(frames, fps or model.info.fps, model.info.fps):
            belief = follower.update(frame)
            line = {
                "frame": belief.frame,
                "mu": belief.mu.tolist(),
                "sigma": belief.sigma.tolist(),
                "loss": belief.loss,
                "explained": belief.explained,
                "milliseconds": round(belief.milliseconds, 3),
            }
            print(msgspec.json.encode(line).decode(), flush=True)


def _opened(path: str, stack: ExitStack) -> TextIO:
    if path == "-":
        return sys.stdin
    try:
        return stack.enter_context(open(path, encoding="utf-8-sig", newline=""))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error


def _frames(
    lines: TextIO, joints: tuple[str, ...], seen: tuple[int, ...]
) -> Iterator[NDArray[np.float64]]:
    """(J,) each line's values in the model's order; NaN for a joint that need not be there."""
    rows = _rows(lines)
    header = [name.strip() for name in next(rows, [])]
    needed = [joints[i] for i in seen] or list(joints)
    missing = [name for name in needed if name not in header]
    if missing:
        raise InputError(f"line 1 names the joints; missing: {', '.join(missing)}")
    columns = {joint: header.index(joint) for joint in joints if joint in header}
    for number, row in enumerate(rows, start=2):
        if not row:
            continue
        if len(row) != len(header):
            raise InputError(f"line {number} has {len(row)} values, line 1 {len(header)} names")
        frame = np.full(len(joints), np.nan)
        for joint, column in columns.items():
            try:
                frame[joints.index(joint)] = float(row[column])
            except ValueError:
                if joint in needed:
                    where = f"line {number}, {joint}"
                    raise InputError(f"{where}: {row[column][:40]!r} is no number") from None
        if number > MAX_FRAMES:
            raise InputError(f"more than {MAX_FRAMES} frames")
        yield frame


def _rows(lines: TextIO) -> Iterator[list[str]]:
    """Rows as they come: a line at a time, so that a frame does not wait for the next."""
    while True:
        try:
            line = lines.readline(MAX_LINE)
        except UnicodeDecodeError as error:
            raise InputError(f"no text: {error}") from error
        if not line:
            return
        if len(line) >= MAX_LINE:
            raise InputError(f"a line of more than {MAX_LINE} characters")
        yield next(csv.reader([line]), [])


def _at_rate(
    frames: Iterator[NDArray[np.float64]], fps: float, wanted: float
) -> Iterator[NDArray[np.float64]]:
    """Frames at the wanted rate, linearly between the two that are nearest in time."""
    before: NDArray[np.float64] | None = None
    step = 0
    for number, frame in enumerate(frames):
        while step / wanted <= number / fps + 1e-9:
            share = step / wanted * fps - (number - 1)
            yield frame if before is None else before + min(share, 1.0) * (frame - before)
            step += 1
        before = frame
