"""What goes between the server and the browser's part: the same on both sides, and checked."""

from __future__ import annotations

import dataclasses
import re
import shutil
import subprocess
from importlib import resources
from typing import Any

import msgspec
import numpy as np
import pytest
import viser
from viser._messages import Message

from rnnpb_explorer.app.page import asked as do
from rnnpb_explorer.app.page import shown
from rnnpb_explorer.app.page.bridge import Bridge, RnnpbAsked, RnnpbShown, board_html
from rnnpb_explorer.app.page.robot_nodes import robot_shown
from rnnpb_explorer.app.page.script import script, wrapped
from rnnpb_explorer.core import InputError
from rnnpb_explorer.robot.description import load_robot
from rnnpb_explorer.robot.kinematics import joint_poses

MESSAGES = resources.files("rnnpb_explorer.static").joinpath("web", "messages.js").read_text()
MOVE = {"type": "MoveOnMap", "model": 0, "axes": [0, 1], "to": [0.5, -1], "gesture": 1, "number": 2}


def said(**fields: Any) -> str:
    return msgspec.json.encode(fields).decode()


# --- both sides are the same ---
def typedef(name: str) -> list[str]:
    """The properties of a type in messages.js, in order."""
    block = re.search(rf"@typedef {{object}} {name}\b.*?\*/", MESSAGES, re.DOTALL)
    if block:
        return re.findall(r"@property {.*} (\w+)", block[0])
    inline = re.search(rf"@typedef {{{{ (.*) }}}} {name}\b", MESSAGES)
    assert inline is not None, f"{name} is not in messages.js"
    return re.findall(r"(\w+):", inline[1])


KINDS = [
    kind
    for kind in (*shown.Shown.__subclasses__(), *shown.OnBoards.__subclasses__())
    if kind is not shown.OnBoards
]


@pytest.mark.parametrize("kind", [*KINDS, shown.RobotShown])
def test_the_page_knows_every_field_that_is_shown(kind: type) -> None:
    names = [field.name for field in dataclasses.fields(kind)]
    assert sorted(typedef(kind.__name__)) == sorted(names)


def test_the_page_handles_all_that_is_shown() -> None:
    assert sorted(typedef("Shown")) == sorted(kind.__name__ for kind in KINDS)
    for name in typedef("Shown"):
        assert f"{name}: (" in script()


@pytest.mark.parametrize("kind", do.Asked.__subclasses__())
def test_the_server_knows_every_field_that_is_asked(kind: type[msgspec.Struct]) -> None:
    block = re.search(rf'type: "{kind.__name__}"(.*?)}}\s*$', MESSAGES, re.DOTALL | re.MULTILINE)
    assert block is not None
    names = re.findall(r"(\w+):", re.sub(r"{.*?}", "", block[1]))
    assert sorted(names) == sorted(kind.__struct_fields__)


# --- down ---
def test_arrays_travel_with_their_shapes_and_in_types_that_the_page_has() -> None:
    motion = shown.MotionShown(
        0, 3, np.arange(6.0).reshape(2, 3), 25.0, eyes=np.ones((2, 3), np.uint8)
    )
    buffers: list[memoryview] = []
    message = RnnpbShown("MotionShown", shown.wire(motion), motion.key)
    body = message.as_serializable_dict(buffers)["body"]
    assert body["angles"] == {"shape": [2, 3], "data": {"__binary_index": 0, "dtype": "<f4"}}
    assert body["eyes"]["data"]["dtype"] == "|u1"
    assert body["ghosts"] is None
    np.testing.assert_array_equal(np.frombuffer(buffers[0], "<f4"), np.arange(6))


def test_a_newer_motion_replaces_an_older_one_of_the_same_robot_only() -> None:
    keys = {
        RnnpbShown(
            "MotionShown", {}, shown.MotionShown(robot, number, np.zeros((1, 1)), 25).key
        ).redundancy_key()
        for robot, number in [(0, 1), (0, 2), (1, 3)]
    }
    assert len(keys) == 2


