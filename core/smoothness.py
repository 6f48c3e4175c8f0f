"""How smooth a latent space is, fairly: measures that do not mix scale with shape.

Correlation in a fixed window (Fig. 4) is lower where PBs are packed closely, however smooth the
space is. Here motions are compared by the root mean square difference of their joint values, over
all frames and joints, in radians; the length of a way through the latent space is the sum of these
over its steps.

- **stretch**: at a point, the largest singular value of the Jacobian of the motion with respect to
  the PB: how far the motion moves for a small step in the worst direction. Per unit of mu and per
  standard deviation of the learned mu. The condition number says how uneven the directions are.
- **wander**: along the straight line from motion A to motion B, the length of the way of the motion
  over the distance of its ends. 1: the motion goes straight, too. No unit, no scale.
- **cliff**: along the same line, the largest step of the motion over the mean one. 1: even.
- **detour**: the length of the straight line's way over that of the shortest way found. 1: the
  straight line is already natural. The shortest way minimises the energy (the sum of squared steps)
  over points between A and B, from the straight line on (Michelis and Becker 2021,
  Arvanitidis et al. 2018).
- **jerk**: how smooth in time the motions between A and B are: the logarithm of the dimensionless
  jerk (Balasubramanian et al. 2015) in the middle of the line less the mean of its ends. 0: in
  between motions are as smooth as at the ends.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from .batching import chunks
from .model import RNNPB
from .recognition_lm import jacobian_parts
from .walk import RISE, STEPS, Walk

FRAMES = 120  # of the motions that are compared
WAVES = 6  # half-waves of a curve between its ends; more bend sharper
CURVE_STEPS = 24  # of a curve, while it is sought
ITERATIONS, RATE = 60, 0.03  # of its descent
LOOK = 5  # iterations between two looks at its length

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stretch:
    """At one point. largest: radians a unit of mu. condition: largest over smallest."""

    largest: float
    condition: float


@torch.no_grad()
def stretch(model: RNNPB, pb: Tensor, frames: int = FRAMES) -> Stretch:
    """At a PB (D,); the change of the motion is its root mean square over frames and joints."""
    *_, found = stretch_pieces(model, pb, frames)
    assert found is not None
    return found


def stretch_pieces(model: RNNPB, pb: Tensor, frames: int = FRAMES) -> Iterator[Stretch | None]:
    """`stretch` in pieces; the last one is it."""
    normal = torch.zeros(len(pb), len(pb), dtype=torch.float64)
    for part in jacobian_parts(model, pb[None].to(model.mu), frames):
        flat = part[0].flatten(0, 1).double().cpu()
        normal += flat.mT @ flat
        yield None
    values = torch.linalg.eigvalsh(normal / (frames * model.config.num_joints)).clamp(min=0).sqrt()
    smallest = float(values[0])
    largest = float(values[-1])
    yield Stretch(largest, largest / smallest if smallest > 0 else float("inf"))


def straight(start: Tensor, end: Tensor, steps: int = STEPS) -> Tensor:
    """(steps + 1, D): evenly from one PB (D,) to another."""
    share = torch.linspace(0, 1, steps + 1, dtype=start.dtype, device=start.device)[:, None]
    return start + share * (end - start)


@torch.no_grad()
def walk(model: RNNPB, pbs: Tensor, frames: int = FRAMES) -> Walk:
    """The way of the motion along PBs (S + 1, D)."""
    *_, found = walk_pieces(model, pbs, frames)
    assert found is not None
    return found


def walk_pieces(model: RNNPB, pbs: Tensor, frames: int = FRAMES) -> Iterator[Walk | None]:
    """`walk` in pieces; the last one is it."""
    parts = []
    for part in chunks(pbs.to(model.mu), frames):
        parts.append(model.generate(part, frames).cpu().double())
        yield None
    motions = torch.cat(parts)
    yield Walk(
        pbs.double().cpu().numpy(),
        _apart(motions[1:], motions[:-1]).numpy(),
        float(_apart(motions[-1:], motions[:1])),
    )


def _apart(one: Tensor, other: Tensor) -> Tensor:
    """(B,) root mean square differences of motions (B, T, J)."""
    return (one - other).square().mean(dim=(1, 2)).sqrt()


def shortest(model: RNNPB, start: Tensor, end: Tensor, frames: int = FRAMES) -> Walk:
    """The shortest way of the motion that is found from one PB (D,) to another."""
    *_, found = (one for one in shortest_pieces(model, start, end, frames) if one is not None)
    return found


def shortest_pieces(
    model: RNNPB, start: Tensor, end: Tensor, frames: int = FRAMES
) -> Iterator[Walk | None]:
    """`shortest` in pieces: each Walk is shorter than the one before, the first the straight line.

    Adam on the energy of the curve, with a rate that falls to 0: the energy has kinks at which
    second-order methods stop. Its offsets from the straight line are sines of WAVES half-waves at
    most, so that it stays smooth and between its ends.
    """
    ends = start.to(model.mu), end.to(model.mu)
    unit = float((ends[1] - ends[0]).norm()) or 1.0  # one rate suits every model
    with torch.inference_mode(False), torch.enable_grad():
        offsets = torch.zeros(WAVES, len(start), device=ends[0].device, requires_grad=True)
        optimiser = torch.optim.Adam([offsets], RATE)
        falling = torch.optim.lr_scheduler.LinearLR(optimiser, 1.0, 0.0, ITERATIONS)

    def curve(steps: int) -> Tensor:
        share = torch.linspace(0, 1, steps + 1).to(offsets)
        numbers = torch.arange(1, WAVES + 1).to(offsets)
        waves = torch.sin(torch.pi * share[:, None] * numbers) / numbers
        return straight(*ends, steps) + unit * (waves @ offsets)

    best = yield from _walked(model, curve(STEPS).detach(), frames)
    yield best
    for iteration in range(ITERATIONS):
        with torch.inference_mode(False), torch.enable_grad():
            optimiser.zero_grad()
            motions = model.generate(curve(CURVE_STEPS), frames)
            (motions[1:] - motions[:-1]).square().mean(dim=(1, 2)).sum().backward()
            optimiser.step()
            falling.step()
        yield None
        if iteration % LOOK == LOOK - 1:
            found = yield from _walked(model, curve(STEPS).detach(), frames)
            if found.length < best.length:
                best = found
                yield best


def _walked(model: RNNPB, pbs: Tensor, frames: int) -> Generator[None, None, Walk]:
    for found in walk_pieces(model, pbs, frames):
        if found is not None:
            return found
        yield
    raise AssertionError("a walk has an end")


def jerk(motion: NDArray[np.floating]) -> float:
    """Logarithm of the dimensionless jerk of a motion (T, J): smaller is smoother.

    Of the speed of all joints together, in units of the motion's own duration and peak speed.
    """
    speed = np.linalg.norm(np.diff(motion.astype(np.float64), axis=0), axis=1)
    peak = float(speed.max())
    if len(speed) < 3 or peak < RISE:
        return float("nan")
    bends = np.diff(speed, n=2)
    return float(np.log(np.square(bends).sum() * len(speed) ** 3 / peak**2 + 1e-12))
