"""What a page may say: the messages that viser's page really sends, within limits.

viser itself takes any of its 200 message types from a page, ends with a traceback at one that it
does not know, lets an update set any attribute of a widget, and believes the size that an upload
declares. So every message is looked at here first. It passes, it is dropped, or it costs the page
that sent it: `PageRefused`, after which that connection is closed and no other is touched.

Nothing here knows a socket. `guard` puts the gate into the server.

A message of our own is one more class below `Incoming`, with the name and the fields that it has
on the wire, in what `Guard` gets as `messages`; so is one of viser's that a widget not used so far
sends (forms, gizmos, pointers on the whole scene).
"""

from __future__ import annotations

import functools
import math
import operator
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import msgspec
from viser import GuiUploadButtonHandle

from .uploads import MAX_UPLOAD_BYTES

MAX_MESSAGE_BYTES = 1 << 20  # a part of an upload has half of it, a state code a sixteenth
# viser sends at most 20 messages a second for each thing that a hand moves, a pointer at most 120;
# a page that comes to itself after a pause sends what has piled up.
MESSAGES_PER_SECOND, MESSAGES_AT_ONCE = 200.0, 1000.0
BYTES_PER_SECOND, BYTES_AT_ONCE = 4e6, 4.0 * MAX_UPLOAD_BYTES
MAX_TRANSFERS = 2  # of one page at once; the page itself offers one

Name = Annotated[str, msgspec.Meta(max_length=1000)]
Count = Annotated[int, msgspec.Meta(ge=0)]
Pair = tuple[float, float]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Scalar = bool | int | float | str


class PageRefused(Exception):
    """A page sent what no page of ours sends; the text is the reason, in a few words."""


class Incoming(msgspec.Struct, tag_field="type", tag=True, forbid_unknown_fields=True):
    """A message of a page; a subclass has the name and the fields of one on the wire."""


class ViewerCameraMessage(Incoming):
    wxyz: Quaternion
    position: Vector
    fov: float
    near: float
    far: float
    image_height: float
    image_width: float
    look_at: Vector
    up_direction: Vector


class Updates(msgspec.Struct, forbid_unknown_fields=True):
    """Of all that a widget has, a page sets its value alone."""

    value: Scalar | list[Scalar]


class GuiUpdateMessage(Incoming):
    uuid: Name
    updates: Updates


class CommandTriggerMessage(Incoming):
    uuid: Name


class FileTransferStartUpload(Incoming):
    source_component_uuid: Name
    transfer_uuid: Name
    filename: Name
    mime_type: Name
    part_count: Count
    size_bytes: Count


class FileTransferPart(Incoming):
    source_component_uuid: Name | None
    transfer_uuid: Name
    part_index: Count
    content: bytes


class RnnpbAsked(Incoming):
    """Our own part's word; what is in it is checked by `asked.py`."""

    payload: Annotated[str, msgspec.Meta(max_length=MAX_MESSAGE_BYTES)]


PAGE_MESSAGES: tuple[type[Incoming], ...] = (
    ViewerCameraMessage,
    GuiUpdateMessage,
    CommandTriggerMessage,
    FileTransferStartUpload,
    FileTransferPart,
    RnnpbAsked,
)


def decoder(messages: Sequence[type[Incoming]]) -> msgspec.msgpack.Decoder[Incoming]:
    """Reads any of these messages, and refuses all else."""
    return msgspec.msgpack.Decoder(functools.reduce(operator.or_, messages))


