"""A file that somebody uploads: a target with its eye colours, or the reason why it is none."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np

from ...core.errors import InputError
from ...core.motion import MAX_CSV_BYTES
from ...robot.description import Robot
from ...robot.eyes import parse_eye_colors
from ...robot.reading import (
    NOTHING_SAID,
    SUFFIXES,
    Reading,
    Said,
    Unclear,
    read_motions,
)
from ..state import intents as do
from ..state.document import EyeTrack, target_of_motion
from ..state.facts import ModelFacts
from ..state.statecode import PREFIX

MAX_UPLOAD_BYTES = MAX_CSV_BYTES
MAX_KEPT_BYTES = 2_000_000  # of a file that can be read once more as something else
TOO_LARGE = f"the file is larger than {MAX_UPLOAD_BYTES // 1_000_000} MB"
MAX_NAME = 76  # characters
CODE_SUFFIX = ".rnnpb"  # of a state code that is too long for a line
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Upload:
    """A file, and what a person says of it."""

    name: str
    load: Callable[[], bytes]
    facts: ModelFacts
    said: Said = NOTHING_SAID
    motion: str | None = None


class UploadReader:
    """Reads files on threads of its own, one after another; the last one asked for counts.

    Args:
        robot: whose limits and openings tell units apart.
        send: gets what a file is, as intents; called on one of those threads.
    """

    def __init__(self, robot: Robot, send: Callable[[do.Intent], None]) -> None:
        self._robot, self._send = robot, send
        self._turn = threading.Lock()
        self._asked = 0
        self.last: Upload | None = None  # that can be read once more

    def read(self, upload: Upload) -> None:
        """Read a file as a motion for a model; returns at once.

        It is called on viser's event loop alone. A large file takes half a second, in which nobody
        else should have to wait.
        """
        self._asked += 1
        threading.Thread(
            target=self._read, args=(self._asked, upload), name="upload", daemon=True
        ).start()

    def _read(self, number: int, upload: Upload) -> None:
        with self._turn:
            if number < self._asked:  # something else was chosen meanwhile
                return
            try:
                content = upload.load()
                intents = read_upload(upload, content, self._robot)
            except Exception as error:  # the thread's boundary: nothing may vanish unseen
                log.exception("reading the upload %r failed", upload.name)
                content = b""
                intents = (do.Say(f"the file could not be read: {error}"),)
            if number == self._asked:
                self.last = None
                if 0 < len(content) <= MAX_KEPT_BYTES:
                    self.last = Upload(upload.name, lambda: content, upload.facts)
                for intent in intents:
                    self._send(intent)


def read_upload(upload: Upload, content: bytes, robot: Robot) -> tuple[do.Intent, ...]:
    """A motion, whatever wrote it; or a state code.

    The name is a label; no file is ever opened by it.
    """
    if content.startswith(PREFIX.encode()):
        return (do.RestoreCode(content.decode("ascii", "replace")),)
    if len(content) > MAX_UPLOAD_BYTES:
        return (do.Say(TOO_LARGE),)
    stem, suffix = _label(upload.name)
    facts = upload.facts
    limits = {joint: limit for joint, limit in robot.limits.items() if np.isfinite(limit).all()}
    try:
        reading = read_motions(
            content, stem + suffix, facts.joints, said=upload.said, fps=facts.fps,
            limits=limits, openings=robot.openings,
        )  # fmt: skip
        names = tuple(motion.name for motion in reading.motions)
        motion = reading.motion(upload.motion or names[0])
    except Unclear as unclear:
        return do.Say(f"{unclear} Say it under File, below the upload"), do.ShowFile()
    except InputError as error:
        return (do.Say(str(error)),)
    eyes, remark = _eyes(content, stem + suffix, reading, len(motion))
    told = f"{motion.name}: {len(motion)} frames, ready to recognise{remark}"
    remarks = list(reading.remarks)
    if len(names) > 1:
        remarks.append(f"{len(names)} motions in it: choose one below the upload")
    if remarks:
        told += f" ({'; '.join(remarks)})"
    return (
        do.SetTarget(target_of_motion(motion, eyes)),
        do.ShowFile(motions=names),
        do.Say(told, good=True),
    )


def _label(name: str) -> tuple[str, str]:
    """What to call a file, and its end where that is one of a motion's."""
    shown = "".join(c for c in name if c.isprintable())
    suffix = PurePosixPath(shown).suffix.lower()
    suffix = suffix if suffix in SUFFIXES else ".csv"
    stem = (shown[: -len(suffix)] if shown.lower().endswith(suffix) else shown)[:MAX_NAME]
    return stem or "upload", suffix


def _eyes(
    content: bytes, source: str, reading: Reading, frames: int
) -> tuple[EyeTrack | None, str]:
    """The colours, and what to say of them; a motion is as good without."""
    if reading.format != "CSV":
        return None, ""
    try:
        eyes = parse_eye_colors(content, source)
    except InputError as error:
        return None, f"; its eye colours are left out: {error}"
    if eyes is not None and len(eyes) != frames:  # of several motions, or of another rate
        return None, "; its eye colours are left out"
    return eyes, "" if eyes is None else ", with eye colours"
