"""The state code: a document written down as one line of text.

It holds numbers and names only. A code from anywhere is checked like any other input: types, sizes
and bounds are those of the document, and what does not fit the loaded models is refused.
"""

from __future__ import annotations

import base64
import zlib

import msgspec

from ...core.errors import InputError
from .document import Document
from .facts import Facts
from .opening import check_fits

PREFIX = "rnnpb2-"
OLD_PREFIX = "rnnpb1-"
MAX_LINE = 64_000  # characters of a code that is shown as a line; a longer one becomes a file
MAX_CODE_LENGTH = 12_000_000
MAX_BYTES = 12_000_000  # unpacked: no zip bomb
_DECODER = msgspec.msgpack.Decoder(Document)


def encode(document: Document) -> str:
    """The state code of a document."""
    packed = zlib.compress(msgspec.msgpack.encode(document), 9)
    return PREFIX + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def decode(facts: Facts, code: str) -> Document:
    """The document of a code, for these models.

    Raises:
        InputError: not a state code, or one of other models.
    """
    document = unpacked(code)
    check_fits(facts, document)
    return document


def unpacked(code: str) -> Document:
    """The document of a code, whatever models it is of.

    Raises:
        InputError: not a state code.
    """
    code = code.strip()
    if code.startswith(OLD_PREFIX):
        raise InputError("the state code is of an older version, which this one cannot read")
    if not code.startswith(PREFIX):
        raise InputError(f"not a state code; one begins with {PREFIX}")
    if len(code) > MAX_CODE_LENGTH:
        raise InputError(f"the state code is longer than {MAX_CODE_LENGTH} characters")
    packed = code.removeprefix(PREFIX)
    try:
        raw = base64.b64decode(packed + "=" * (-len(packed) % 4), b"-_", validate=True)
        unpacker = zlib.decompressobj()
        content = unpacker.decompress(raw, MAX_BYTES)
        if not unpacker.eof or unpacker.unused_data:
            raise ValueError("cut off, or larger than a document can be")
        return _DECODER.decode(content)
    except (zlib.error, msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise InputError("the state code is damaged") from error
