"""Checkpoint files: our own, and the `model.tar` that the paper's authors published.

Both are read with torch's restricted unpickler (`weights_only=True`): a file that holds anything but
tensors, strings and numbers is refused, never run.
"""

from __future__ import annotations

import importlib.resources
import os
import pickle
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch

from .data import PEPPER_JOINTS
from .errors import InputError
from .model import ModelConfig, ModelInfo, MotionLabel, RNNPB

FORMAT = "rnnpb-explorer"
FORMAT_VERSION = 1
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
        InputError: no such file, no checkpoint, or one whose shapes do not fit its own config.
    """
    path = resolve_checkpoint(path_or_name)
    content = read_plain(path)
    if content.get("format") == FORMAT:
        model = _from_content(content, path)
    elif "model_state_dict" in content and "params" in content:
        model = _from_published(content, path)
    else:
        raise InputError(f"{path} is no RNNPB checkpoint (neither ours nor a published model.tar)")
    return model.eval().requires_grad_(False)


def read_plain(path: Path) -> dict[str, Any]:
    """Everything in a checkpoint file, by the safe reader.

    Raises:
        InputError: unreadable, too large, or anything but plain tensors, strings and numbers.
    """
    try:
        if path.stat().st_size > MAX_CHECKPOINT_BYTES:
            raise InputError(f"{path} is larger than {MAX_CHECKPOINT_BYTES} bytes")
        with torch.serialization.safe_globals(_SAFE_NUMPY):
            content = torch.load(path, weights_only=True, map_location="cpu")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    except (pickle.UnpicklingError, RuntimeError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path} is no checkpoint that can be read safely") from error
    if not isinstance(content, dict):
        raise InputError(f"{path} is no RNNPB checkpoint")
    return content


def save_checkpoint(
    model: RNNPB, path: str | os.PathLike[str], *, resume: dict[str, Any] | None = None
) -> None:
    """Write a checkpoint; an existing file is replaced whole or not at all.

    Args:
        resume: the optimiser's and the random generator's state, for an unfinished training run.
    """
    path = Path(path)
    content: dict[str, Any] = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "config": asdict(model.config),
        "info": asdict(model.info),
        "state": {name: value.detach().cpu() for name, value in model.state_dict().items()},
    }
    if resume is not None:
        content["resume"] = resume
    beside = path.with_name(path.name + ".part")
    try:
        torch.save(content, beside)
        os.replace(beside, path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error


def _from_content(content: dict[str, Any], path: Path) -> RNNPB:
    if content.get("version") != FORMAT_VERSION:
        raise InputError(
            f"{path} has format version {content.get('version')}, this reads {FORMAT_VERSION}"
        )
    try:
        info = dict(content["info"])
        info["labels"] = {name: MotionLabel(**label) for name, label in info["labels"].items()}
        for key in ("joints", "motions", "lengths"):
            info[key] = tuple(info[key])
        model = RNNPB(ModelConfig(**content["config"]), ModelInfo(**info))
        state = content["state"]
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path} is incomplete or damaged: {error}") from error
    _load_state(model, state, path)
    return model


def _from_published(content: dict[str, Any], path: Path) -> RNNPB:
    try:
        sizes = content["params"]["model"]
        stochastic = sizes["behavior"] == "stochastic"
        config = ModelConfig(
            num_joints=int(sizes["data_dim"]),
            pb_dim=int(sizes["pb_size"]),
            hidden_size=int(sizes["hidden_size"]),
            num_motions=int(sizes["num_pb"]),
            behavior=sizes["behavior"],
            beta=float(sizes["beta"]) if stochastic else None,
        )
        published = content["model_state_dict"]
        joints = config.num_joints
        weight_input = published["lstm.weight_ih_l0"]  # (4H, J + D): [frame; PB]
        state = {
            "mu": published["mu_pb"],
            "log_var": published.get("logvar_pb", torch.zeros_like(published["mu_pb"])),
            "weight_frame": weight_input[:, :joints],
            "weight_pb": weight_input[:, joints:],
            "weight_hidden": published["lstm.weight_hh_l0"],
            "bias": published["lstm.bias_ih_l0"] + published["lstm.bias_hh_l0"],
            "weight_out": published["linear.weight"],
            "bias_out": published["linear.bias"],
        }
    except (KeyError, TypeError, AttributeError, IndexError, RuntimeError) as error:
        raise InputError(f"{path} is no published RNNPB checkpoint: {error}") from error
    names = (
        PEPPER_JOINTS
        if joints == len(PEPPER_JOINTS)
        else tuple(f"joint {i}" for i in range(joints))
    )
    model = RNNPB(
        config,
        ModelInfo(joints=names, attribution="published with the paper by J. Hwang, MIT licence"),
    )
    _load_state(model, state, path)
    return model


def _load_state(model: RNNPB, state: dict[str, torch.Tensor], path: Path) -> None:
    for name, parameter in model.state_dict().items():
        if name not in state:
            raise InputError(f"{path} lacks {name}")
        if state[name].shape != parameter.shape:
            raise InputError(
                f"{path}: {name} has shape {tuple(state[name].shape)}, "
                f"its config asks for {tuple(parameter.shape)}"
            )
        if not torch.isfinite(state[name]).all():
            raise InputError(f"{path}: {name} holds NaN or infinity")
    info, config = model.info, model.config
    if len(info.joints) != config.num_joints:
        raise InputError(f"{path} names {len(info.joints)} joints for {config.num_joints} outputs")
    for what, names in (("motions", info.motions), ("lengths", info.lengths)):
        if names and len(names) != config.num_motions:
            raise InputError(f"{path} has {len(names)} {what} for {config.num_motions} PBs")
    model.load_state_dict(state)
