"""Puts the door and the gate into viser, which has no place for either.

viser starts its websocket server in one call and serves its page from the same port. While a
`ViserServer` is made, that call goes through `Guard`: requests meet the door before viser's files
and sessions do, and every message meets the gate before viser's handlers do.

This module knows names that viser promises to nobody; no other one needs to.
"""

from __future__ import annotations

import asyncio
import base64
import functools
import hashlib
import logging
import re
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import viser
import websockets.asyncio.server
import zstandard
from viser import _messages as wire
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from .door import Door
from .gate import (
    MAX_MESSAGE_BYTES,
    PAGE_MESSAGES,
    FileTransferStartUpload,
    Gate,
    Incoming,
    PageRefused,
    decoder,
)

CLOSE_SECONDS = 2.0  # for a page to answer that it is closed
MAX_TOLD = 20  # refusals that are worth a line; whoever knocks must not fill the log
PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
# The page is one script that unpacks another: CSS and JavaScript, one after the other, as one zstd
# frame in base 88.
_LOADER = re.compile(
    rb'<script data-p="([^"]*)" data-ss="(\d+)" data-cs="(\d+)">(.*?)</script>', re.DOTALL
)
_ALPHABET = bytes(c for c in range(0x21, 0x7F) if c not in b"\"&<>'`")
_CHANGED = "viser is not as it was in 1.1.1, for which this is written: {}"
_serve_is_ours = threading.Lock()
log = logging.getLogger(__name__)


class Guard:
    """The door and the gates of one server.

    Args:
        messages: what a page may send.
    """

    def __init__(self, door: Door, messages: Sequence[type[Incoming]] = PAGE_MESSAGES) -> None:
        self.door = door
        self._read = decoder(messages)
        self._viser: viser.ViserServer | None = None
        self._told: set[str] = set()
        self.too_large: Callable[[int, FileTransferStartUpload], None] = lambda client, upload: None

    def start(self, **options: Any) -> viser.ViserServer:
        """Make viser's server, with nothing open beside the door."""
        with self._serving():
            self._viser = viser.ViserServer(**options)
        return self._viser

    @contextmanager
    def _serving(self) -> Iterator[None]:
        original = websockets.asyncio.server.serve
        asked = threading.Event()

        def serve(handler: Any, host: str, port: int, **options: Any) -> Any:
            asked.set()
            return original(handler, host, port, **{**options, **self._options(options)})

        with _serve_is_ours:
            websockets.asyncio.server.serve = serve  # type: ignore[assignment, misc]
            try:
                yield
            finally:
                websockets.asyncio.server.serve = original  # type: ignore[misc]
        if not asked.is_set():
            raise RuntimeError(_CHANGED.format("its server was started in another way"))

    def _options(self, visers: dict[str, Any]) -> dict[str, Any]:
        return {
            "process_request": functools.partial(self._answer, visers["process_request"]),
            "process_response": self._dress,
            "create_connection": functools.partial(GuardedConnection, guard=self),
            "max_size": MAX_MESSAGE_BYTES,
            "close_timeout": CLOSE_SECONDS,
            "server_header": None,
            "logger": _logger(),
        }

    # --- requests ---
    def _answer(
        self, visers: Callable[..., Response | None], connection: ServerConnection, request: Request
    ) -> Response | None:
        response = self.door.answer(request, connection.local_address[:2])
        if response is None:
            try:
                return visers(connection, request)
            except (LookupError, OSError, ValueError):  # a header twice, a path that is none
                return connection.respond(400, "400: no such request.\n")
        if response.status_code == 403:
            self._tell(request, response)
        return response

    def _dress(self, connection: ServerConnection, request: Request, response: Response) -> None:
        self.door.dress(request, response)

    def _tell(self, request: Request, response: Response) -> None:
        """One line for each that is refused, so that a proxy's owner sees what is missing."""
        who = [*request.headers.get_all("Origin"), *request.headers.get_all("Host")]
        line = f"refused a request ({' at '.join(who)[:100]!r}): {_first_line(response)}"
        if line not in self._told and len(self._told) < MAX_TOLD:
            self._told.add(line)
            log.warning("%s", line)

    # --- messages ---
    def gate(self, connection: ServerConnection) -> Gate:
        """The gate of one page."""
        return Gate(
            self._read,
            functools.partial(self._widget, connection),
            functools.partial(self._refuse_upload, connection),
        )

    def _client(self, connection: ServerConnection) -> viser.ClientHandle | None:
        if self._viser is None:
            return None
        server = self._viser._websock_server
        for number, live in tuple(server._live_connections.items()):
            if live is connection:
                return self._viser._connected_clients.get(number)
        return None

    def _widget(self, connection: ServerConnection, uuid: str) -> Any:
        client = self._client(connection)
        return None if client is None else client.gui._gui_input_handle_from_uuid.get(uuid)

    def _refuse_upload(self, connection: ServerConnection, upload: FileTransferStartUpload) -> None:
        client = self._client(connection)
        if client is None:
            return
        # The page shows an upload as going on, and its button as busy, until all of it has come.
        queue = client._websock_connection.queue_message
        source, transfer, size = (
            upload.source_component_uuid,
            upload.transfer_uuid,
            upload.size_bytes,
        )
        queue(wire.FileTransferPartAck(source, transfer, size, size))
        queue(wire.RemoveNotificationMessage(f"upload-{transfer}"))
        self.too_large(client.client_id, upload)


