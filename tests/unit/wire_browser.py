"""A browser reduced to its wire: it speaks viser's protocol and draws nothing.

It says where its camera is, answers for its local storage, keeps what it is sent, and does what a
person does: moves sliders, presses buttons, drags on boards, uploads files. The page itself is
tested in a real browser, in tests/browser.
"""

from __future__ import annotations

import contextlib
import threading
import uuid
from collections.abc import Callable, Mapping
from typing import Any

import msgspec.msgpack
import viser
import zstandard
from viser import _messages as wire
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

TIMEOUT = 30.0  # seconds until a test that hangs has failed; nothing waits for it otherwise
Point = tuple[float, float, float]


class WireBrowser:
    """One window on the app at `url`.

    Args:
        storage: the local storage, kept over reloads by who passes it again.
        silent: never answer for the local storage.
        headers: of the request, as a browser would send them.
    """

    def __init__(
        self,
        url: str,
        storage: dict[str, str] | None = None,
        *,
        size: tuple[int, int] = (1280, 720),
        silent: bool = False,
        headers: Mapping[str, str] | None = None,
    ) -> None:
        self.storage = {} if storage is None else storage
        self.widgets: dict[str, dict[str, Any]] = {}  # by uuid: label, value, options, ...
        self.nodes: dict[str, dict[str, Any]] = {}  # of the scene, by name
        self.commands: dict[str, str] = {}  # uuid by label
        self.notices: list[str] = []
        self.files: dict[str, bytes] = {}  # that the app had the browser save, by name
        self.asked = threading.Event()  # the server has asked for the local storage
        self._silent = silent
        self._downloads: dict[str, str] = {}  # file names by transfer
        self._changed = threading.Condition()
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
        unpack = zstandard.ZstdDecompressor()
        try:
            for raw in self._socket:
                assert isinstance(raw, bytes)
                length = int.from_bytes(raw[8:16], "little")
                content = msgspec.msgpack.decode(unpack.decompress(raw[16 : 16 + length]))
                for message in content["messages"]:
                    self._take(message)
        except ConnectionClosed:
            return

    def _take(self, message: dict[str, Any]) -> None:
        kind = message["type"]
        if kind == "LocalStorageGetItemRequestMessage":
            self.asked.set()
            if not self._silent:
                value = self.storage.get(message["key"])
                self._send(
                    wire.LocalStorageGetItemResponseMessage(value, None, message["request_uuid"])
                )
        elif kind == "LocalStorageSetItemMessage":
            self.storage[message["key"]] = message["value"]
        with self._changed:
            if kind == "NotificationShowMessage":
                self.notices.append(message["props"]["body"])
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

    def drag(self, node: str, *through: Point, modifier: str | None = None) -> None:
        """Drag on a scene node along rays from the camera through these points."""
        self.wait_for(lambda: node in self.nodes)
        phases = ["start", *["update"] * (len(through) - 2), "end"]
        for phase, point in zip(phases, through, strict=True):
            self._send(
                wire.SceneNodeDragMessage(
                    phase=phase,  # type: ignore[arg-type]
                    name=node,
                    instance_index=None,
                    start_position=through[0],
                    start_screen_pos=(0.5, 0.5),
                    end_position=point,
                    end_screen_pos=(0.5, 0.5),
                    button="left",
                    modifier=modifier,  # type: ignore[arg-type]
                    owner=self.nodes[node].get("owner", ""),
                )
            )

    def upload(self, label: str, name: str, content: bytes) -> None:
        """Choose a file behind an upload button."""
        self.widget(label)
        transfer, source = uuid.uuid4().hex, self._uuid(label) or ""
        self._send(
            wire.FileTransferStartUpload(source, transfer, name, "text/csv", 1, len(content))
        )
        self._send(wire.FileTransferPart(source, transfer, 0, content))

    def leave(self) -> None:
        """Close the window."""
        self._socket.close()
        self._reader.join(TIMEOUT)
