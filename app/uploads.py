"""A file that somebody uploads: a target with its eye colours, or the reason why it is none."""

from __future__ import annotations

from pathlib import PurePosixPath

from ..core.errors import InputError
from ..core.motion import MAX_CSV_BYTES
from ..robot.eyes import parse_eye_colors
from ..robot.importing import SUFFIXES, import_motion
from . import intents as do
from .state import EyeTrack, ModelFacts

MAX_NAME = 76  # characters


def read_upload(name: str, content: bytes, facts: ModelFacts) -> do.Intent:
    """A motion as CSV, JSON or NAOqi script, whatever its name's end says it is.

    The name is a label; no file is ever opened by it.
    """
    if len(content) > MAX_CSV_BYTES:
        return do.RefuseTarget(f"the file is larger than {MAX_CSV_BYTES // 1_000_000} MB")
    shown = "".join(c for c in name if c.isprintable())
    suffix = PurePosixPath(shown).suffix.lower()
    suffix = suffix if suffix in SUFFIXES else ".csv"
    stem = (shown[: -len(suffix)] if shown.lower().endswith(suffix) else shown)[:MAX_NAME]
    stem = stem or "upload"
    source = stem + suffix
    try:
        motion = import_motion(
            content, suffix, facts.joints, name=stem, source=source, fps=facts.fps
        )
    except InputError as error:
        return do.RefuseTarget(str(error))
    eyes, remark = _eyes(content, source) if suffix == ".csv" else (None, "")
    return do.SetTarget(motion, eyes, remark)


def _eyes(content: bytes, source: str) -> tuple[EyeTrack | None, str]:
    """The colours, and what to say of them; a motion is as good without."""
    try:
        eyes = parse_eye_colors(content, source)
    except InputError as error:
        return None, f"; its eye colours are left out: {error}"
    return eyes, "" if eyes is None else ", with eye colours"
