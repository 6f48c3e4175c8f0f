"""A file that somebody uploads: a target with its eye colours, or the reason why it is none."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from pathlib import PurePosixPath

from ...core.errors import InputError
from ...core.motion import MAX_CSV_BYTES
from ...robot.eyes import parse_eye_colors
from ...robot.importing import SUFFIXES, import_motion
from ..state import intents as do
from ..state.document import EyeTrack, target_of_motion
from ..state.facts import ModelFacts
from ..state.statecode import PREFIX

MAX_UPLOAD_BYTES = MAX_CSV_BYTES
TOO_LARGE = f"the file is larger than {MAX_UPLOAD_BYTES // 1_000_000} MB"
MAX_NAME = 76  # characters
CODE_SUFFIX = ".rnnpb"  # of a state code that is too long for a line
log = logging.getLogger(__name__)


class UploadReader:
    """Reads files on threads of its own, one after another; the last one asked for counts.

    Args:
        send: gets what a file is, as intents; called on one of those threads.
    """

    def __init__(self, send: Callable[[do.Intent], None]) -> None:
        self._send = send
        self._turn = threading.Lock()
        self._asked = 0

    def read(self, name: str, load: Callable[[], bytes], facts: ModelFacts) -> None:
        """Read what `load` brings as a motion for a model; returns at once.

        It is called on viser's event loop alone. A large file takes half a second, in which nobody
        else should have to wait.
        """
        self._asked += 1
        threading.Thread(
            target=self._read, args=(self._asked, name, load, facts), name="upload", daemon=True
        ).start()

    def _read(self, number: int, name: str, load: Callable[[], bytes], facts: ModelFacts) -> None:
        with self._turn:
            if number < self._asked:  # something else was chosen meanwhile
                return
            try:
                intents = read_upload(name, load(), facts)
            except Exception as error:  # the thread's boundary: nothing may vanish unseen
                log.exception("reading the upload %r failed", name)
                intents = (do.Say(f"the file could not be read: {error}"),)
            if number == self._asked:
                for intent in intents:
                    self._send(intent)


def read_upload(name: str, content: bytes, facts: ModelFacts) -> tuple[do.Intent, ...]:
    """A motion as CSV, JSON or NAOqi script, whatever its name's end says it is; or a state code.

    The name is a label; no file is ever opened by it.
    """
    if content.startswith(PREFIX.encode()):
        return (do.RestoreCode(content.decode("ascii", "replace")),)
    if len(content) > MAX_UPLOAD_BYTES:
        return (do.Say(TOO_LARGE),)
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
        return (do.Say(str(error)),)
    eyes, remark = _eyes(content, source) if suffix == ".csv" else (None, "")
    told = f"{motion.name}: {len(motion)} frames, ready to recognise{remark}"
    return do.SetTarget(target_of_motion(motion, eyes)), do.Say(told, good=True)


def _eyes(content: bytes, source: str) -> tuple[EyeTrack | None, str]:
    """The colours, and what to say of them; a motion is as good without."""
    try:
        eyes = parse_eye_colors(content, source)
    except InputError as error:
        return None, f"; its eye colours are left out: {error}"
    return eyes, "" if eyes is None else ", with eye colours"
