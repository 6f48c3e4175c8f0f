"""Radians or degrees, and what a hand's opening is measured in: said, certain, or asked."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ...core.errors import InputError
from .columns import Column
from .raw import Array, Raw, Unclear, Unit

Where = Callable[[int], str]  # what to call a row in messages
Limits = Mapping[str, tuple[float, float]]
Hands = Literal["share", "percent", "degrees"]

MAX_ANGLE = 4 * np.pi  # no joint turns twice around
# Networks leave 0 to 1 far from what they learned (3 sigma: -1 to 2.3); more is rubbish or percent.
OPENING_RANGE = (-2.0, 3.0)
CERTAIN = 2.0  # times a joint's limits: an angle beyond is none of it, but may be one in degrees
LITTLE = 0.6  # radians; joints that move so little are not in degrees
MAX_TURNS = 10  # times MAX_ANGLE that a joint may go where somebody says that it is radians
SLACK = 0.15  # radians beyond the limits that a recording in degrees may reach
FULL = np.degrees(1.0)  # degrees of a hand that is open, where its opening is called one radian
_WORDS: dict[Hands, str] = {"share": "from 0 to 1", "percent": "per cent", "degrees": "degrees"}


@dataclass(frozen=True)
class Units:
    """unit: of the angles, and how it is known. hands: what openings are measured in."""

    unit: Unit
    source: str
    hands: Hands


def in_radians(
    raw: Raw,
    chosen: Sequence[tuple[str, Column]],
    values: Array,
    said: tuple[Unit | None, Hands | None],
    limits: Limits,
    openings: Collection[str],
) -> tuple[Units, Array]:
    """Units, and the values (T, J) of joints in radians and shares.

    Args:
        said: the unit of angles and of openings that somebody says.

    Raises:
        Unclear: values can be read in more than one way.
        InputError: they are no angles, or somebody says otherwise than the format.
    """
    joints = [joint for joint, _ in chosen]
    values = values.copy()
    unit, source, degrees = _angles(raw, chosen, values, said[0], limits, openings)
    values[:, degrees] = np.radians(values[:, degrees])
    check_said(values, joints, openings, raw.where)
    hands: Hands = "share"
    for i, joint in enumerate(joints):
        if joint in openings and i not in degrees:
            found = said[1] or hands_unit(values[:, i], joint, raw.where)
            values[:, i] = to_share(values[:, i], found)
            hands = found if found != "share" else hands
    return Units(unit, source, hands), values


def _angles(
    raw: Raw,
    chosen: Sequence[tuple[str, Column]],
    values: Array,
    said: Unit | None,
    limits: Limits,
    openings: Collection[str],
) -> tuple[Unit, str, list[int]]:
    """The unit, how it is known, and which columns of `values` are in degrees."""
    if raw.units is not None:
        units = [raw.units[column.index] for _, column in chosen]
        degrees = [i for i, one in enumerate(units) if one == "degrees"]
        unit: Unit = "degrees" if degrees else "radians"
        if said not in (None, unit):
            raise InputError(f"{raw.source} is in {unit}, as {raw.format} files are")
        return unit, "format", degrees
    joints = [joint for joint, _ in chosen]
    angles = [i for i, joint in enumerate(joints) if joint not in openings]
    named = {chosen[i][1].unit for i in angles} - {None}
    if said is not None:
        unit, source = said, "said"
    elif len(named) == 1:
        unit, source = named.pop() or "radians", "header"
    else:
        unit, source = angle_unit(values, joints, limits, openings, raw.where)
    return unit, source, angles if unit == "degrees" else []


def angle_unit(
    positions: Array, joints: Sequence[str], limits: Limits, openings: Collection[str], where: Where
) -> tuple[Unit, str]:
    """The unit of the angles (T, J), and how that is known.

    Raises:
        Unclear: it can be either.
        InputError: it can be neither.
    """
    columns = [i for i, joint in enumerate(joints) if joint not in openings]
    excess = {i: _excess(positions[:, i], limits.get(joints[i])) for i in columns}
    worst = max(excess, key=excess.__getitem__, default=-1)
    if worst < 0 or excess[worst] <= CERTAIN:
        return "radians", "assumed"
    row = int(np.abs(positions[:, worst]).argmax())
    largest = positions[row, worst]
    what = f"{where(row)}, column {joints[worst]}: {largest:g} is no plausible angle in radians"
    others = [float(np.abs(positions[:, i]).max()) for i in columns if i != worst]
    if others and np.median(others) < LITTLE:
        raise InputError(
            f"{what}, and the other joints are; is it another quantity, or an opening in per cent?"
        )
    if not all(_fits_degrees(positions[:, i], limits.get(joints[i])) for i in columns):
        raise InputError(
            f"{what}, and the file is not in degrees either; does an encoder count several turns, "
            "or is a column no joint?"
        )
    if all(joints[i] in limits for i in columns):
        return "degrees", f"{largest:g} can be no angle of {joints[worst]} in radians"
    raise Unclear(
        f"{what}; is the file in degrees, or does an encoder count several turns?",
        "unit",
        get_args(Unit),
    )


def check_said(
    positions: Array, joints: Sequence[str], openings: Collection[str], where: Where
) -> None:
    """Angles (T, J), in radians as somebody said.

    Raises:
        InputError: they can be none.
    """
    for i, joint in enumerate(joints):
        row = int(np.abs(positions[:, i]).argmax())
        largest = positions[row, i]
        if joint not in openings and abs(largest) > MAX_TURNS * MAX_ANGLE:
            raise InputError(
                f"{where(row)}, column {joint}: {largest:g} is no plausible angle in radians"
            )


def _excess(values: Array, limit: tuple[float, float] | None) -> float:
    """How many times farther than a joint can go, in radians."""
    reach = np.pi if limit is None else max(abs(limit[0]), abs(limit[1]), 0.1)
    return float(np.abs(values).max() / reach)


def _fits_degrees(values: Array, limit: tuple[float, float] | None) -> bool:
    low, high = (-MAX_ANGLE, MAX_ANGLE) if limit is None else limit
    radians = np.radians(values)
    return bool(radians.min() >= low - SLACK and radians.max() <= high + SLACK)


def hands_unit(values: Array, joint: str, where: Where) -> Hands:
    """What an opening is measured in, from its values (T,).

    Raises:
        Unclear: it can be per cent or degrees.
        InputError: it is no opening.
    """
    low, high, row = float(values.min()), float(values.max()), int(values.argmax())
    if OPENING_RANGE[0] <= low and high <= OPENING_RANGE[1]:
        return "share"
    if low >= 0 and FULL < high <= 100:
        return "percent"
    if low >= 0 and high <= FULL:
        raise Unclear(
            f"{where(row)}, column {joint}: an opening of {high:g}; is it per cent, or degrees?",
            "hands",
            ("percent", "degrees"),
        )
    if high <= OPENING_RANGE[1]:
        row = int(values.argmin())
    raise InputError(
        f"{where(row)}, column {joint}: {values[row]:g} is no plausible opening (from 0 to 1, or "
        "to 100 in per cent)"
    )


def to_share(values: Array, hands: Hands) -> Array:
    shares: Array = values / {"share": 1.0, "percent": 100.0, "degrees": FULL}[hands]
    return shares


def hands_words(hands: Hands) -> str:
    return _WORDS[hands]
