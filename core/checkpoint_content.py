"""What a checkpoint file holds, checked before anything is built from it.

The content comes from a file that anybody may have written: tensors, strings, numbers, lists and
dicts, and nothing is known of them until it has been looked at.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

import torch
from torch import Tensor

from .errors import InputError
from .model import RNNPB, ModelConfig, ModelInfo
from .motion import MAX_FRAMES, MotionLabel
from .published import PUBLISHED_JOINTS

FORMAT = "rnnpb-explorer"
FORMAT_VERSION = 1
# Far beyond any use of the model; a config that asks for more is damaged or means harm.
LARGEST = {"num_joints": 1_000, "pb_dim": 128, "hidden_size": 4_096, "num_motions": 100_000}
MAX_FPS = 1_000.0
MAX_PARAMETER = 1e6
MAX_NUMBER = 1e300


def to_content(model: RNNPB) -> dict[str, Any]:
    """The model as plain tensors, strings, numbers, lists and dicts."""
    return {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "config": asdict(model.config),
        "info": asdict(model.info),
        "state": {name: value.detach().cpu() for name, value in model.state_dict().items()},
    }


def check_readable(model: RNNPB) -> None:
    """Whether its file, once written, will be read; asked before a long training.

    Raises:
        InputError: `from_content` would refuse its sizes or names.
    """
    config = _config(asdict(model.config))
    _info(asdict(model.info), config)


def from_content(content: Mapping[str, Any]) -> RNNPB:
    """The model of one of our own files.

    Raises:
        InputError: something is missing, of another kind or size than it should be, or not finite.
    """
    version = content.get("version")
    if not isinstance(version, int) or version != FORMAT_VERSION:
        raise InputError(f"format version {_shown(version)}, this program reads {FORMAT_VERSION}")
    config = _config(_dict(content.get("config"), "config"))
    info = _info(_dict(content.get("info"), "info"), config)
    return _build(config, info, _dict(content.get("state"), "state"))


def from_published(content: Mapping[str, Any]) -> RNNPB:
    """The model of a `model.tar` that the paper's authors published.

    It has neither names nor lengths of its motions. Its input is [frame; PB] (the paper writes it
    the other way round), its LSTM has two biases that are only ever added.

    Raises:
        InputError: see `from_content`.
    """
    params = _dict(content.get("params"), "params")
    sizes = _dict(params.get("model"), "params: model")
    config = _config(
        {
            "num_joints": sizes.get("data_dim"),
            "pb_dim": sizes.get("pb_size"),
            "hidden_size": sizes.get("hidden_size"),
            "num_motions": sizes.get("num_pb"),
            "behavior": sizes.get("behavior"),
            "beta": None if sizes.get("behavior") == "deterministic" else sizes.get("beta"),
        }
    )
    layers = sizes.get("num_layers", 1)
    if not isinstance(layers, int) or layers != 1:
        raise InputError(f"{_shown(layers)} LSTM layers, this program reads 1")
    published = _dict(content.get("model_state_dict"), "model_state_dict")
    joints, gates = config.num_joints, 4 * config.hidden_size
    names = {
        "mu_pb": (config.num_motions, config.pb_dim),
        "logvar_pb": (config.num_motions, config.pb_dim),
        "lstm.weight_ih_l0": (gates, joints + config.pb_dim),
        "lstm.weight_hh_l0": (gates, config.hidden_size),
        "lstm.bias_ih_l0": (gates,),
        "lstm.bias_hh_l0": (gates,),
        "linear.weight": (joints, config.hidden_size),
        "linear.bias": (joints,),
    }
    if config.behavior == "deterministic" and "logvar_pb" not in published:
        del names["logvar_pb"]
    tensors = {name: _tensor(published.get(name), name, shape) for name, shape in names.items()}
    weight_input = tensors["lstm.weight_ih_l0"]  # (4H, J + D)
    state = {
        "mu": tensors["mu_pb"],
        "log_var": tensors.get("logvar_pb", torch.zeros_like(tensors["mu_pb"])),
        "weight_frame": weight_input[:, :joints].contiguous(),
        "weight_pb": weight_input[:, joints:].contiguous(),
        "weight_hidden": tensors["lstm.weight_hh_l0"],
        "bias": tensors["lstm.bias_ih_l0"] + tensors["lstm.bias_hh_l0"],
        "weight_out": tensors["linear.weight"],
        "bias_out": tensors["linear.bias"],
    }
    known = joints == len(PUBLISHED_JOINTS)
    info = ModelInfo(
        joints=PUBLISHED_JOINTS if known else tuple(f"joint {i}" for i in range(joints)),
        attribution="published with the paper by J. Hwang, MIT licence",
    )
    return _build(config, info, state)


def _build(config: ModelConfig, info: ModelInfo, state: Mapping[str, Any]) -> RNNPB:
    with torch.device("meta"):  # shapes without memory: those of the file are not trusted yet
        model = RNNPB(config, info)
    parameters = {
        name: _tensor(state.get(name), name, tuple(wanted.shape))
        for name, wanted in model.state_dict().items()
    }
    if not torch.isfinite(torch.exp(0.5 * parameters["log_var"])).all():
        raise InputError("log_var holds values whose sigma is not finite")
    model.load_state_dict(parameters, assign=True)
    return model


def _tensor(value: object, name: str, shape: tuple[int, ...]) -> Tensor:
    """A copy in float32, if it is the tensor that is wanted here."""
    if not isinstance(value, Tensor):
        raise InputError(f"it has no tensor {name}")
    if tuple(value.shape) != shape:
        raise InputError(
            f"{name} has shape {tuple(value.shape)}, its config asks for shape {shape}"
        )
    plain = value.layout == torch.strided and value.device.type == "cpu"
    if not (plain and value.is_floating_point()):
        raise InputError(f"{name} is no ordinary tensor of real numbers")
    # A tensor may claim to be larger than the numbers it holds, by repeating them.
    if value.numel() * value.element_size() > value.untyped_storage().nbytes():
        raise InputError(f"{name} has fewer numbers than its shape {shape} says")
    copy = value.detach().to(torch.float32, copy=True).contiguous()
    if not torch.isfinite(copy).all():
        raise InputError(f"{name} holds NaN or infinity")
    if copy.abs().max() > MAX_PARAMETER:
        raise InputError(f"{name} holds numbers beyond {MAX_PARAMETER:g}")
    return copy


def _config(values: Mapping[str, Any]) -> ModelConfig:
    known = {field.name for field in fields(ModelConfig)}
    _no_others(values, known, "config")
    sizes = {name: _whole(values.get(name), name, 1, most) for name, most in LARGEST.items()}
    behavior = values.get("behavior")
    if behavior not in ("stochastic", "deterministic"):
        raise InputError(f"behavior is {_shown(behavior)}, expected stochastic or deterministic")
    beta = values.get("beta")
    if behavior == "deterministic":
        return ModelConfig(**sizes, behavior="deterministic", beta=None)
    return ModelConfig(**sizes, behavior="stochastic", beta=_number(beta, "beta", 0.0))


def _info(values: Mapping[str, Any], config: ModelConfig) -> ModelInfo:
    known = {field.name for field in fields(ModelInfo)}
    _no_others(values, known, "info")
    joints = _names(values.get("joints"), "joints")
    if len(joints) != config.num_joints:
        raise InputError(f"it names {len(joints)} joints for {config.num_joints} outputs")
    motions = _names(values.get("motions", ()), "motions")
    lengths = tuple(
        _whole(length, "length of a motion", 1, MAX_FRAMES)
        for length in _list(values.get("lengths", ()), "lengths")
    )
    for what, entries in (("motions", motions), ("lengths", lengths)):
        if entries and len(entries) != config.num_motions:
            raise InputError(f"it has {len(entries)} {what} for {config.num_motions} PBs")
    labels = _dict(values.get("labels", {}), "labels")
    metrics = _dict(values.get("metrics", {}), "metrics")
    return ModelInfo(
        joints=joints,
        fps=_number(values.get("fps", 25.0), "fps", 1e-3, MAX_FPS),
        motions=motions,
        lengths=lengths,
        labels={_text(name, "label"): _label(label) for name, label in labels.items()},
        training=_record(_dict(values.get("training", {}), "training")),
        metrics={
            _text(name, "metric"): _number(value, f"metric {_shown(name)}")
            for name, value in metrics.items()
        },
        attribution=_text(values.get("attribution", ""), "attribution"),
    )


def _label(value: object) -> MotionLabel:
    label = _dict(value, "label")
    _no_others(label, {field.name for field in fields(MotionLabel)}, "label")

    def rating(name: str) -> float | None:
        number = label.get(name)
        return None if number is None else _number(number, name)

    return MotionLabel(
        _text(label.get("behavior_class"), "behavior_class"), rating("valence"), rating("arousal")
    )


def _record(values: Mapping[str, Any]) -> dict[str, float | int | str]:
    for name, value in values.items():
        _text(name, "entry of the training record")
        if not isinstance(value, str | int | float):
            raise InputError(f"its training record has no plain value for {_shown(name)}")
    return dict(values)


def _dict(value: object, what: str) -> dict[Any, Any]:
    table: dict[Any, Any] = _kind(value, dict, what, "a table")
    return table


def _list(value: object, what: str) -> list[Any]:
    return list(_kind(value, (list, tuple), what, "a list"))


def _text(value: object, what: str) -> str:
    return str(_kind(value, str, what, "text"))


def _kind(value: object, kind: Any, what: str, wanted: str) -> Any:
    if not isinstance(value, kind):
        raise InputError(f"{what} is {_shown(value)}, expected {wanted}")
    return value


def _names(value: object, what: str) -> tuple[str, ...]:
    names = tuple(_text(name, f"one of its {what}") for name in _list(value, what))
    if len(set(names)) != len(names):
        raise InputError(f"two of its {what} have the same name")
    if not all(name and name.isprintable() for name in names):
        raise InputError(f"the names of its {what} hold characters that cannot be shown")
    return names


def _whole(value: object, what: str, least: int, most: int) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
        raise InputError(f"{what} is {_shown(value)}, expected a whole number {least} to {most}")
    return value


def _number(
    value: object, what: str, least: float = -MAX_NUMBER, most: float = MAX_NUMBER
) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{what} is {_shown(value)}, expected a number")
    if not least <= value <= most:  # true for NaN, too
        raise InputError(f"{what} is {_shown(value)}, expected a finite number in its range")
    return float(value)


def _no_others(values: Mapping[str, Any], known: set[str], what: str) -> None:
    others = [_shown(name) for name in values if name not in known]
    if others:
        raise InputError(f"{what} has entries this program does not know: {', '.join(others[:3])}")


def _shown(value: object) -> str:
    """The value for a message: short, whatever it is."""
    if isinstance(value, int) and value.bit_length() > 64:
        return "a huge number"
    if isinstance(value, str | int | float | None):
        text = repr(value[:50] if isinstance(value, str) else value)
        return text if len(text) <= 40 else text[:40] + "..."
    return f"a {type(value).__name__}"
