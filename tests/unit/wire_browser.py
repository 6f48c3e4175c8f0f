"""A browser reduced to its wire: it speaks viser's protocol and draws nothing.

It says where its camera is, says hello when the page's script comes, keeps what it is sent, and
does what a person does: moves sliders, presses buttons, moves pucks, uploads files. The page itself
is tested in a real browser, in tests/browser.
"""

from __future__ import annotations

import contextlib
import json
import socket
import threading
import uuid
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import msgspec.msgpack
import viser
from viser import _messages as wire
from viser_wire import messages, shown_array
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

TIMEOUT = 30.0  # seconds until a test that hangs has failed; nothing waits for it otherwise
Point = tuple[float, float, float]


class WireBrowser:
    """One window on the app at `url`.

    Args:
        tab: what the tab keeps, over reloads by who passes it again.
        silent: never say hello.
    """

    def __init__(
        self,
        url: str,
        tab: dict[str, str] | None = None,
        *,
        size: tuple[int, int] = (1280, 720),
        silent: bool = False,
        headers: Mapping[str, str] | None = None,
        follow: str | None = None,
    ) -> None:
        self._follow = follow  # the code in the page's address
        self.tab = {} if tab is None else tab
        self.shown: dict[str, dict[str, Any]] = {}  # the newest of each kind: MapShown, ...
        self.script = ""  # the last that the app had run
        self.camera: Point | None = None  # where the app has put it
        self.moves = self.messages = 0  # sent, received
        self.widgets: dict[str, dict[str, Any]] = {}  # by uuid: label, value, options, ...
        self.nodes: dict[str, dict[str, Any]] = {}  # of the scene, by name
        self.commands: dict[str, str] = {}  # uuid by label
        self.notices: list[str] = []
        self.files: dict[str, bytes] = {}  # that the app had the browser save, by name
        self._silent, self._size = silent, size
        self._downloads: dict[str, str] = {}  # file names by transfer
        self._changed = threading.Condition()
        self._awake = threading.Event()
        self._awake.set()
        self._socket = connect(
            url.replace("http", "ws", 1),
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            compression=None,
            max_size=None,
            additional_headers=headers,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.look((4.0, 0.0, 1.0), size)

    # --- the wire ---
    def _read(self) -> None:
        try:
            for raw in self._socket:
                assert isinstance(raw, bytes)
                self._awake.wait()
                for message in messages(raw):
                    self._take(message)
        except ConnectionClosed:
            return

    def _take(self, message: dict[str, Any]) -> None:
        kind = message["type"]
        self.messages += 1
        if kind == "RunJavascriptMessage":
            self.script = message["source"]
            if not self._silent:
                self.hello()
        with self._changed:
            if kind == "NotificationShowMessage":
                self.notices.append(message["props"]["body"])
            elif kind == "RnnpbShown":
                self._show(message["kind"], message["body"])
            elif kind == "FileTransferStartDownload":
                self._downloads[message["transfer_uuid"]] = message["filename"]
            elif kind == "FileTransferPart":
                name = self._downloads[message["transfer_uuid"]]
                self.files[name] = self.files.get(name, b"") + message["content"]
            elif kind == "RegisterCommandMessage":
                self.commands[message["props"]["label"]] = message["uuid"]
            elif kind in ("GuiUpdateMessage", "SceneNodeUpdateMessage"):
                known = self.widgets if kind.startswith("Gui") else self.nodes
                known.setdefault(message.get("uuid") or message["name"], {}).update(
                    message["updates"]
                )
            elif kind == "GuiRemoveMessage":
                self.widgets.pop(message["uuid"], None)
            elif kind == "SetCameraPositionMessage":
                self.camera = tuple(message["position"])
            elif kind == "SetPositionMessage":
                self.nodes.setdefault(message["name"], {})["position"] = message["position"]
            elif kind == "SetOrientationMessage":
                self.nodes.setdefault(message["name"], {})["wxyz"] = message["wxyz"]
            elif "uuid" in message and "props" in message:
                props = message["props"]
                self.widgets[message["uuid"]] = {**props, "value": message.get("value")}
            elif "name" in message and "props" in message:
                node = self.nodes.setdefault(message["name"], {})
                node.update(message["props"], owner=message.get("owner", ""))
            self._changed.notify_all()

    def _show(self, kind: str, body: dict[str, Any]) -> None:
        arrays = {
            name: shown_array(value) if isinstance(value, dict) and "shape" in value else value
            for name, value in body.items()
        }
        number = body["robot"] if kind == "MotionShown" else body.get("slot")
        self.shown[f"{kind} {number}" if kind == "MotionShown" or number else kind] = arrays
        if kind == "DocumentShown":
            self.tab["document"] = body["text"]
        if kind == "PresenceShown":
            self.tab["secret"] = body["secret"] or ""
            self.tab["free"] = "1" if body["free"] else ""

    def say(self, raw: bytes | str | Mapping[str, object]) -> None:
        """Send whatever no page sends; a mapping is packed as a message is."""
        with contextlib.suppress(ConnectionClosed):  # the server may have had enough
            self._socket.send(msgspec.msgpack.encode(raw) if isinstance(raw, Mapping) else raw)

    def end(self) -> tuple[int | None, str | None]:
        """Code and reason, once the server has closed the connection."""
        self._reader.join(TIMEOUT)
        assert not self._reader.is_alive()
        return self._socket.close_code, self._socket.close_reason

    def _send(self, message: viser.infra.Message) -> None:
        self._socket.send(msgspec.msgpack.encode(message.as_serializable_dict()))

    def wait_for(self, condition: Callable[[], bool]) -> None:
        """Wait until what was sent fulfils a condition."""
        with self._changed:
            assert self._changed.wait_for(condition, TIMEOUT)

    # --- what a person sees ---
    def wait_for_all(self) -> None:
        """Wait until both boards and the robot are there, the landscape complete."""
        self.wait_for(
            lambda: (
                "MotionShown 0" in self.shown
                and self.shown.get("LandscapeShown", {}).get("complete") is True
            )
        )

    def widget(self, label: str) -> dict[str, Any]:
        """The widget with this label, once it is there."""
        self.wait_for(lambda: self._uuid(label) is not None)
        return self.widgets[self._uuid(label) or ""]

    def has(self, label: str) -> bool:
        """Whether there is a widget with this label now."""
        return self._uuid(label) is not None

    def _uuid(self, label: str) -> str | None:
        return next((u for u, known in self.widgets.items() if known.get("label") == label), None)

    # --- what a person does ---
    def look(self, position: Point, size: tuple[int, int]) -> None:
        self._send(
            wire.ViewerCameraMessage(
                wxyz=(0.5, 0.5, -0.5, -0.5),
                position=position,
                fov=0.5,
                near=0.01,
                far=1000.0,
                image_height=size[1],
                image_width=size[0],
                look_at=(0.0, 0.0, 1.0),
                up_direction=(0.0, 0.0, 1.0),
            )
        )

    def looked(self, *, turned: bool = False, **seen: object) -> None:
        """What the page says once zoom, tab or camera have rested."""
        boards = dict.fromkeys(("map", "landscape", "map_2", "landscape_2"))
        self.ask("Looked", **{**boards, "tab": "", **seen}, turned=turned)

    def set(self, label: str, value: object) -> None:
        """Move a slider, tick a box, choose from a list, press a button of a group."""
        known = self.widget(label)
        with self._changed:
            known["value"] = value  # as the page shows it, whatever the app makes of it
        self._send(wire.GuiUpdateMessage(self._uuid(label) or "", {"value": value}))

    def press(self, label: str) -> None:
        """Press a button."""
        self.set(label, True)

    def command(self, label: str) -> None:
        """Run a command of the palette, or press its hotkey."""
        self.wait_for(lambda: label in self.commands)
        self._send(wire.CommandTriggerMessage(self.commands[label]))

    def ask(self, kind: str, **fields: object) -> None:
        """What the page's own part says."""
        payload = json.dumps({"type": kind, **fields})
        self.say({"type": "RnnpbAsked", "payload": payload})

    def hello(self, playback: dict[str, object] | None = None) -> None:
        width, height = self._size
        self.ask(
            "Hello",
            document=self.tab.get("document") or None,
            width=width,
            height=height,
            page_width=width,
            page_height=height,
            ratio=1.0,
            dark=False,
            playback=playback,
            present=self.tab.get("secret") or None,
            follow=self._follow,
            free=bool(self.tab.get("free")),
        )

    def drag(self, board: Literal["map", "landscape"], *through: Sequence[float]) -> None:
        """Drag the puck through these points of a board's coordinates."""
        kind = "MapShown" if board == "map" else "LandscapeShown"
        self.wait_for(lambda: kind in self.shown)
        shown = self.shown[kind]
        axes = shown["axes"] if board == "map" else shown["axis_labels"]
        gesture = self.moves + 1
        for number, to in enumerate(through, 1):
            self.moves += 1
            self.ask(
                "MoveOnMap" if board == "map" else "MoveOnLandscape",
                model=shown["model"],
                axes=axes,
                to=list(to),
                gesture=gesture,
                number=self.moves,
                done=number == len(through),
            )

    def upload(self, label: str, name: str, content: bytes) -> None:
        """Choose a file behind an upload button."""
        self.widget(label)
        transfer, source = uuid.uuid4().hex, self._uuid(label) or ""
        self._send(
            wire.FileTransferStartUpload(source, transfer, name, "text/csv", 1, len(content))
        )
        self._send(wire.FileTransferPart(source, transfer, 0, content))

    def freeze(self) -> None:
        """Read nothing more, as a browser with a tab that it has put to sleep."""
        self._awake.clear()

    def thaw(self) -> None:
        self._awake.set()

    def vanish(self) -> None:
        """Go without a word, as a laptop that is closed."""
        self._socket.socket.shutdown(socket.SHUT_RDWR)

    def leave(self) -> None:
        """Close the window."""
        self._socket.close()
        self._reader.join(TIMEOUT)
