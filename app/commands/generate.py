"""`rnnpb generate`: motions from a PB, as CSV files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ...core.errors import InputError
from ...core.files import check_writable
from ...core.motion import MAX_FRAMES, Motion, write_motion
from .flags import Checkpoint, Data, DeviceName, Seed, load_model, read_by, reals, whole

if TYPE_CHECKING:
    from torch import Tensor

    from ...core.model import RNNPB

MAX_SAMPLES = 10_000


def _motion_or_mu(type_: object, chosen: ChosenPB) -> None:
    if chosen.motion is None and chosen.mu is None:
        raise ValueError("one of the arguments --motion --mu is required")
    if chosen.motion is not None and chosen.mu is not None:
        raise ValueError("argument --mu: not allowed with argument --motion")


def _sigma(text: str) -> tuple[float, ...] | None:
    return None if text == "learned" else reals(minimum=0.0)(text)


@Parameter(name="*", validator=_motion_or_mu)
@dataclass(frozen=True, kw_only=True)
class ChosenPB:
    """The PB to generate from, and how long; the flags of every command that makes motions.

    Args:
        motion: a learned motion, by name or index from 0
        mu: the mean of the PB, instead of --motion
        sigma: standard deviation of the PB, one for all or one a dimension
        steps: frames; default: as long as the learned motion, 150 where that is not known
    """

    ckpt: Checkpoint
    motion: str | None = None
    mu: Annotated[tuple[float, ...] | None, read_by(reals(), "a,b,..")] = None
    sigma: Annotated[  # None: the learned one
        tuple[float, ...] | None, read_by(_sigma, "s|a,b,..|learned")
    ] = (0.0,)
    steps: Annotated[int | None, read_by(whole(1, MAX_FRAMES))] = None
    seed: Seed = 0
    data: Data | None = None
    device: DeviceName = "auto"


def run(
    chosen: ChosenPB,
    *,
    samples: Annotated[int, read_by(whole(1, MAX_SAMPLES))] = 1,
    out: Path,
) -> None:
    """Write one motion or several.

    Args:
        samples: how many motions
        out: x.csv; with several samples x-0.csv, x-1.csv, ..
    """
    paths = _paths(out, samples)
    for path in paths:
        check_writable(path)
    motions = motions_of(chosen, samples)
    for path, motion in zip(paths, motions, strict=True):
        write_motion(motion, path)
    where = paths[0] if len(paths) == 1 else f"{paths[0]} .. {paths[-1]}"
    print(f"{len(paths)} x {len(motions[0])} frames at {motions[0].fps:g} Hz: {where}")


def motions_of(chosen: ChosenPB, samples: int) -> list[Motion]:
    """As many motions from the PB; several differ where sigma is not 0."""
    from ...core.device import choose_device
    from ...core.model import UNKNOWN_LENGTH

    model, _ = load_model(chosen.ckpt, chosen.data)
    index = None if chosen.motion is None else model.motion_index(chosen.motion)
    mu, sigma = _latent(model, index, chosen.mu, chosen.sigma)
    steps = chosen.steps or (UNKNOWN_LENGTH if index is None else model.length(index))

    model.to(choose_device(chosen.device))
    name = "generated" if index is None else model.motion_name(index)
    return [
        Motion(name, model.info.joints, positions.numpy(), model.info.fps)
        for positions in sample(model, mu, sigma, samples, steps, chosen.seed)
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