class Gate:
    """Looks at everything that one page sends.

    Args:
        read: of `decoder`.
        widget: the widget of this page with a uuid; None where there is none (any more).
        too_large: called with an upload that was refused by its size.
    """

    def __init__(
        self,
        read: msgspec.msgpack.Decoder[Incoming],
        widget: Callable[[str], Any],
        too_large: Callable[[FileTransferStartUpload], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._read, self._widget, self._too_large = read, widget, too_large
        self._messages = Bucket(MESSAGES_PER_SECOND, MESSAGES_AT_ONCE, clock)
        self._bytes = Bucket(BYTES_PER_SECOND, BYTES_AT_ONCE, clock)
        self._transfers: dict[str, Transfer] = {}

    def passes(self, raw: bytes | str) -> bool:
        """Whether viser may have this message; False where it is to be dropped.

        Raises:
            PageRefused: the page is to be closed.
        """
        if not self._messages.take(1):
            raise PageRefused("too many messages")
        if not self._bytes.take(len(raw)):
            raise PageRefused("too many bytes")
        if isinstance(raw, str):
            raise PageRefused("a message that is none")
        try:
            message = self._read.decode(raw)
        except (msgspec.DecodeError, RecursionError) as error:
            raise PageRefused("a message that is none") from error
        match message:
            case GuiUpdateMessage():
                widget = self._widget(message.uuid)
                return widget is not None and fits(widget, message.updates.value)
            case FileTransferStartUpload():
                return self._begins(message)
            case FileTransferPart():
                return self._goes_on(message)
            case _:
                return is_finite(msgspec.structs.astuple(message))

    def _begins(self, upload: FileTransferStartUpload) -> bool:
        if not isinstance(self._widget(upload.source_component_uuid), GuiUploadButtonHandle):
            return False
        if upload.size_bytes > MAX_UPLOAD_BYTES:
            self._too_large(upload)
            return False  # its parts, which come all the same, belong to no transfer
        known = upload.transfer_uuid in self._transfers
        if known or len(self._transfers) >= MAX_TRANSFERS:
            raise PageRefused("too many uploads at once")
        if not bool(upload.size_bytes) <= upload.part_count <= upload.size_bytes:
            raise PageRefused("an upload of another size than it said")
        if upload.part_count:
            self._transfers[upload.transfer_uuid] = Transfer(upload.part_count, upload.size_bytes)
        return True

    def _goes_on(self, part: FileTransferPart) -> bool:
        transfer = self._transfers.get(part.transfer_uuid)
        if transfer is None:
            return False
        transfer.add(part.part_index, len(part.content))
        if transfer.complete:
            del self._transfers[part.transfer_uuid]
        return True


@dataclass
class Transfer:
    """An upload on its way: what it said it would be, and what has come."""

    parts: int
    size: int
    came: set[int] = field(default_factory=set)
    bytes_left: int = field(init=False)

    def __post_init__(self) -> None:
        self.bytes_left = self.size

    @property
    def complete(self) -> bool:
        return len(self.came) == self.parts

    def add(self, index: int, size: int) -> None:
        """Count one part.

        Raises:
            PageRefused: it is not what was announced.
        """
        self.bytes_left -= size
        if index in self.came or index >= self.parts or self.bytes_left < 0:
            raise PageRefused("an upload of another size than it said")
        self.came.add(index)
        if self.complete and self.bytes_left:
            raise PageRefused("an upload of another size than it said")


class Bucket:
    """Lets `rate` a second pass, and up to `most` at once."""

    def __init__(self, rate: float, most: float, clock: Callable[[], float]) -> None:
        self._rate, self._most, self._clock = rate, most, clock
        self._left, self._then = most, clock()

    def take(self, amount: float) -> bool:
        """Whether that much may pass now; what may not is not counted."""
        now = self._clock()
        self._left = min(self._left + (now - self._then) * self._rate, self._most)
        self._then = now
        if amount > self._left:
            return False
        self._left -= amount
        return True


def fits(widget: Any, value: object) -> bool:
    """Whether a value is of the kind that a widget has, and one of those that it offers.

    One that is not is no fault of the page: a list may have changed while it was on its way.
    """
    options = getattr(widget, "options", None)
    if options is not None:
        return value in options
    match widget.value:
        case bool():
            return isinstance(value, bool)
        case str():
            return isinstance(value, str)
        case int() | float():
            return _is_number(value)
        case tuple() as shown:
            return (
                isinstance(value, list) and len(value) == len(shown) and all(map(_is_number, value))
            )
    return False


def is_finite(value: object) -> bool:
    """Whether no number in a message is nan or infinite."""
    if isinstance(value, tuple):
        return all(map(is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and is_finite(value)