class GuardedConnection(ServerConnection):
    """A page's connection, of which viser gets to see what the gate lets pass."""

    def __init__(self, *arguments: Any, guard: Guard, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._gate = guard.gate(self)

    async def recv(self, decode: bool | None = None) -> Any:
        while True:
            try:
                raw = await super().recv(decode)
                if self._gate.passes(raw):
                    return raw
            except PageRefused as refused:
                raise self._end(str(refused)) from refused
            except ConnectionClosed as closed:
                if closed.sent is not None and closed.sent.code == CloseCode.MESSAGE_TOO_BIG:
                    self._note("a message of more than 1 MB")
                raise

    def _end(self, reason: str) -> ConnectionClosed:
        """Close, without waiting: the session ends now, however slowly the other side answers."""
        self._note(reason)
        self._closing = asyncio.ensure_future(self.close(CloseCode.POLICY_VIOLATION, reason))
        return ConnectionClosed(None, None)

    def _note(self, reason: str) -> None:
        log.warning("a page at %s was closed: %s", self.remote_address[0], reason)


def page_scripts() -> tuple[str, ...]:
    """The scripts of viser's page, as a content security policy names what may run.

    Without them the policy would have to allow every script that gets into the page.
    """
    loader = _LOADER.search(PAGE.read_bytes())
    if loader is None:
        raise RuntimeError(_CHANGED.format("its page is packed in another way"))
    styles, code = int(loader[2]), int(loader[3])
    unpacked = zstandard.ZstdDecompressor().decompress(_from_base_88(loader[1]))
    return tuple(map(_hash, (loader[4], unpacked[styles : styles + code])))


def _from_base_88(text: bytes) -> bytes:
    """Each 5 characters are 4 bytes, the first one the highest; r + 1 at the end are r."""
    digits = np.zeros(128, np.int64)
    digits[np.frombuffer(_ALPHABET, np.uint8)] = np.arange(88)
    whole = len(text) // 5 * 5
    groups = digits[np.frombuffer(text[:whole], np.uint8)].reshape(-1, 5)
    out = (groups @ 88 ** np.arange(4, -1, -1)).astype(">u4").tobytes()
    rest = 0
    for character in text[whole:]:
        rest = rest * 88 + int(digits[character])
    return out + rest.to_bytes(max(len(text) - whole - 1, 0), "big")


def _hash(script: bytes) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"


def _first_line(response: Response) -> str:
    kind = response.headers["Content-Type"]
    return response.body.decode().strip() if kind.startswith("text/plain") else "no token, or wrong"


def _logger() -> logging.Logger:
    """Of the connections: what is no HTTP at all, or breaks off in the middle, is no news."""
    logger = log.getChild("connections")

    def is_news(record: logging.LogRecord) -> bool:
        error = record.exc_info[1] if record.exc_info else None
        return not isinstance(error, WebSocketException | EOFError | ConnectionError)

    if not logger.filters:
        logger.addFilter(is_news)
    return logger
