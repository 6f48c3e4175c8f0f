"""Who may come in: the hosts, origins, tokens and frames that the server answers to.

A page of any other site, open in the same browser, can send requests to a local server and open
websockets to it. What it cannot do is choose what the browser says about it: `Host` (the name in
the address) and `Origin` (the site that asks). Both are compared exactly, never by prefix.

Nothing here knows viser or a socket: `Door.answer` is a function of a request. `guard` puts the
door in front of the server.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import re
import secrets
import socket
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import parse_qsl, quote, urlencode, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from ...core.errors import InputError

LOOPBACK_NAMES = ("127.0.0.1", "localhost", "[::1]")
WILDCARDS = ("", "0.0.0.0", "::")  # to serve on: every address of this machine
DEFAULT_PORTS = {"http": 80, "https": 443}
MAX_TOKEN = 200  # characters
TOKEN = "token"
# The page would take its messages from another server, or play a file of one, and both can run
# code in our origin.
DANGEROUS = frozenset({"websocket", "playbackPath"})
WRONG_NAME = "403: this explorer is not served under that name (see --allow-origin).\n"
WRONG_ORIGIN = "403: pages of other sites cannot use this explorer (see --allow-origin).\n"
NO_TOKEN = "403: this explorer needs its token.\n"
TOKEN_PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>The explorer needs its token</title>
<h1>The explorer needs its token</h1>
<p>{}</p>
<form method="get" action="/">
<label>Token <input name="token" type="password" autocomplete="off" autofocus required></label>
<button>Open</button>
</form>
</html>
"""
MISSING = (
    "Open the whole link that you were given, or type the token. If you did, this browser keeps "
    "no cookie of this page: allow it, or open the page in a window of its own."
)
WRONG = "That token is not the right one. Ask who started the explorer, or try again."


