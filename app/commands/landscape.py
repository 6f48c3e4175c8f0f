"""`rnnpb landscape`: the correlation landscape around a learned motion, as numbers or a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from ...core.errors import InputError
from ...core.files import check_writable, replacing
from .flags import (
    Checkpoint,
    Data,
    DeviceName,
    FileFlags,
    load_model,
    note,
    read_by,
    read_target,
    real,
    whole,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...core.data import Dataset
    from ...core.model import RNNPB
    from ...core.windows import Landscape

MAX_GRID = 200
MAX_RADIUS = 1e3
PCA = ()  # what `--axes pca` parses to
SUFFIXES = (".npz", ".png")
Radius = tuple[float, str]  # with its unit, absolute or sd


def _axes(text: str) -> tuple[int, ...]:
    if text == "pca":
        return PCA
    axes = tuple(whole(1, 128)(part) - 1 for part in text.split(","))
    if len(axes) > 2 or len(set(axes)) != len(axes):
        raise ValueError(f"must be two different numbers or pca, got {text}")
    return axes


def _radius(text: str) -> Radius:
    number = text.removesuffix("sd")
    return real(above=0.0, maximum=MAX_RADIUS)(number), "sd" if number != text else "absolute"


def run(
    file: FileFlags | None = None,
    *,
    ckpt: Checkpoint,
    motion: str,
    target: Path | None = None,
    axes: Annotated[tuple[int, ...], read_by(_axes, "1,2|pca", shown="1,2")] = (0, 1),
    radius: Annotated[Radius, read_by(_radius, "r|r sd", shown="1.0")] = (1.0, "absolute"),
    grid: Annotated[int, read_by(whole(2, MAX_GRID))] = 20,
    data: Data | None = None,
    device: DeviceName = "auto",
    out: Path,
) -> None:
    """Write the landscape as numbers or a picture, and print its measures.

    Args:
        motion: a learned motion, by name or index from 0
        target: the motion to compare with; default: NAME from --data, else the model's own
            reconstruction of NAME
        axes: two components of the PB counted from 1, or the two principal ones
        radius: half of the window; 0.7sd is in standard deviations of the learned mu, the mean
            over components
        grid: points a side
        out: L.npz or L.png
    """
    if out.suffix.lower() not in SUFFIXES:
        raise InputError(f"--out {out}: a landscape is written as {' or '.join(SUFFIXES)}")
    check_writable(out)
    model, dataset = load_model(ckpt, data, file)
    index = model.motion_index(motion)
    compared = _target(model, dataset, index, target, file or FileFlags())

    from ...core.correlation import landscape
    from ...core.device import choose_device

    window = _window(model, index, axes, radius)
    model.to(choose_device(device))
    result = landscape(model, compared, grid=grid, **window)
    _save(result, out, model.motion_name(index), _axis_names(axes, model.config.pb_dim))
    measures = f"mean {result.mean:.4f}, area {result.area:.4f}, roughness {result.roughness:.4f}"
    print(f"{measures}: {out}")
    if target is None and dataset is None:
        note("no --target and no --data: the model's own reconstruction is the target")


def _target(
    model: RNNPB, dataset: Dataset | None, index: int, path: Path | None, file: FileFlags
) -> NDArray[np.float32]:
    """(T, J) what the generated motions are compared with; it decides their length."""
    if path is not None:
        return read_target(path, model.info.joints, model.info.fps, file).positions
    if dataset is not None:
        return dataset.motions[index].positions
    reconstruction: NDArray[np.float32] = model.reconstruct(index).numpy()
    return reconstruction


def _window(model: RNNPB, index: int, axes: tuple[int, ...], radius: Radius) -> dict[str, Any]:
    """Centre, axes and size of the window, as `landscape` takes them."""
    import numpy as np

    from ...core.latent_map import LatentMap, spread
    from ...core.windows import unit_directions

    mu = model.mu.cpu().numpy()
    dimensions = model.config.pb_dim
    if axes == PCA:
        latent_map = LatentMap.fit(mu)
        directions = latent_map.components[:2]
        origin = latent_map.mean
    else:
        shown = tuple(axis + 1 for axis in axes)
        if dimensions > 1 and len(axes) != 2:
            raise InputError(f"--axes needs two numbers, as in 1,2, got {shown[0]}")
        if dimensions > 1 and max(axes) >= dimensions:
            raise InputError(f"--axes {shown[0]},{shown[1]}: this PB has {dimensions} components")
        directions = unit_directions(dimensions, axes)
        origin = np.zeros(dimensions)
    size, kind = radius
    return {
        "center": mu[index],
        "directions": directions,
        "origin": origin,
        "radius": size * (spread(mu) if kind == "sd" else 1.0),
    }


def _axis_names(axes: tuple[int, ...], dimensions: int) -> list[str]:
    if axes == PCA:
        return [f"PC {i + 1}" for i in range(min(2, dimensions))]
    return [rf"$\mu_{{{axis + 1}}}$" for axis in axes[:dimensions]]


def _save(result: Landscape, out: Path, name: str, axis_names: list[str]) -> None:
    import numpy as np

    with replacing(out) as beside:
        if out.suffix.lower() == ".png":
            from ...core.paper.figures.landscapes import draw_landscape

            draw_landscape(result, beside, name, axis_names)
        else:
            with beside.open("wb") as file:  # to a name, numpy would add .npz where it reads .NPZ
                np.savez_compressed(
                    file,
                    correlation=result.correlation,
                    x=result.x,
                    y=result.y,
                    mean=result.mean,
                    area=result.area,
                    roughness=result.roughness,
                )
