"""What a motion asks of a robot that it should not do: violations, and the light that they give."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["position", "velocity", "start", "not finite"]
Light = Literal["green", "grey", "amber", "red"]

# Beyond a limit by less than this is amber: recordings of the real robot reach 0.053 rad and 1.56
# times the speed, and limiting does not change what one sees of them. More is red.
AMBER_POSITION = 0.1  # radians (metres for a prismatic joint)
AMBER_VELOCITY = 2.0  # times the limit


@dataclass(frozen=True)
class Violation:
    """A run of frames in which one joint breaks one limit.

    kind: "start" is a velocity in the first frames, the jump that a motion may begin with.
        "not finite" is NaN or infinity where a position should be: red, whatever the limits.
    first, last: frames, both included; a velocity belongs to the frame that it leads to.
    worst: position (in `unit`) or speed (a second) where it is farthest out. limit: the one that is
    broken there. excess: beyond a position's limit, or times the speed limit.
    unit: "rad", "m" for a prismatic joint, "" for the opening of a hand.
    """

    kind: Kind
    joint: str
    first: int
    last: int
    worst: float
    limit: float
    excess: float
    unit: str = "rad"

    @property
    def light(self) -> Light:
        small = AMBER_POSITION if self.kind == "position" else AMBER_VELOCITY
        return "amber" if self.excess <= small else "red"

    @property
    def fault(self) -> str:
        """Joint and values without the frames, in plain words."""
        unit = self.unit and f" {self.unit}"
        if self.kind == "not finite":
            return f"{self.joint}: {self.worst} instead of a position"
        if self.kind == "position":
            return f"{self.joint}: position {self.worst:.3f}{unit}, limit {self.limit:.3f}"
        what = "jump at the start" if self.kind == "start" else "velocity"
        return f"{self.joint}: {what} {self.worst:.1f}{unit}/s over {self.limit:.1f}"

    @property
    def span(self) -> str:
        """Its frames as `4` or `4–9`."""
        return str(self.first) if self.first == self.last else f"{self.first}–{self.last}"

    def __str__(self) -> str:
        return f"{self.fault}, {'frame' if self.first == self.last else 'frames'} {self.span}"


@dataclass(frozen=True)
class SafetyReport:
    """What a motion asks of a robot that the robot should not do.

    violations: the worst first. unchecked: joints of the motion that the robot lacks, or that have
    no limits there.
    """

    violations: tuple[Violation, ...]
    unchecked: tuple[str, ...]

    @property
    def light(self) -> Light:
        """green: within all limits. amber: a little beyond. red: do not run this as it is.

        grey: nothing is beyond a limit, but not every joint was checked.
        """
        lights = {violation.light for violation in self.violations}
        if lights:
            return "red" if "red" in lights else "amber"
        return "grey" if self.unchecked else "green"

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints concerned, the worst first."""
        return tuple(dict.fromkeys(violation.joint for violation in self.violations))
