"""What a page may say, and that what it may not costs nobody else."""

from __future__ import annotations

import dataclasses
import logging
import math
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
from viser import _messages as wire

from rnnpb_explorer.app.page import bridge, guard
from rnnpb_explorer.app.page.door import Door
from rnnpb_explorer.app.page.gate import (
    MAX_MESSAGE_BYTES,
    MESSAGES_AT_ONCE,
    PAGE_MESSAGES,
    Bucket,
    Gate,
    Incoming,
    PageRefused,
    RnnpbAsked,
    Transfer,
    decoder,
    fits,
)
from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.app.page.uploads import MAX_UPLOAD_BYTES, TOO_LARGE
from rnnpb_explorer.core.checkpoint import save_checkpoint
from rnnpb_explorer.core.model import RNNPB

from .wire_browser import WireBrowser

PART = 512 * 1024  # bytes, as viser's page cuts a file
REFUSED = 1008  # a websocket's code for a policy that was violated
TOO_BIG = 1009
Open = Callable[[], WireBrowser]


@pytest.fixture
def app(tiny_model: RNNPB, tmp_path: Path) -> Iterator[App]:
    path = tmp_path / "tiny.pt"
    save_checkpoint(tiny_model, path)
    running = start(ServerOptions(checkpoints=(str(path),), port=0))
    yield running
    running.stop()


@pytest.fixture
def open_page(app: App) -> Iterator[Open]:
    opened: list[WireBrowser] = []

    def open_one() -> WireBrowser:
        opened.append(WireBrowser(app.url))
        opened[-1].widget("μ 1")
        return opened[-1]

    yield open_one
    for page in opened:
        page.leave()


@pytest.fixture
def page(open_page: Open) -> WireBrowser:
    return open_page()


@pytest.fixture
def bystander(open_page: Open) -> Iterator[WireBrowser]:
    """Another page, which must work after whatever the first one did."""
    other = open_page()
    yield other
    works(other)


def works(page: WireBrowser) -> None:
    """What a hand does is answered: another motion has another mu."""
    other = "bow" if page.widget("Motion")["value"] != "bow" else "rest"
    before = page.widget("μ 1")["value"]
    page.set("Motion", other)
    page.wait_for(lambda: page.widget("μ 1")["value"] != before)


def widget_id(page: WireBrowser, label: str) -> str:
    page.widget(label)
    found = page._uuid(label)
    assert found is not None
    return found


def update(page: WireBrowser, label: str, **updates: object) -> dict[str, object]:
    return {"type": "GuiUpdateMessage", "uuid": widget_id(page, label), "updates": updates}


def start_of(
    page: WireBrowser, size: int, parts: int | None = None, label: str = ""
) -> dict[str, Any]:
    return {
        "type": "FileTransferStartUpload",
        "source_component_uuid": widget_id(page, label or "Upload a motion"),
        "transfer_uuid": uuid.uuid4().hex,
        "filename": "motion.csv",
        "mime_type": "text/csv",
        "part_count": math.ceil(size / PART) if parts is None else parts,
        "size_bytes": size,
    }


def part_of(begun: dict[str, Any], index: int, content: bytes) -> dict[str, Any]:
    return {
        "type": "FileTransferPart",
        "source_component_uuid": begun["source_component_uuid"],
        "transfer_uuid": begun["transfer_uuid"],
        "part_index": index,
        "content": content,
    }


def camera(**changed: object) -> dict[str, object]:
    return {
        "type": "ViewerCameraMessage", "wxyz": (1, 0, 0, 0), "position": (4, 0, 1), "fov": 1,
        "near": 0.01, "far": 1000, "image_height": 720, "image_width": 1280,
        "look_at": (0, 0, 1), "up_direction": (0, 0, 1), **changed,
    }  # fmt: skip


