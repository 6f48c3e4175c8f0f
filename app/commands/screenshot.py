"""The console command `rnnpb`: the commands of core, and those that need the app."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from rnnpb_explorer.app.commands import COMMANDS
from rnnpb_explorer.app.commands.command import Command, add_data, whole
from rnnpb_explorer.app.commands.main import main as run_command
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.files import check_writable, replacing

from .export import EXPORT
from .recognize_files import RECOGNIZE

SMALLEST, LARGEST = (320, 240), (7680, 4320)


def main(argv: Sequence[str] | None = None) -> int:
    own = {command.name: command for command in (RECOGNIZE, EXPORT, SCREENSHOT)}
    commands = {command.name: command for command in COMMANDS} | own
    return run_command(argv, tuple(commands.values()))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ckpt",
        action="append",
        metavar="C",
        help="a checkpoint file, or the name of a shipped one; default: strong.pt",
    )
    parser.add_argument("--motion", metavar="NAME", help="a learned motion, by name or index")
    parser.add_argument("--frame", type=whole(0, 1_000_000), metavar="N")
    parser.add_argument("--state", metavar="CODE", help="a state code, copied from the app")
    parser.add_argument("--size", type=_size, default=(1280, 720), help="default: 1280x720")
    add_data(parser)
    parser.add_argument(
        "--robot", default="pepper", metavar="R", help="pepper, PATH.urdf or NAME_description"
    )
    parser.add_argument("--out", required=True, metavar="p.png")


def run(arguments: argparse.Namespace) -> None:
    out = Path(arguments.out)
    if out.suffix.lower() != ".png":
        raise InputError(f"--out {out}: the name of a picture ends in .png")
    check_writable(out)
    from .photograph import take_screenshot  # a browser and a server: only when it is wanted

    with replacing(out) as beside:
        take_screenshot(
            checkpoints=arguments.ckpt or (),
            motion=arguments.motion,
            frame=arguments.frame,
            state_code=arguments.state,
            size=arguments.size,
            out=beside,
            data=arguments.data,
            robot=arguments.robot,
        )
    print(out)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text, re.ASCII)
    if match is None:
        raise argparse.ArgumentTypeError(f"must be WIDTHxHEIGHT as in 1280x720, got {text[:40]!r}")
    size = (int(match[1]), int(match[2]))
    if any(
        not low <= side <= high for low, side, high in zip(SMALLEST, size, LARGEST, strict=True)
    ):
        raise argparse.ArgumentTypeError(
            f"must be from {SMALLEST[0]}x{SMALLEST[1]} to {LARGEST[0]}x{LARGEST[1]}, got {text}"
        )
    return size


SCREENSHOT = Command(
    "screenshot", "Take a picture of the app, as a person would see it.", add_arguments, run
)

if __name__ == "__main__":
    sys.exit(main())
