"""Checkpoint files: our own, and the `model.tar` that the paper's authors published.

Both are read with torch's restricted unpickler (`weights_only=True`): a file that holds anything
but tensors, strings and numbers is refused, never run.
"""

from __future__ import annotations

import importlib.resources
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import torch

from .checkpoint_content import FORMAT, check_readable, from_content, from_published, to_content
from .errors import InputError
from .files import replacing
from .model import RNNPB

MAX_CHECKPOINT_BYTES = 200_000_000

# The published files carry a few numpy scalars. These only build numbers and arrays.
_SAFE_NUMPY: list[Any] = [
    (np._core.multiarray.scalar, "numpy.core.multiarray.scalar"),  # type: ignore[attr-defined]
    (np._core.multiarray._reconstruct, "numpy.core.multiarray._reconstruct"),  # type: ignore[attr-defined]
    np.ndarray,
    np.dtype,
    np.dtypes.Float64DType,
    np.dtypes.Float32DType,
    np.dtypes.Int64DType,
]


def shipped_checkpoints() -> dict[str, Path]:
    """The checkpoints that come with the package, by name without `.pt`."""
    folder = importlib.resources.files("rnnpb_explorer.checkpoints")
    return {Path(str(p)).stem: Path(str(p)) for p in folder.iterdir() if p.name.endswith(".pt")}


def resolve_checkpoint(path_or_name: str | os.PathLike[str]) -> Path:
    """A path as it is, or the path of a shipped checkpoint (`strong` or `strong.pt`).

    Raises:
        InputError: neither; the message lists the shipped ones.
    """
    path = Path(path_or_name)
    if path.is_file():
        return path
    shipped = shipped_checkpoints()
    name = str(path_or_name).removesuffix(".pt")
    if name in shipped:
        return shipped[name]
    known = ", ".join(sorted(f"{name}.pt" for name in shipped)) or "none"
    raise InputError(f"no checkpoint {str(path_or_name)!r}; shipped with the package: {known}")


def load_checkpoint(path_or_name: str | os.PathLike[str]) -> RNNPB:
    """Load a model from a path or a shipped name, ready to generate (no gradients).

    Raises:
        InputError: no such file, no checkpoint, or one that does not fit its own config.
    """
    path = resolve_checkpoint(path_or_name)
    content = read_plain(path)
    try:
        if content.get("format") == FORMAT:
            model = from_content(content)
        elif "model_state_dict" in content and "params" in content:
            model = from_published(content)
        else:
            raise InputError("it is no RNNPB checkpoint, neither ours nor a published model.tar")
    except InputError as error:
        raise InputError(f"cannot use {path}: {error}") from error
    return model.eval().requires_grad_(False)


def read_plain(path: Path) -> dict[str, Any]:
    """Everything in a checkpoint file, by the safe reader.

    Raises:
        InputError: unreadable, too large, or anything but plain tensors, strings and numbers.
    """
    try:
        # torch would also read older files that are no archives, but those may claim any size.
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        raise InputError(f"{path} is no checkpoint, or a truncated one") from error
    if size > MAX_CHECKPOINT_BYTES:
        raise InputError(f"{path} is no checkpoint: more than {MAX_CHECKPOINT_BYTES / 1e6:g} MB")
    try:
        with torch.serialization.safe_globals(_SAFE_NUMPY):
            content = torch.load(path, weights_only=True, map_location="cpu")
    except Exception as error:
        # A damaged or hostile file makes torch raise almost anything; all of it means the same.
        raise InputError(
            f"{path} is no checkpoint that can be read safely: it holds something else than "
            "tensors, text and numbers, or is damaged"
        ) from error
    if not isinstance(content, dict):
        raise InputError(f"{path} is no RNNPB checkpoint")
    return content


def check_savable(model: RNNPB) -> None:
    """Whether `load_checkpoint` will read what is saved of a training; asked before it begins.

    Raises:
        InputError: too many units or motions, or names that it would refuse.
    """
    check_readable(model)
    numbers = sum(parameter.numel() for parameter in model.parameters())
    # An interrupted run keeps each weight and what Adam knows of it, its two moments.
    size = 3 * numbers * torch.float32.itemsize
    if size > MAX_CHECKPOINT_BYTES:
        raise InputError(
            f"a model of this size takes {size / 1e6:.0f} MB to resume, and files of more than "
            f"{MAX_CHECKPOINT_BYTES / 1e6:g} MB are not read; fewer hidden units will do"
        )


def save_checkpoint(
    model: RNNPB, path: str | os.PathLike[str], *, resume: dict[str, Any] | None = None
) -> None:
    """Write a checkpoint; an existing file is replaced whole or not at all.

    Args:
        resume: the optimiser's and the random generator's state, for an unfinished training run.

    Raises:
        InputError: the file cannot be written; one that was there is as it was.
    """
    content = to_content(model)
    if resume is not None:
        content["resume"] = resume
    try:
        # Given a name, torch would write it into the archive; equal models make equal files.
        with replacing(path) as beside, beside.open("wb") as file:
            torch.save(content, file)
    except RuntimeError as error:  # torch's own writer, when the disk is full
        raise InputError(f"cannot write {path}: {str(error).partition(chr(10))[0]}") from error
