"""viser's messages as they travel to a page, taken apart; for clients without a browser."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec.msgpack
import numpy as np
import zstandard

HEAD = 16  # bytes: two lengths
ALIGNMENT = 8


def messages(raw: bytes) -> Iterator[dict[str, Any]]:
    """The messages of one websocket frame, numpy arrays as such.

    A frame is the lengths of the packed messages, them, and the arrays' bytes one after the other.
    """
    packed = int.from_bytes(raw[8:HEAD], "little")
    content = msgspec.msgpack.decode(
        zstandard.ZstdDecompressor().decompress(raw[HEAD : HEAD + packed])
    )
    buffers, at = [], HEAD + packed
    for length in content.get("binaryBufferLengths", ()):
        at += -at % ALIGNMENT
        buffers.append(raw[at : at + length])
        at += length
    for message in content["messages"]:
        yield _with_arrays(message, buffers)


def shown_array(value: dict[str, Any]) -> np.ndarray:
    """An array of one of our own messages, with its shape."""
    array: np.ndarray = value["data"].reshape(value["shape"])
    return array


def _with_arrays(value: Any, buffers: list[bytes]) -> Any:
    if isinstance(value, dict):
        if value.keys() == {"__binary_index", "dtype"}:
            return np.frombuffer(buffers[value["__binary_index"]], value["dtype"])
        return {name: _with_arrays(one, buffers) for name, one in value.items()}
    if isinstance(value, list):
        return [_with_arrays(one, buffers) for one in value]
    return value