@dataclass(frozen=True)
class Door:
    """The rules of one server; `make_door` checks what a person said and makes one.

    Args:
        host: what the server is bound to, as a person said it.
        token: what has to be known; None where nobody is asked.
        origins: where else the page is served from: the public names of proxies.
        frames: sites that may embed the page.
        scripts: hashes of the page's own scripts, as a content security policy has them.
    """

    host: str
    token: str | None = None
    origins: tuple[str, ...] = ()
    frames: tuple[str, ...] = ()
    scripts: tuple[str, ...] = ()

    # --- what is asked ---
    def answer(self, request: Request, address: tuple[str, int]) -> Response | None:
        """What to answer instead of the server; None where the request may pass.

        Args:
            address: the address and port of ours that the request came to.
        """
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or not self.serves(hosts[0], address):
            return _text(WRONG_NAME)
        if len(origins) > 1 or not all(self.trusts(one, hosts[0]) for one in origins):
            return _text(WRONG_ORIGIN)
        websocket = [value.lower() for value in request.headers.get_all("Upgrade")] == ["websocket"]
        path, _, query = request.path.partition("?")
        asked = parse_qsl(query, keep_blank_values=True)
        given = next((value for name, value in asked if name == TOKEN), None)
        knows = self.token is not None and given is not None and _same(given, self.token)
        if self.token is not None and not knows and not self._remembers(request, address[1]):
            return _text(NO_TOKEN) if websocket else self._token_page(given)
        kept = [pair for pair in asked if pair[0] != TOKEN and pair[0] not in DANGEROUS]
        if websocket or len(kept) == len(asked):
            return None
        # One slash in front, so that no path can be read as the name of another server.
        location = "/" + path.lstrip("/\\") + ("?" + urlencode(kept) if kept else "")
        response = _redirect(location)
        if knows:
            response.headers["Set-Cookie"] = self._cookie(hosts[0], address[1])
        return response

    def serves(self, host: str, address: tuple[str, int]) -> bool:
        """Whether a `Host` header names this server."""
        return host.lower() in self._own(address) | {
            name for origin in self.origins for name in _authorities(origin)
        }

    def trusts(self, origin: str, host: str) -> bool:
        """Whether an `Origin` header names a page that came from here, or from a known proxy.

        Args:
            host: the `Host` of the same request, which is ours. A page of another of our names is
                another page: somebody else may serve `localhost` on this port over IPv6.
        """
        origin, host = origin.lower(), host.lower()
        return origin in (f"http://{host}", f"http://{host.removesuffix(':80')}") or (
            origin in self.origins
        )

    def _own(self, address: tuple[str, int]) -> set[str]:
        ip, port = address
        wildcard = self.host in WILDCARDS
        names = {url_host(self.host.lower())} if not wildcard else {url_host(_plain(ip))}
        if wildcard or is_loopback(self.host):
            names |= set(LOOPBACK_NAMES)
        return {f"{name}:{port}" for name in names} | (names if port == 80 else set())

    # --- the token ---
    def link(self, url: str) -> str:
        """The address to give to people: with the token, where there is one."""
        return url if self.token is None else f"{url}/?{TOKEN}={quote(self.token, safe='')}"

    def _remembers(self, request: Request, port: int) -> bool:
        assert self.token is not None
        pairs = (
            pair.strip().partition("=")
            for header in request.headers.get_all("Cookie")
            for pair in header.split(";")
        )
        right = _ticket(self.token, port)
        return any(name == _cookie_name(port) and _same(value, right) for name, _, value in pairs)

    def _cookie(self, host: str, port: int) -> str:
        assert self.token is not None
        public = {
            name for origin in self.origins if _secure(origin) for name in _authorities(origin)
        }
        flags = "Path=/; HttpOnly"
        if host.lower() in public and self.frames:
            # Only so does a browser send it from a frame of another site.
            flags += "; SameSite=None; Secure; Partitioned"
        elif host.lower() in public:
            flags += "; SameSite=Lax; Secure"
        else:  # Lax, not Strict: a link to here on another site has to work
            flags += "; SameSite=Lax"
        return f"{_cookie_name(port)}={_ticket(self.token, port)}; {flags}"

    def _token_page(self, given: str | None) -> Response:
        response = _answer(
            HTTPStatus.FORBIDDEN, TOKEN_PAGE.format(MISSING if given is None else WRONG), "html"
        )
        response.headers["Content-Security-Policy"] = _policy(
            {
                "default-src": "'none'",
                "form-action": "'self'",
                "base-uri": "'none'",
                "frame-ancestors": self._ancestors(),
            }
        )
        return response

    # --- what goes out with everything ---
    def dress(self, request: Request, response: Response) -> None:
        """Add what the browser has to know about this page to any answer."""
        headers = response.headers
        headers["X-Content-Type-Options"] = "nosniff"
        headers["Referrer-Policy"] = "no-referrer"
        headers["Cross-Origin-Resource-Policy"] = "same-origin"
        if not self.frames:
            headers["X-Frame-Options"] = "DENY"  # for browsers that know no frame-ancestors
        if "Content-Security-Policy" not in headers:
            headers["Content-Security-Policy"] = self.policy(request)

    def policy(self, request: Request) -> str:
        """The page may use what it brings along, and connect to us alone."""
        # Where 'self' does not cover websockets (older browsers), the address itself does.
        sockets = [f"ws://{request.headers.get_all('Host')[0].lower()}"]
        sockets += [origin.replace("http", "ws", 1) for origin in self.origins]
        return _policy(
            {
                "default-src": "'none'",
                # unsafe-eval: WebAssembly (viser unpacks its messages with it), and new Function
                # (so viser runs a script that the server sends: our own part in the page).
                "script-src": " ".join((*self.scripts, "'unsafe-eval'")),
                "worker-src": "blob:",
                "connect-src": " ".join(["'self'", "blob:", "data:", *sockets]),
                "style-src": "'unsafe-inline'",
                "img-src": "'self' blob: data:",
                "font-src": "data:",
                "object-src": "'none'",
                "base-uri": "'none'",
                "form-action": "'none'",
                "frame-ancestors": self._ancestors(),
            }
        )

    def _ancestors(self) -> str:
        return " ".join(self.frames) or "'none'"


