"""What a command of `rnnpb` is, and the flags that several of them share."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

from ...core.errors import InputError

if TYPE_CHECKING:  # torch takes seconds to import; commands do so when they run
    from ...core.data import Dataset
    from ...core.model import RNNPB

MAX_COMPONENT = 1e6  # of mu or sigma; beyond it the network only saturates


class Parser(argparse.ArgumentParser):
    """argparse, but a mistake is one plain line instead of the usage and an exit."""

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message} ({self.prog} --help lists the flags)")


@dataclass(frozen=True)
class Command:
    """One command: how it is called and what it does.

    `run` gets the parsed flags, prints its results on stdout and raises `InputError` for whatever
    a person can mend.
    """

    name: str
    summary: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], None]


def whole(minimum: int, maximum: int) -> Callable[[str], int]:
    """The type of a flag that takes a whole number within bounds."""

    def parse(text: str) -> int:
        if not re.fullmatch(r"[+-]?\d{1,30}", text.strip(), re.ASCII):
            raise argparse.ArgumentTypeError(f"{text[:40]!r} is no whole number")
        value = int(text)
        if not minimum <= value <= maximum:
            raise argparse.ArgumentTypeError(f"must be from {minimum} to {maximum}, got {value}")
        return value

    return parse


def real(
    minimum: float = -math.inf, maximum: float = math.inf, *, above: float = -math.inf
) -> Callable[[str], float]:
    """The type of a flag that takes a finite number, within bounds or above one."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text[:40]!r} is no number") from None
        if not math.isfinite(value):
            raise argparse.ArgumentTypeError(f"must be finite, got {text}")
        if value < minimum or value > maximum or value <= above:
            low = f"above {above:g}" if above > -math.inf else f"at least {minimum:g}"
            high = f" and at most {maximum:g}" if maximum < math.inf else ""
            raise argparse.ArgumentTypeError(f"must be {low}{high}, got {value:g}")
        return value

    return parse


def reals(minimum: float = -MAX_COMPONENT) -> Callable[[str], tuple[float, ...]]:
    """The type of a flag that takes numbers separated by commas."""
    parse_one = real(minimum, MAX_COMPONENT)

    def parse(text: str) -> tuple[float, ...]:
        return tuple(parse_one(part) for part in text.split(","))

    return parse


def add_checkpoint(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ckpt",
        required=True,
        metavar="C",
        help="a checkpoint file, or the name of a shipped one (strong.pt, strong)",
    )


def add_checkpoints(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ckpt",
        required=True,
        nargs="+",
        action="extend",
        metavar="C",
        help="checkpoint files or names of shipped ones, in the order in which they are shown",
    )


def add_init(parser: argparse.ArgumentParser, default: str) -> None:
    parser.add_argument(
        "--init",
        choices=("baseline", "learned", "random"),
        default=default,
        help="warm start of a recognition: mu = 0, the best learned mu, the best of random draws; "
        f"default: {default}",
    )


def add_data(parser: argparse.ArgumentParser, *, required: bool = False) -> None:
    parser.add_argument(
        "--data",
        required=required,
        metavar="D",
        help="REBL-Pepper's data_raw.csv, or a folder of one CSV file a motion",
    )


def add_device(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--device", choices=("auto", "cpu", "cuda"), default="auto", help="default: auto"
    )


def add_seed(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seed", type=whole(0, 2**32 - 1), default=0, help="of the random numbers; default: 0"
    )


def add_unit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--unit",
        choices=("radians", "degrees"),
        default="radians",
        help="of the angles in the CSV file; default: radians",
    )


def load_model(ckpt: str, data: str | None = None) -> tuple[RNNPB, Dataset | None]:
    """The model, and the data where it is given.

    A published checkpoint carries neither names nor lengths of its motions; the data lends them.

    Raises:
        InputError: a checkpoint or data that cannot be read, or that do not fit each other.
    """
    from ...core.checkpoint import load_checkpoint
    from ...robot.data import load_dataset

    model = load_checkpoint(ckpt)
    if data is None:
        return model, None
    dataset = load_dataset(data, model.info.joints).for_model(model)
    model.info = dataset.complete(model)
    return model, dataset


def note(text: str) -> None:
    """A remark that is no result: on stderr, where it cannot end up in a pipe."""
    print(text, file=sys.stderr)