def test_a_robot_is_posed_from_the_same_numbers_as_on_the_server() -> None:
    robot = load_robot("pepper")
    joints = ("HeadYaw", "LHand", "LElbowRoll")
    positions = np.array([[0.3, 0.8, -0.9]])
    told = robot_shown(robot, joints, "/robot")
    value = told.offsets + np.where(told.columns < 0, 0, told.factors * positions[0, told.columns])
    half = value[:, None] / 2
    expected = joint_poses(robot, joints, positions)
    np.testing.assert_allclose(
        np.where(told.sliding[:, None], told.rest_wxyz, np.cos(half) * robot.tree.rest_wxyz
                 + np.sin(half) * robot.tree.half_turn_wxyz),
        expected.wxyz[0], atol=1e-6,
    )  # fmt: skip
    assert told.nodes[0].startswith("/robot/")
    assert len(told.eyes) == 16


# --- up ---
def test_a_move_is_understood() -> None:
    assert do.parse(said(**MOVE, done=True)) == do.MoveOnMap(0, [0, 1], [0.5, -1.0], 1, 2, True)


@pytest.mark.parametrize(
    "payload",
    [
        None,
        7,
        b"{}",
        "",
        "[]",
        "{}",
        '{"type":"Format"}',
        "[" * 100_000,
        said(**MOVE),
        said(**MOVE, done="yes"),
        said(**MOVE, done=True, more=1),
        said(**{**MOVE, "axes": [0]}, done=True),
        said(**{**MOVE, "axes": [0, 128]}, done=True),
        said(**{**MOVE, "to": [0.5, 1e9]}, done=True),
        said(**{**MOVE, "to": [0.5, None]}, done=True),
        said(**{**MOVE, "to": [0.5] * 2000}, done=True),
        said(type="SelectMotion", index=-1),
        said(type="SelectMotion", index=1.5),
        said(type="Seek", frame=-1),
        said(type="SetSpeed", speed=0),
        said(type="SetObserved", share=1.01),
        said(type="Undo") + " " * 3000,
        "x" * 200_000,
    ],
)
def test_nonsense_is_refused(payload: object) -> None:
    with pytest.raises(InputError):
        do.parse(payload)


def test_a_document_may_be_long_but_not_of_any_length() -> None:
    hello = {
        "type": "Hello", "width": 1, "height": 1, "ratio": 1, "page_width": 1, "page_height": 1,
        "dark": False, "playback": None,
    }  # fmt: skip
    heard = do.parse(said(**hello, document="x" * do.MAX_DOCUMENT))
    assert isinstance(heard, do.Hello)
    with pytest.raises(InputError):
        do.parse(said(**hello, document="x" * (do.MAX_DOCUMENT + 1)))


def test_a_page_may_send_what_a_hand_can_and_no_more() -> None:
    now = [0.0]
    allowance = do.Allowance(per_second=10, burst=3, clock=lambda: now[0])
    assert [allowance.spend() for _ in range(4)] == [True, True, True, False]
    now[0] = 0.15
    assert [allowance.spend() for _ in range(2)] == [True, False]
    now[0] = 100.0
    assert [allowance.spend() for _ in range(4)] == [True, True, True, False]


@pytest.mark.parametrize(
    "message", [{}, {"payload": {"a": 1}}, {"payload": None, "kind": 1}, {"other": "x"}]
)
def test_whatever_is_in_a_message_it_is_still_a_message(message: dict[str, Any]) -> None:
    raw = msgspec.msgpack.encode({"type": "RnnpbAsked", **message})
    heard = Message.deserialize(raw)
    assert isinstance(heard, RnnpbAsked)
    assert heard.payload == message.get("payload")