def make_door(
    host: str,
    *,
    token: str | None = None,
    no_token: bool = False,
    allow_origins: Iterable[str] = (),
    allow_frames: Iterable[str] = (),
    scripts: tuple[str, ...] = (),
) -> Door:
    """The door that a person asked for.

    Raises:
        InputError: a token or an origin that is none, or a server that everybody could use without
            anybody having said so.
    """
    if token is not None and no_token:
        raise InputError("--token and --no-token exclude each other; give one of them")
    if token is not None and (
        not token.isprintable() or any(map(str.isspace, token)) or not 0 < len(token) <= MAX_TOKEN
    ):
        raise InputError(f"--token takes from 1 to {MAX_TOKEN} characters without any spaces")
    if token is None and not no_token and not is_loopback(host):
        raise InputError(
            f"--host {host} lets everybody in who reaches this machine: give a token, for example "
            f"--token {secrets.token_urlsafe(12)}, or --no-token where that is meant"
        )
    return Door(
        host=host,
        token=token,
        origins=tuple(_origin("--allow-origin", text) for text in allow_origins),
        frames=tuple(_origin("--allow-frame", text) for text in allow_frames),
        scripts=scripts,
    )


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches a server on that host."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def url_host(host: str) -> str:
    """A host as it stands in a URL; one that works here for those that mean every address."""
    return "127.0.0.1" if host in WILDCARDS else f"[{host}]" if ":" in host else host


def address_for_others() -> str | None:
    """This machine's address on its network; nothing is sent to find it. None where it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(
                ("192.0.2.1", 9)
            )  # reserved for examples: it stands for any other machine
        except OSError:
            return None
        address: str = probe.getsockname()[0]
    return address


def _origin(flag: str, text: str) -> str:
    """An origin as browsers write it: no default port, no slash at the end."""
    wrong = f"{flag} {text[:80]!r} is no origin; it takes https://name or http://name:port"
    try:
        parts = urlsplit(text.removesuffix("/"))
        port = parts.port
        name = (parts.hostname or "").encode("idna").decode("ascii").lower()
    except ValueError as error:  # UnicodeError is one
        raise InputError(wrong) from error
    more = parts.path or parts.query or parts.fragment or parts.username is not None
    if parts.scheme not in DEFAULT_PORTS or more or not re.fullmatch(r"[a-z0-9._:-]+", name):
        raise InputError(wrong)
    default = port in (None, DEFAULT_PORTS[parts.scheme])
    return f"{parts.scheme}://{url_host(name)}" + ("" if default else f":{port}")


def _authorities(origin: str) -> tuple[str, ...]:
    """What `Host` may say where a page comes from that origin."""
    scheme, _, authority = origin.partition("://")
    has_port = authority.rpartition("]")[2].count(":") > 0
    return (authority,) if has_port else (authority, f"{authority}:{DEFAULT_PORTS[scheme]}")


def _secure(origin: str) -> bool:
    return origin.startswith("https://")


def _plain(ip: str) -> str:
    """An address without a zone; one of IPv4 as such."""
    address = ipaddress.ip_address(ip.partition("%")[0])
    mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return str(mapped or address)


def _cookie_name(port: int) -> str:
    """Cookies know no ports, and two servers on one host must not take each other's."""
    return f"rnnpb-explorer-{port}"


def _ticket(token: str, port: int) -> str:
    """What the browser keeps instead of the token; the same after a restart with that token."""
    return hmac.new(token.encode(), f"rnnpb-explorer {port}".encode(), hashlib.sha256).hexdigest()


def _same(given: str, right: str) -> bool:
    """In a time that says nothing about where they differ."""
    return hmac.compare_digest(given.encode("utf-8", "surrogatepass"), right.encode())


def _policy(rules: Mapping[str, str]) -> str:
    return "; ".join(f"{name} {value}" for name, value in rules.items())


def _text(line: str) -> Response:
    response = _answer(HTTPStatus.FORBIDDEN, line, "plain")
    response.headers["Content-Security-Policy"] = "default-src 'none'; frame-ancestors 'none'"
    return response


def _redirect(location: str) -> Response:
    response = _answer(HTTPStatus.FOUND, "", "plain")
    response.headers["Location"] = location
    return response


def _answer(status: HTTPStatus, text: str, kind: str) -> Response:
    body = text.encode()
    headers = Headers()
    headers["Content-Type"] = f"text/{kind}; charset=utf-8"
    headers["Content-Length"] = str(len(body))
    headers["Cache-Control"] = "no-store"
    headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, body)
