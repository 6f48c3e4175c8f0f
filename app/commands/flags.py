"""The flags of the commands: how their values are read, and those that several commands share."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter, Token

from ...core.device import Device
from ...core.recognition_run import Init

if TYPE_CHECKING:  # torch takes seconds to import; commands do so when they run
    from ...core.data import Dataset
    from ...core.model import RNNPB
    from ...core.motion import Motion
    from ...robot.reading import Said

MAX_COMPONENT = 1e6  # of mu or sigma; beyond it the network only saturates

# A dataclass with this as its decorator is a group of flags, each field one of them.
FLAGS = Parameter(name="*")


def read_by(
    parse: Callable[[str], Any], metavar: str | None = None, shown: str | None = None
) -> Parameter:
    """A flag whose one value `parse` reads; it raises ValueError, in words that say what is right.

    A value may begin with a minus; of a flag that is given twice the last one counts.

    Args:
        shown: the default as a person would write it, where Python writes it in another way.
    """

    def convert(type_: Any, tokens: tuple[Token, ...]) -> Any:
        return parse(tokens[-1].value)

    flag = Parameter(converter=convert, n_tokens=1, allow_leading_hyphen=True, metavar=metavar)
    return flag if shown is None else Parameter.combine(flag, Parameter(show_default=shown))


def whole(minimum: int, maximum: int) -> Callable[[str], int]:
    """Reads a whole number within bounds."""

    def parse(text: str) -> int:
        if not re.fullmatch(r"[+-]?\d{1,30}", text.strip(), re.ASCII):
            raise ValueError(f"{text[:40]!r} is no whole number")
        value = int(text)
        if not minimum <= value <= maximum:
            raise ValueError(f"must be from {minimum} to {maximum}, got {value}")
        return value

    return parse


def real(
    minimum: float = -math.inf, maximum: float = math.inf, *, above: float = -math.inf
) -> Callable[[str], float]:
    """Reads a finite number, within bounds or above one."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise ValueError(f"{text[:40]!r} is no number") from None
        if not math.isfinite(value):
            raise ValueError(f"must be finite, got {text}")
        if value < minimum or value > maximum or value <= above:
            low = f"above {above:g}" if above > -math.inf else f"at least {minimum:g}"
            high = f" and at most {maximum:g}" if maximum < math.inf else ""
            raise ValueError(f"must be {low}{high}, got {value:g}")
        return value

    return parse


SEEDS = whole(0, 2**32 - 1)


def reals(minimum: float = -MAX_COMPONENT) -> Callable[[str], tuple[float, ...]]:
    """Reads numbers separated by commas."""
    parse_one = real(minimum, MAX_COMPONENT)
    return lambda text: tuple(parse_one(part) for part in text.split(","))


def several(parse_one: Callable[[str], Any]) -> Callable[[str], tuple[Any, ...]]:
    """Reads a list with commas; what is named twice counts once."""
    return lambda text: tuple(dict.fromkeys(parse_one(part) for part in text.split(",")))


def one_of(what: str, names: tuple[str, ...]) -> Callable[[str], str]:
    """Reads a name; for lists of names (a single one is better a Literal)."""

    def parse(text: str) -> str:
        if text not in names:
            raise ValueError(f"no {what} {text[:40]!r}; there are: {', '.join(names)}")
        return text

    return parse


Checkpoint = Annotated[
    str, Parameter(name="ckpt", help="a checkpoint file, or a shipped one's name, such as strong")
]
Checkpoints = Annotated[
    tuple[str, ...],
    Parameter(
        name="ckpt",
        consume_multiple=(1, None),
        help="checkpoint files or names of shipped ones, in the order in which they are shown",
    ),
]
Data = Annotated[
    str, Parameter(help="REBL-Pepper's data_raw.csv, or a folder of one CSV file a motion")
]
DeviceName = Annotated[Device, Parameter(help="where torch computes")]
WarmStart = Annotated[
    Init,
    Parameter(help="where mu starts: the best learned mu, mu = 0, the best of random draws"),
]
Robot = Annotated[str, Parameter(help="pepper, PATH.urdf or NAME_description")]
Seed = Annotated[int, read_by(SEEDS), Parameter(help="of the random numbers")]
MotionInFile = Annotated[
    str | None, Parameter(name="motion", help="which one, where the file holds several")
]
Joints = Annotated[
    tuple[str, ...],
    read_by(
        lambda text: () if text.strip() == "all" else several(str.strip)(text), "NAME,..", "all"
    ),
]
FPS = (0.5, 10_000.0)  # that a file may have


@FLAGS
@dataclass(frozen=True, kw_only=True)
class FileFlags:
    """What is said of a motion file; by default the file says it, or its values.

    Args:
        fps: frames a second in the file, where it does not say
        unit: of the angles in the file
        hands: what openings of hands are measured in
    """

    fps: Annotated[float | None, read_by(real(*FPS))] = None
    unit: Literal["auto", "radians", "degrees"] = "auto"
    hands: Literal["auto", "share", "percent", "degrees"] = "auto"

    @property
    def said(self) -> Said:
        from ...robot.reading import Said

        unit = None if self.unit == "auto" else self.unit
        return Said(self.fps, unit, None if self.hands == "auto" else self.hands)


@contextmanager
def naming_flags() -> Iterator[None]:
    """What a file leaves open is asked for by the flag that says it.

    Raises:
        InputError: a file is unclear; the message says the flag.
    """
    from ...core.errors import InputError
    from ...robot.reading import Unclear

    try:
        yield
    except Unclear as unclear:
        if unclear.question == "motion":
            raise InputError(f"{unclear}; choose one with --motion") from unclear
        choices = " or ".join(unclear.choices)
        raise InputError(f"{unclear} Say --{unclear.question} {choices}") from unclear


def read_target(
    path: Path, joints: tuple[str, ...], fps: float, file: FileFlags, motion: str | None = None
) -> Motion:
    """A motion from a file; what was not exact is said.

    Raises:
        InputError: no motion of these joints; several, of which none is named.
    """
    from ...robot.reading import read_file

    with naming_flags():
        reading = read_file(path, joints, said=file.said, fps=fps)
        for remark in reading.remarks:
            note(f"{path.name}: {remark}")
        return reading.motion(motion)


def load_model(
    ckpt: str, data: str | None = None, file: FileFlags | None = None
) -> tuple[RNNPB, Dataset | None]:
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
    info = model.info
    with naming_flags():
        said = (file or FileFlags()).said
        loaded = load_dataset(data, info.joints, said, info.fps)
    for remark in loaded.remarks:
        note(remark)
    dataset = loaded.for_model(model)
    model.info = dataset.complete(model)
    return model, dataset


def joint_indices(names: tuple[str, ...], joints: tuple[str, ...]) -> tuple[int, ...]:
    """Which of a model's joints are named; () for none, which means all.

    Raises:
        InputError: the model has no joint of a name.
    """
    from ...core.errors import InputError

    for name in names:
        if name not in joints:
            raise InputError(f"--joints: no joint {name[:40]!r}; there are: {', '.join(joints)}")
    return tuple(joints.index(name) for name in names)


def note(text: str) -> None:
    """A remark that is no result: on stderr, where it cannot end up in a pipe."""
    print(text, file=sys.stderr)