# --- the bridge ---
class Connection:
    """What a bridge needs of viser's connection."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.handlers: dict[type, Any] = {}

    def register_handler(self, kind: type, handler: Any) -> None:
        self.handlers[kind] = handler

    def queue_message(self, message: Any) -> None:
        self.sent.append(message)


class Client:
    def __init__(self) -> None:
        self._websock_connection = Connection()


HELLO = said(
    type="Hello", document=None, width=800, height=600, ratio=1, page_width=1280, page_height=720,
    dark=False, playback=None,
)  # fmt: skip


def bridged() -> tuple[Bridge, Connection, list[do.AnyAsked]]:
    client: Any = Client()
    asked: list[do.AnyAsked] = []
    return Bridge(client, asked.append), client._websock_connection, asked


def test_what_is_shown_waits_for_hello_and_only_the_newest_of_it() -> None:
    bridge, connection, asked = bridged()
    assert len(connection.sent) == 1  # the script
    bridge.show(shown.DocumentShown("first"))
    bridge.show(shown.DocumentShown("second"))
    assert len(connection.sent) == 1
    connection.handlers[RnnpbAsked](0, RnnpbAsked(HELLO))
    assert [message.body["text"] for message in connection.sent[1:]] == ["second"]
    assert isinstance(asked[0], do.Hello)
    bridge.show(shown.DocumentShown("third"))
    assert connection.sent[-1].body["text"] == "third"


def test_a_bad_message_is_counted_and_costs_no_other(caplog: pytest.LogCaptureFixture) -> None:
    bridge, connection, asked = bridged()
    hear = connection.handlers[RnnpbAsked]
    for payload in ("nonsense", 3, said(type="Undo"), "{"):
        hear(0, RnnpbAsked(payload))
    assert asked == [do.Undo()]
    assert bridge.refused == 3
    assert len(caplog.records) == 1


def test_a_flood_is_refused() -> None:
    bridge, connection, asked = bridged()
    for _ in range(1000):
        connection.handlers[RnnpbAsked](0, RnnpbAsked(said(type="Undo")))
    assert do.BURST <= len(asked) < 900
    assert bridge.refused == 1000 - len(asked)


def test_another_viser_is_one_clear_line(caplog: pytest.LogCaptureFixture) -> None:
    class Other:
        pass

    client: Any = Other()
    with pytest.raises(InputError, match=r"^the boards need viser 1\.1\.1"):
        Bridge(client, lambda _: None)
    assert len(caplog.records) == 1


def test_viser_has_the_names_that_the_bridge_uses() -> None:
    """The real client handle of a real server, without a browser."""
    assert viser.__version__ == "1.1.1"
    assert "_websock_connection" in viser.ClientHandle.__init__.__code__.co_names
    assert re.findall(r'id="([^"]*)"', board_html("map")) == ["rnnpb-map"]
    assert re.findall(r'id="([^"]*)"', board_html("map", 2)) == ["rnnpb-map", "rnnpb-map-2"]


# --- the script ---
def test_modules_have_scopes_of_their_own() -> None:
    source = 'import { a } from "./one.js";\nconst b = 1;\nexport const c = a + b;\n'
    assert wrapped("two", source) == (
        "const _two = (() => {\nconst { a } = _one;\nconst b = 1;\nconst c = a + b;\n\n"
        "return { c };\n})();"
    )


@pytest.mark.parametrize(
    "line",
    ['import * as x from "./one.js";', 'import x from "./one.js";', "export default 1;",
     'import { a as b } from "./one.js";'],
)  # fmt: skip
def test_what_cannot_be_joined_is_said(line: str) -> None:
    with pytest.raises(ValueError, match=r"two\.js"):
        wrapped("two", line + "\n")


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
def test_the_script_is_javascript() -> None:
    result = subprocess.run(
        ["node", "--check", "-"], input=script(), text=True, capture_output=True, check=False
    )
    assert result.returncode == 0, result.stderr
