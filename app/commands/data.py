"""`rnnpb data`: where the training data are, once they have been fetched."""

from __future__ import annotations

import argparse
from pathlib import Path

from .command import Command, note


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--path",
        metavar="P",
        help="take the files from this folder (or clone of the published repository) instead of "
        "downloading them",
    )


def run(arguments: argparse.Namespace) -> None:
    from ...robot.rebl_pepper import LICENCE, fetch, take

    folder = fetch() if arguments.path is None else take(Path(arguments.path))
    note(LICENCE)
    print(folder)  # alone on stdout: rnnpb train --data "$(rnnpb data)" ...


COMMAND = Command(
    "data", "Fetch the REBL-Pepper motions into the user's cache.", add_arguments, run
)
