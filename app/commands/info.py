"""`rnnpb info`: what a checkpoint holds."""

from __future__ import annotations

from json import dumps
from typing import TYPE_CHECKING, Any

from .flags import Checkpoint, Data, load_model

if TYPE_CHECKING:
    from ...core.model import RNNPB


def run(*, ckpt: Checkpoint, data: Data | None = None, json: bool = False) -> None:
    """Print what the checkpoint holds, for people or programs.

    Args:
        json: print one JSON object
    """
    model, _ = load_model(ckpt, data)
    facts = describe(model)
    if json:
        print(dumps(facts, ensure_ascii=False, indent=2, allow_nan=False))
        return
    shown = {name: facts[name] for name in ("pb_dim", "hidden_size", "behavior", "beta", "fps")}
    shown |= {"joints": ", ".join(facts["joints"])} | facts["metrics"] | model.info.training
    if model.info.attribution:
        shown["attribution"] = model.info.attribution
    shown["motions"] = model.config.num_motions
    width = max(map(len, shown))
    for name, value in shown.items():
        text = f"{value:.6g}" if isinstance(value, float) else str(value)
        print(f"{name:{width}}  {text}")
    for index in range(model.config.num_motions if model.info.motions else 0):
        print(f"  {index:3}  {model.motion_name(index):24} {model.length(index)} frames")


def describe(model: RNNPB) -> dict[str, Any]:
    """The fields of `rnnpb info --json`."""
    return {
        "pb_dim": model.config.pb_dim,
        "hidden_size": model.config.hidden_size,
        "behavior": model.config.behavior,
        "beta": model.config.beta,
        "joints": list(model.info.joints),
        "fps": model.info.fps,
        "motions": list(model.info.motions),
        "lengths": list(model.info.lengths),
        "metrics": dict(model.info.metrics),
    }
