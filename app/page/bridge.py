"""To the browser's part and back: the one Python file that knows viser's inner names (1.1.1).

`static/web/bridge.js` is the one file on the browser's side. On each connection the script is
installed (again: it takes no notice where it is there already), the page says Hello, and from then
on gets what is shown. viser keeps the newest message of a key while an older one was not sent yet.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import viser
from viser._messages import Message, RunJavascriptMessage

from ...core.errors import InputError
from .asked import Allowance, AnyAsked, Broken, Hello, parse
from .script import script
from .shown import PlaybackShown, Shown, wire

log = logging.getLogger(__name__)


@dataclass
class RnnpbShown(Message, include_in_scene_serialization=False):
    """Down: one `Shown`."""

    kind: str
    body: dict[str, Any]
    key: str

    def redundancy_key(self) -> str:
        return f"RnnpbShown {self.key}"


@dataclass
class RnnpbAsked(Message, include_in_scene_serialization=False):
    """Up: one of `asked.py` as JSON; whatever else the page put into it is dropped unread."""

    payload: object = None

    def redundancy_key(self) -> str:
        return "RnnpbAsked"

    @classmethod
    def _from_serializable_dict(cls, mapping: dict[str, Any]) -> dict[str, Any]:
        return {"payload": mapping.get("payload")}


# viser remembers the types of messages that it has seen; ours are among them from here on.
Message._subclass_from_type_string.cache_clear()


def board_html(board: Literal["map", "landscape"], slots: int = 1) -> str:
    """The places for a board: the one `add_html` of a tab in a panel that is docked left.

    Args:
        slots: 2 for the boards of two models side by side.
    """
    names = [board, f"{board}-2"][:slots]
    places = (f'<div id="rnnpb-{name}" style="flex:1;min-width:0"></div>' for name in names)
    return f'<div style="display:flex;gap:6px">{"".join(places)}</div>'


def place_html(name: str, height: int) -> str:
    """A place in a panel for one of the browser's own parts, so many pixels high."""
    return f'<div id="rnnpb-{name}" style="height:{height}px;margin:0 0.75em"></div>'


def reload_in(client: viser.ClientHandle, seconds: float) -> None:
    """Have a page that has no session load anew after a while."""
    again = f"setTimeout(() => location.reload(), {1000 * seconds:.0f});"
    client._websock_connection.queue_message(RunJavascriptMessage(again))


class Bridge:
    """One page.

    Args:
        client: a client that has just connected.
        on_asked: called with all that the page asks, on viser's event loop: it may only hand it on.

    Raises:
        InputError: viser is not the version that this was made for.
    """

    def __init__(self, client: viser.ClientHandle, on_asked: Callable[[AnyAsked], None]) -> None:
        self._on_asked = on_asked
        self._allowance = Allowance()
        self._lock = threading.Lock()
        self._kept: dict[str, Shown] = {}  # until the page has said hello
        self._greeted = False
        self.refused = 0  # messages of the page that were none; who sends many may be closed
        try:
            self._connection = client._websock_connection
            self._connection.register_handler(RnnpbAsked, self._hear)
            self._connection.queue_message(RunJavascriptMessage(script()))
        except (AttributeError, TypeError) as error:
            line = f"the boards need viser 1.1.1, this is {viser.__version__}: {error}"
            log.error(line)
            raise InputError(line) from error

    def show(self, shown: Shown) -> None:
        """Show this on the page, in place of what is of its kind; any thread may call."""
        with self._lock:
            if not self._greeted:
                self._kept[shown.key] = shown
                return
            self._send(shown)

    def _send(self, shown: Shown) -> None:
        self._connection.queue_message(RnnpbShown(type(shown).__name__, wire(shown), shown.key))

    def _hear(self, _client_id: int, message: RnnpbAsked) -> None:
        try:
            if not self._allowance.spend():
                raise InputError("more messages than a hand can make")
            asked = parse(message.payload)
        except InputError as error:
            self.refused += 1
            if self.refused == 1:  # one line a page, whatever it sends
                log.warning("a page sent a message that was refused: %s", error)
            return
        if isinstance(asked, Broken):
            log.error("a page cannot show the boards: %s", asked.reason)
        if isinstance(asked, Hello):
            with self._lock:
                self._greeted = True
                if asked.playback is not None:  # it plays already, and tells how
                    self._kept.pop(PlaybackShown.__name__, None)
                for shown in self._kept.values():
                    self._send(shown)
                self._kept.clear()
        self._on_asked(asked)