# --- what costs a page ---
HOSTILE: dict[str, Callable[[WireBrowser], bytes | str | dict[str, object]]] = {
    "unknown type": lambda page: {"type": "NoSuchMessage"},
    "no type": lambda page: {"uuid": "x"},
    "a type that is none": lambda page: {"type": 7},
    "viser's, but a server's": lambda page: {"type": "RunJavascriptMessage", "source": "1"},
    "a tunnel to the outside": lambda page: {"type": "ShareUrlRequest"},
    "a form of everybody": lambda page: {"type": "GuiFormDirtyMessage", "uuid": "x"},
    "no message at all": lambda page: b"\xc1",
    "nothing": lambda page: b"",
    "text": lambda page: "hello",
    "deep": lambda page: b"\x91" * 100_000,
    "a list": lambda page: b"\x90",
    "a field too few": lambda page: {"type": "CommandTriggerMessage"},
    "a field too many": lambda page: {"type": "CommandTriggerMessage", "uuid": "x", "y": 1},
    "another kind of value": lambda page: camera(fov="wide"),
    "an attribute of a widget": lambda page: update(page, "Motion", disabled=True),
    "an attribute beside the value": lambda page: update(page, "Motion", value="bow", hint="x"),
    "a method of a widget": lambda page: update(page, "Motion", update_cb=[]),
    "a name without end": lambda page: {"type": "CommandTriggerMessage", "uuid": "x" * 2000},
    "an upload of fewer than no bytes": lambda page: start_of(page, -1),
    "an upload without parts": lambda page: start_of(page, 10, parts=0),
    "more parts than bytes": lambda page: start_of(page, 10, parts=11),
}  # fmt: skip


