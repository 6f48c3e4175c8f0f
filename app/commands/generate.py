"""`rnnpb generate`: motions from a PB, as CSV files."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.errors import InputError
from ...core.files import check_writable
from ...core.motion import MAX_FRAMES, Motion, write_motion
from .command import (
    Command,
    add_checkpoint,
    add_data,
    add_device,
    add_seed,
    load_model,
    reals,
    whole,
)

if TYPE_CHECKING:
    from torch import Tensor

    from ...core.model import RNNPB

MAX_SAMPLES = 10_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_pb_arguments(parser)
    parser.add_argument("--samples", type=whole(1, MAX_SAMPLES), default=1, metavar="N")
    parser.add_argument(
        "--out",
        required=True,
        metavar="x.csv",
        help="with several samples: x-0.csv, x-1.csv, ..",
    )


def add_pb_arguments(parser: argparse.ArgumentParser) -> None:
    """What says which PB to generate from, and how long; for every command that makes motions."""
    add_checkpoint(parser)
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--motion", metavar="NAME", help="a learned motion, by name or index from 0")
    where.add_argument("--mu", type=reals(), metavar="a,b,..", help="the mean of the PB")
    parser.add_argument(
        "--sigma",
        type=_sigma,
        default=(0.0,),
        metavar="s|a,b,..|learned",
        help="standard deviation of the PB, one for all or one a dimension; default: 0",
    )
    parser.add_argument(
        "--steps",
        type=whole(1, MAX_FRAMES),
        metavar="T",
        help="frames; default: as long as the learned motion, 150 where that is not known",
    )
    add_seed(parser)
    add_data(parser)
    add_device(parser)


def _sigma(text: str) -> tuple[float, ...] | None:
    return None if text == "learned" else reals(minimum=0.0)(text)


def run(arguments: argparse.Namespace) -> None:
    paths = _paths(Path(arguments.out), arguments.samples)
    for path in paths:
        check_writable(path)
    motions = motions_of(arguments, arguments.samples)
    for path, motion in zip(paths, motions, strict=True):
        write_motion(motion, path)
    where = paths[0] if len(paths) == 1 else f"{paths[0]} .. {paths[-1]}"
    print(f"{len(paths)} x {len(motions[0])} frames at {motions[0].fps:g} Hz: {where}")


def motions_of(arguments: argparse.Namespace, samples: int) -> list[Motion]:
    """The motions that the flags of `add_pb_arguments` ask for."""
    from ...core.device import choose_device
    from ...core.model import UNKNOWN_LENGTH

    model, _ = load_model(arguments.ckpt, arguments.data)
    index = None if arguments.motion is None else model.motion_index(arguments.motion)
    mu, sigma = _latent(model, index, arguments.mu, arguments.sigma)
    steps = arguments.steps or (UNKNOWN_LENGTH if index is None else model.length(index))

    model.to(choose_device(arguments.device))
    name = "generated" if index is None else model.motion_name(index)
    return [
        Motion(name, model.info.joints, positions.numpy(), model.info.fps)
        for positions in sample(model, mu, sigma, samples, steps, arguments.seed)
    ]


def sample(model: RNNPB, mu: Tensor, sigma: Tensor, samples: int, steps: int, seed: int) -> Tensor:
    """(samples, steps, J) motions at PBs drawn from N(mu, sigma^2) (eq. 1), on the CPU.

    Args:
        mu, sigma: (D,).
    """
    import torch

    from ...core.batching import chunks

    random = torch.Generator().manual_seed(seed)
    noise = torch.randn(samples, model.config.pb_dim, generator=random)
    pb = (mu + sigma * noise).to(model.mu.device)
    with torch.no_grad():
        motions = torch.cat([model.generate(part, steps).cpu() for part in chunks(pb, steps)])
    if not torch.isfinite(motions).all():
        raise InputError("this PB lies so far out that the network overflows; try smaller numbers")
    return motions


def _latent(
    model: RNNPB,
    index: int | None,
    mu: tuple[float, ...] | None,
    sigma: tuple[float, ...] | None,
) -> tuple[Tensor, Tensor]:
    """(D,) mean and standard deviation that the flags ask for; sigma None is the learned one."""
    import torch

    dimensions = model.config.pb_dim
    if mu is not None and len(mu) != dimensions:
        raise InputError(f"--mu has {len(mu)} numbers, this model's PB has {dimensions}")
    if sigma is not None and len(sigma) not in (1, dimensions):
        raise InputError(
            f"--sigma has {len(sigma)} numbers; give one, or {dimensions} for this model's PB"
        )
    if sigma is None and index is None:
        raise InputError("--sigma learned needs --motion: a PB of one's own has no learned sigma")
    mean = model.mu[index] if mu is None else torch.tensor(mu)
    spread = model.sigma[index] if sigma is None else torch.tensor(sigma).expand(dimensions)
    return mean, spread


def _paths(out: Path, samples: int) -> list[Path]:
    if out.suffix.lower() != ".csv":
        raise InputError(f"--out {out}: the name of a CSV file ends in .csv")
    if samples == 1:
        return [out]
    return [out.with_name(f"{out.stem}-{i}{out.suffix}") for i in range(samples)]


COMMAND = Command("generate", "Generate motions from a PB.", add_arguments, run)
