"""The state code: one line of text that restores what is on the screen.

It holds numbers and names only. A code from anywhere is checked like any other input: what does not
fit the loaded models is refused with one line, and the screen stays as it is.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import zlib
from dataclasses import replace
from typing import Any

import numpy as np

from ...core.errors import InputError
from ...robot.formats import FORMATS
from . import intents as do
from .document import AppState, ExportOptions, Latent, ModelFacts, Playback
from .on_latent import MAX_MU, MAX_SIGMA
from .on_view import MAX_SPEED, MIN_SPEED
from .slices import drawable_axes
from .transitions import (
    Facts,
    Update,
    given_target,
    notify,
    opening_work,
    put_model,
    remember,
    stop_recognition,
)

PREFIX = "rnnpb1-"
MAX_CODE_LENGTH = 64_000  # four models of 128 dimensions take 27,000
MAX_TEXT_LENGTH = 100_000
MAX_COUNT = 2**32 - 1


def encode(facts: Facts, state: AppState) -> str:
    """The state code of a screen.

    An uploaded motion is not in it, only whether there was one in use; nor is a recognition, nor
    that somebody insisted on an export beyond the limits: that is for each one to say.
    """
    uses_target = any(given_target(facts, state, index) for index in range(len(facts)))
    content = {
        "models": [
            {
                "name": one.name,
                "motion": one.motions[model.latent.motion],
                "mu": model.latent.mu.tolist(),
                "sigma": model.latent.sigma.tolist(),
                "epsilon": model.latent.epsilon.tolist(),
                "anchor": model.anchor.tolist(),
            }
            for one, model in zip(facts, state.models, strict=True)
        ],
        "active": state.active,
        "playback": [
            state.playback.playing,
            state.playback.phase,
            state.playback.speed,
            state.playback.loop,
        ],
        "map_axes": state.map_axes,
        "landscape_axes": state.landscape_axes,
        "window": state.window,
        "colouring": state.colouring,
        "joint": state.joint,
        "side_by_side": state.side_by_side,
        "eyes": state.eyes,
        "export": [state.export.file_format, state.export.safe_posture],
        "draws": state.draws,
        "seed": state.seed,
        "target": uses_target,
    }
    packed = zlib.compress(json.dumps(content, separators=(",", ":")).encode(), 9)
    return PREFIX + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def decode(facts: Facts, state: AppState, code: str) -> AppState:
    """`state` with everything that the code holds.

    Where the code was made without an uploaded motion, or before codes said so, one that is there
    is not compared with.

    Raises:
        InputError: not a state code, or one of other models than are loaded.
    """
    content = _unpack(code.strip())
    try:
        if len(content["models"]) != len(facts):
            raise InputError(
                f"the state code is of {len(content['models'])} models, here are {len(facts)}"
            )
        for index, (one, saved) in enumerate(zip(facts, content["models"], strict=True)):
            latent = _latent(one, saved)
            anchor = _vector(saved["anchor"], one.pb_dim, -MAX_MU, MAX_MU)
            model = replace(state.models[index], latent=latent, anchor=anchor)
            state = put_model(state, index, model)
        playing, phase, speed, loop = content["playback"]
        active = int(content["active"])
        if not 0 <= active < len(facts):
            raise InputError("the state code is damaged")
        dim = facts[active].pb_dim
        landscape_axes = content["landscape_axes"]
        return replace(
            state,
            active=active,
            playback=Playback(
                bool(playing),
                _number(phase, 0.0, 1.0),
                _number(speed, MIN_SPEED, MAX_SPEED),
                bool(loop),
            ),
            map_axes=_axes(content["map_axes"], dim),
            landscape_axes="pca" if landscape_axes == "pca" else _axes(landscape_axes, dim),
            window="sd" if content["window"] == "sd" else "absolute",
            colouring=(
                content["colouring"]
                if content["colouring"] in ("class", "valence", "arousal")
                else "class"
            ),
            joint=content["joint"] if content["joint"] in facts[active].joints else "",
            side_by_side=content.get("side_by_side") is True,
            eyes=content.get("eyes") is not False,
            export=_export(state.export, content.get("export")),
            use_target=content.get("target") is True,
            draws=int(_number(content["draws"], 0, MAX_COUNT)),
            seed=int(_number(content["seed"], 0, MAX_COUNT)),
        )
    except (KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("the state code is damaged") from error


def restore(facts: Facts, state: AppState, intent: do.RestoreCode) -> Update:
    """Put the screen of a code on, or say why not; undo leads back to all that it replaced."""
    try:
        restored = decode(facts, state, intent.code)
    except InputError as error:
        return notify(state, str(error)), ()
    state, works = stop_recognition(state)
    state = remember(state, "", whole=True)
    restored = replace(
        restored,
        undo=state.undo,
        redo=state.redo,
        recognition=state.recognition,
        gesture="",
    )
    if restored.use_target:
        here = given_target(facts, restored, restored.active)
        instead = "the model's own" if here is None else here.name
        restored = notify(
            restored,
            "The code was made with an uploaded motion, which a code does not hold; "
            f"here {instead} stands in",
            good=True,
        )
    restored, more = opening_work(facts, restored)
    return restored, works + more


def _unpack(code: str) -> dict[str, Any]:
    if not code.startswith(PREFIX):
        raise InputError(f"not a state code; one begins with {PREFIX}")
    if len(code) > MAX_CODE_LENGTH:
        raise InputError(f"the state code is longer than {MAX_CODE_LENGTH} characters")
    packed = code.removeprefix(PREFIX)
    try:
        raw = base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4))
        text = zlib.decompressobj().decompress(raw, MAX_TEXT_LENGTH)  # no zip bomb
        content = json.loads(text)
    except (binascii.Error, zlib.error, ValueError, RecursionError) as error:
        raise InputError("the state code is damaged") from error
    if not isinstance(content, dict):
        raise InputError("the state code is damaged")
    return content


def _latent(facts: ModelFacts, saved: dict[str, Any]) -> Latent:
    if saved["name"] != facts.name or saved["motion"] not in facts.motions:
        name = str(saved["name"])[:40]
        raise InputError(f"the state code is of another model, {name!r}; here is {facts.name!r}")
    return Latent(
        motion=facts.motions.index(saved["motion"]),
        mu=_vector(saved["mu"], facts.pb_dim, -MAX_MU, MAX_MU),
        sigma=_vector(saved["sigma"], facts.pb_dim, 0.0, MAX_SIGMA),
        epsilon=_vector(saved["epsilon"], facts.pb_dim, -10.0, 10.0),
    )


def _export(known: ExportOptions, saved: Any) -> ExportOptions:
    """Codes of before there was an export have nothing of it."""
    if saved is None:
        return known
    file_format, safe_posture = saved
    return ExportOptions(file_format if file_format in FORMATS else "csv", bool(safe_posture))


def _number(value: float, low: float, high: float) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise InputError("the state code is damaged")
    return min(max(number, low), high)


def _vector(values: list[float], dim: int, low: float, high: float) -> np.ndarray:
    vector = np.array(values, dtype=np.float64)
    if vector.shape != (dim,) or not np.isfinite(vector).all():
        raise InputError("the state code is damaged")
    return np.clip(vector, low, high)


def _axes(axes: list[int], dim: int) -> tuple[int, ...]:
    chosen = tuple(int(axis) for axis in axes)
    if not drawable_axes(chosen, dim):
        raise InputError("the state code names axes that the model does not have")
    return chosen