@pytest.mark.parametrize("what", HOSTILE)
def test_what_no_page_of_ours_says_costs_the_page_that_says_it(
    page: WireBrowser, bystander: WireBrowser, what: str, caplog: pytest.LogCaptureFixture
) -> None:
    page.say(HOSTILE[what](page))
    code, reason = page.end()
    assert code == REFUSED
    assert reason
    works(bystander)  # by then the server has said so
    (line,) = [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert reason in line.getMessage()
    assert line.exc_info is None


def test_a_message_that_is_too_long_costs_the_page(
    page: WireBrowser, bystander: WireBrowser, caplog: pytest.LogCaptureFixture
) -> None:
    page.say(update(page, "Code", value="x" * MAX_MESSAGE_BYTES))
    assert page.end()[0] == TOO_BIG
    works(bystander)  # by then the server has said so
    assert [record.levelno for record in caplog.records] == [logging.WARNING]


def test_a_flood_costs_the_page(
    page: WireBrowser, bystander: WireBrowser, caplog: pytest.LogCaptureFixture
) -> None:
    drop = msgspec.msgpack.encode(camera())
    for _ in range(int(20 * MESSAGES_AT_ONCE)):
        page.say(drop)
    assert page.end() == (REFUSED, "too many messages")
    works(bystander)  # by then the server has said so
    assert [record.levelno for record in caplog.records] == [logging.WARNING]


def test_a_session_is_gone_when_its_page_was_refused(app: App, page: WireBrowser) -> None:
    (session,) = app.sessions.values()
    page.say({"type": "NoSuchMessage"})
    page.end()
    session.join(30)
    assert not session._thread.is_alive()
    assert app.sessions == {}


# --- what is dropped, and costs nothing ---
IGNORED: dict[str, Callable[[WireBrowser], dict[str, object]]] = {
    "a widget that is gone": lambda page: {
        "type": "GuiUpdateMessage", "uuid": "gone", "updates": {"value": 1}
    },
    "an option that is gone": lambda page: update(page, "Motion", value="no such motion"),
    "no option at all": lambda page: update(page, "Motion", value=3),
    "text for a number": lambda page: update(page, "μ 1", value="x"),
    "a list for a number": lambda page: update(page, "μ 1", value=[1.0]),
    "no number": lambda page: update(page, "μ 1", value=math.nan),
    "an infinite number": lambda page: update(page, "Iterations", value=math.inf),
    "a number for a tick": lambda page: update(page, "Uncertainty", value=1),
    "a number for a text": lambda page: update(page, "Code", value=1),
    "a value for an upload": lambda page: update(page, "Upload a motion", value="x"),
    "an upload into a slider": lambda page: start_of(page, 10, label="μ 1"),
    "an upload into nothing": lambda page: {**start_of(page, 10), "source_component_uuid": "x"},
    "a part of nothing": lambda page: part_of(start_of(page, 10), 0, b"x"),
    "a camera nowhere": lambda page: camera(position=(math.nan, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize("what", IGNORED)
def test_what_may_happen_to_any_page_is_passed_over(
    page: WireBrowser, what: str, caplog: pytest.LogCaptureFixture
) -> None:
    page.say(IGNORED[what](page))
    works(page)
    # Of the guard alone: a page of the test before may just be noticed to have gone.
    assert [record for record in caplog.records if record.name == guard.log.name] == []


# --- uploads ---
def test_an_upload_is_refused_by_the_size_that_it_declares(
    page: WireBrowser, bystander: WireBrowser
) -> None:
    begun = start_of(page, MAX_UPLOAD_BYTES + 1)
    page.say(begun)
    page.wait_for(lambda: any(TOO_LARGE in notice for notice in page.notices))
    page.say(part_of(begun, 0, b"1" * PART))  # the page sends them all the same
    works(page)


def test_the_largest_upload_comes_in(page: WireBrowser) -> None:
    content = b"1" * MAX_UPLOAD_BYTES
    begun = start_of(page, len(content))
    page.say(begun)
    for index in range(begun["part_count"]):
        page.say(part_of(begun, index, content[index * PART : (index + 1) * PART]))
    page.wait_for(lambda: bool(page.notices))
    assert TOO_LARGE not in page.notices[0]
    assert "motion.csv" in page.notices[0]


LIARS: dict[str, tuple[int, int, list[tuple[int, int]]]] = {  # size, parts, what comes
    "more bytes than declared": (10, 2, [(0, 10), (1, 1)]),
    "all of them in one part": (10, 1, [(0, PART)]),
    "fewer bytes than declared": (10, 1, [(0, 9)]),
    "a part twice": (10, 2, [(0, 1), (0, 1)]),
    "a part too many": (10, 2, [(2, 1)]),
}


@pytest.mark.parametrize("what", LIARS)
def test_an_upload_that_is_not_what_it_declared_costs_the_page(
    page: WireBrowser, bystander: WireBrowser, what: str
) -> None:
    size, parts, comes = LIARS[what]
    begun = start_of(page, size, parts)
    page.say(begun)
    for index, length in comes:
        page.say(part_of(begun, index, b"1" * length))
    assert page.end() == (REFUSED, "an upload of another size than it said")


def test_uploads_that_never_end_do_not_pile_up(page: WireBrowser, bystander: WireBrowser) -> None:
    for _ in range(3):
        begun = start_of(page, MAX_UPLOAD_BYTES)
        page.say(begun)
        page.say(part_of(begun, 0, b"1" * PART))
    assert page.end() == (REFUSED, "too many uploads at once")


def test_a_flood_of_bytes_costs_the_page(page: WireBrowser, bystander: WireBrowser) -> None:
    begun = start_of(page, 400 * PART)
    page.say(begun)
    for index in range(400):
        page.say(part_of(begun, index, b"1" * PART))
    assert page.end() == (REFUSED, "too many bytes")


@pytest.mark.parametrize("size", [0, 10])
def test_nothing_is_uploaded_into_a_slider(size: int) -> None:
    """viser would make the file its value."""
    slider = SimpleNamespace(value=1.0)
    gate = Gate(decoder(PAGE_MESSAGES), lambda uuid: slider, lambda upload: None)
    begun = {
        "type": "FileTransferStartUpload", "source_component_uuid": "slider",
        "transfer_uuid": "x", "filename": "motion.csv", "mime_type": "text/csv",
        "part_count": min(size, 1), "size_bytes": size,
    }  # fmt: skip
    assert not gate.passes(msgspec.msgpack.encode(begun))
    assert not gate.passes(msgspec.msgpack.encode(part_of(begun, 0, b"1" * size)))


def test_parts_are_counted() -> None:
    transfer = Transfer(parts=3, size=10)
    transfer.add(2, 2)
    transfer.add(0, 4)
    assert not transfer.complete
    transfer.add(1, 4)
    assert transfer.complete


# --- the parts of the gate ---
def test_a_bucket_lets_a_hand_through_and_stops_a_flood() -> None:
    now = 0.0
    bucket = Bucket(rate=10, most=5, clock=lambda: now)
    assert [bucket.take(1) for _ in range(7)] == [True] * 5 + [False] * 2
    now = 0.25
    assert [bucket.take(1) for _ in range(3)] == [True, True, False]
    now = 100.0
    assert bucket.take(5)
    assert not bucket.take(1)


def test_a_pointer_and_three_sliders_may_move_for_minutes() -> None:
    """A screen of 120 Hz, and 20 messages a second of each widget, as viser limits itself."""
    now = 0.0
    gate = Gate(decoder(PAGE_MESSAGES), lambda uuid: None, lambda upload: None, lambda: now)
    moved = msgspec.msgpack.encode(camera())
    for _ in range(180 * 180):
        now += 1 / 180
        assert gate.passes(moved)


@pytest.mark.parametrize(
    ("shown", "value", "may"),
    [
        (1.0, 2, True), (1, 2.5, True), (1.0, True, False), (True, False, True), (True, 1, False),
        ("x", "y", True), ("x", 1, False), ((1, 2), [3, 4], True), ((1, 2), [3], False),
        ((1, 2), "ab", False), (None, 1, False),
    ],
)  # fmt: skip
def test_a_value_is_of_the_widgets_kind(shown: object, value: object, may: bool) -> None:
    assert fits(SimpleNamespace(value=shown), value) is may


def test_a_choice_is_one_that_is_offered() -> None:
    widget = SimpleNamespace(value="a", options=("a", "b"))
    assert fits(widget, "b")
    assert not fits(widget, "c")


@pytest.mark.parametrize("message", PAGE_MESSAGES, ids=lambda message: message.__name__)
def test_messages_have_the_fields_that_viser_gives_them(message: type[Incoming]) -> None:
    """A new release that calls one otherwise is seen here, not by closed pages."""
    known = bridge if message is RnnpbAsked else wire
    theirs = {field.name for field in dataclasses.fields(getattr(known, message.__name__))}
    assert {field.name for field in msgspec.structs.fields(message)} == theirs


def test_a_message_of_our_own_passes_once_it_is_named() -> None:
    class BoardMessage(Incoming):
        x: float

    def gate(*messages: type[Incoming]) -> Gate:
        return Gate(decoder(messages), lambda uuid: None, lambda upload: None)

    ours = msgspec.msgpack.encode({"type": "BoardMessage", "x": 1})
    assert gate(*PAGE_MESSAGES, BoardMessage).passes(ours)
    nowhere = msgspec.msgpack.encode({"type": "BoardMessage", "x": math.nan})
    assert not gate(*PAGE_MESSAGES, BoardMessage).passes(nowhere)
    with pytest.raises(PageRefused):
        gate(*PAGE_MESSAGES).passes(ours)
    with pytest.raises(PageRefused):
        gate(*PAGE_MESSAGES, BoardMessage).passes(msgspec.msgpack.encode({"type": "BoardMessage"}))


# --- a viser that has changed ---
def test_a_viser_that_starts_its_server_elsewhere_is_not_used(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("viser.ViserServer", lambda **options: None)
    with pytest.raises(RuntimeError, match=r"1\.1\.1"):
        guard.Guard(Door("127.0.0.1")).start(host="127.0.0.1", port=0)


def test_a_page_that_is_packed_otherwise_is_not_served(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    page = tmp_path / "index.html"
    page.write_text("<html><script>1</script></html>")
    monkeypatch.setattr(guard, "PAGE", page)
    with pytest.raises(RuntimeError, match=r"1\.1\.1"):
        guard.page_scripts()
