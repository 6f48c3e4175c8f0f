"""What a file holds, before anyone knows what its columns mean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.errors import InputError

Array = NDArray[np.float64]
Unit = Literal["radians", "degrees"]
Question = Literal["unit", "hands", "motion"]


class Unclear(InputError):
    """A file that can be read in more than one way; a person has to say which.

    Attributes:
        question: what to say: the angles' unit, the hands' unit, which motion.
        choices: what can be answered.
    """

    def __init__(self, message: str, question: Question, choices: tuple[str, ...]) -> None:
        super().__init__(message)
        self.question: Question = question
        self.choices = choices


@dataclass(frozen=True, eq=False)
class Raw:
    """T rows of named columns.

    format: in words. source: what to call the file in messages.
    names: of the columns; None where there is no header.
    numbers: a column's (T,) values; an InputError names the row where one is none.
    texts: a column's (T,) cells. where: what to call a row in messages: 'walk.csv, row 7'.
    time: (T,) seconds, where the format has them. fps: where the format says it.
    units: of the columns, where the format says them; None for a number without a unit.
    """

    format: str
    source: str
    names: tuple[str, ...] | None
    length: int
    numbers: Callable[[int], Array]
    texts: Callable[[int], list[str]]
    where: Callable[[int], str]
    width: int
    time: Array | None = None
    fps: float | None = None
    units: tuple[Unit | None, ...] | None = None
    remarks: tuple[str, ...] = ()


def raw_array(
    format: str, source: str, names: tuple[str, ...], values: Array, **known: object
) -> Raw:
    """Of values (T, N) that are numbers already.

    Raises:
        InputError: names and values do not go together, or a value is not finite.
    """
    if values.ndim != 2 or values.shape[1] != len(names):
        raise InputError(f"{source}: {len(names)} joints, but values of shape {values.shape}")
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        row, column = bad[0].tolist()
        raise InputError(f"{source}, frame {row + 1}, {names[column]}: the value is not finite")
    return Raw(
        format=format,
        source=source,
        names=names,
        length=len(values),
        numbers=lambda column: values[:, column],
        texts=lambda column: [f"{value:g}" for value in values[:, column]],
        where=lambda row: f"{source}, frame {row + 1}",
        width=len(names),
        **known,  # type: ignore[arg-type]
    )
