"""Requests as a browser, a tool or somebody at the door sends them; every header can be set."""

from __future__ import annotations

import base64
import http.client
import os
from dataclasses import dataclass

import viser

from rnnpb_explorer.app.page.server import App

TIMEOUT = 30.0
CAME_IN = 101  # Switching Protocols: the websocket is open


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]  # by name in lower case
    text: str

    @property
    def policy(self) -> dict[str, str]:
        """The content security policy: sources by directive."""
        rules = self.headers["content-security-policy"].split("; ")
        return {rule.partition(" ")[0]: rule.partition(" ")[2] for rule in rules}

    @property
    def cookie(self) -> str:
        """What a browser sends back from then on."""
        return self.headers["set-cookie"].partition(";")[0]


def port_of(app: App) -> int:
    return int(app.url.rpartition(":")[2])


def ask(app: App, path: str = "/", *, host: str | None = None, **headers: str) -> Answer:
    """Ask for a page.

    Args:
        host: the name in the address; by default the server's own.
    """
    connection = http.client.HTTPConnection("127.0.0.1", port_of(app), timeout=TIMEOUT)
    try:
        connection.putrequest("GET", path, skip_host=True, skip_accept_encoding=True)
        connection.putheader("Host", app.url.removeprefix("http://") if host is None else host)
        for name, value in headers.items():
            connection.putheader(name.replace("_", "-"), value)
        connection.endheaders()
        response = connection.getresponse()
        known = {name.lower(): value for name, value in response.getheaders()}
        body = b"" if response.status == CAME_IN else response.read()
        return Answer(response.status, known, body.decode())
    finally:
        connection.close()


def knock(app: App, path: str = "/", *, host: str | None = None, **headers: str) -> Answer:
    """Ask for a websocket."""
    return ask(
        app,
        path,
        host=host,
        Upgrade="websocket",
        Connection="Upgrade",
        Sec_WebSocket_Version="13",
        Sec_WebSocket_Key=base64.b64encode(os.urandom(16)).decode(),
        Sec_WebSocket_Protocol=f"viser-v{viser.__version__}",
        **headers,
    )
