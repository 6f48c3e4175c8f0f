"""`rnnpb screenshot`: a picture of the app, taken in headless Chromium."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

from ...core.errors import InputError
from ...core.files import check_writable, replacing
from .flags import Data, FileFlags, Robot, read_by, whole

SMALLEST, LARGEST = (320, 240), (7680, 4320)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text, re.ASCII)
    if match is None:
        raise ValueError(f"must be WIDTHxHEIGHT as in 1280x720, got {text[:40]!r}")
    size = (int(match[1]), int(match[2]))
    if any(
        not low <= side <= high for low, side, high in zip(SMALLEST, size, LARGEST, strict=True)
    ):
        raise ValueError(
            f"must be from {SMALLEST[0]}x{SMALLEST[1]} to {LARGEST[0]}x{LARGEST[1]}, got {text}"
        )
    return size


def run(
    file: FileFlags | None = None,
    *,
    ckpt: tuple[str, ...] = ("strong.pt",),
    motion: str | None = None,
    frame: Annotated[int | None, read_by(whole(0, 1_000_000))] = None,
    state: str | None = None,
    size: Annotated[tuple[int, int], read_by(_size, "WxH", shown="1280x720")] = (1280, 720),
    data: Data | None = None,
    robot: Robot = "pepper",
    out: Path,
) -> None:
    """Write the picture once the landscape is complete and the page stands still.

    Args:
        ckpt: a checkpoint file, or the name of a shipped one; twice: two models side by side
        motion: a learned motion, by name or index
        frame: where the motion is paused
        state: a state code, copied from the app
        size: of the page in pixels
        out: p.png
    """
    if out.suffix.lower() != ".png":
        raise InputError(f"--out {out}: the name of a picture ends in .png")
    check_writable(out)
    from .photograph import take_screenshot  # a browser and a server: only when it is wanted

    with replacing(out) as beside:
        take_screenshot(
            checkpoints=ckpt,
            motion=motion,
            frame=frame,
            state_code=state,
            size=size,
            out=beside,
            data=data,
            said=(file or FileFlags()).said,
            robot=robot,
        )
    print(out)
