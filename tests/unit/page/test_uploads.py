"""Files that somebody uploads: motions, state codes, and what is neither."""

from __future__ import annotations

import threading
from collections.abc import Callable
from queue import Queue
from typing import Any

import numpy as np
import pytest
from arm import write_arm

from rnnpb_explorer.app.page.uploads import Upload, UploadReader, read_upload
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.statecode import encode
from rnnpb_explorer.core.motion import MAX_CSV_BYTES, format_motion
from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.reading import Said

from ..app_states import FACTS, JOINTS, opened, target_motion

TIMEOUT = 20.0  # seconds until a test that hangs has failed; nothing waits for it otherwise
TARGET = target_motion(frames=10)


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    return load_robot(str(write_arm(tmp_path_factory.mktemp("robots"))))


@pytest.fixture
def read(arm: Robot) -> Callable[..., tuple[do.Intent, ...]]:
    def upload(name: str, content: bytes, **more: Any) -> tuple[do.Intent, ...]:
        return read_upload(Upload(name, lambda: content, FACTS[0], **more), content, arm)

    return upload


Read = Callable[..., tuple[do.Intent, ...]]


def test_an_upload_becomes_the_target(read: Read) -> None:
    content = format_motion(TARGET).encode()
    intent, file, told = read("my wave.csv", content)
    assert file == do.ShowFile(("my wave",))
    assert isinstance(intent, do.SetTarget)
    target = intent.target
    assert (target.name, target.joints, target.fps) == ("my wave", JOINTS, 20.0)
    np.testing.assert_array_equal(target.array, TARGET.positions)
    assert told == do.Say("my wave: 10 frames, ready to recognise", good=True)


def test_a_file_with_a_state_code_restores_it(read: Read) -> None:
    code = encode(opened(FACTS, do.SetMu(0, 0.9)))
    assert read("x.csv", code.encode()) == (do.RestoreCode(code),)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "x.csv"),
        (b"a,b,c,d\n1,2,3,4\n1,2,3,4\n", "no column for e"),
        (b"\xff\xfe\x00", "x.csv"),
        (b"a,b,c,d,e\n1,2,3,4,nan\n1,2,3,4,5\n", "row 2"),
        (b"x" * (MAX_CSV_BYTES + 1), "larger than 8 MB"),
    ],
    ids=["empty", "joint missing", "no text", "nan", "too large"],
)
def test_an_upload_that_is_no_motion_is_refused_in_one_line(
    read: Read, content: bytes, says: str
) -> None:
    (said,) = read("x.csv", content)
    assert isinstance(said, do.Say)
    assert not said.good
    assert says in said.text
    assert "\n" not in said.text


@pytest.mark.parametrize("name", ["", "\n\r\x00.csv", "x" * 10_000 + ".csv", "<b>é\u202e.csv"])
def test_an_upload_may_be_called_anything(read: Read, name: str) -> None:
    intent, *_ = read(name, format_motion(TARGET).encode())
    assert isinstance(intent, do.SetTarget)
    assert intent.target.name.isprintable()
    assert 0 < len(intent.target.name) <= 80


def test_what_is_chosen_while_another_file_is_read_stays_chosen(arm: Robot) -> None:
    content = format_motion(TARGET).encode()
    begun, chosen = threading.Event(), threading.Event()

    def large() -> bytes:
        begun.set()
        assert chosen.wait(TIMEOUT)
        return content

    sent: Queue[do.Intent] = Queue()
    reader = UploadReader(arm, sent.put)
    reader.read(Upload("large.csv", large, FACTS[0]))
    assert begun.wait(TIMEOUT)
    reader.read(Upload("small.csv", lambda: content, FACTS[0]))
    chosen.set()
    intent = sent.get(timeout=TIMEOUT)  # they are read one after the other
    assert isinstance(intent, do.SetTarget)
    assert intent.target.name == "small"
    assert isinstance(sent.get(timeout=TIMEOUT), do.ShowFile)
    assert isinstance(sent.get(timeout=TIMEOUT), do.Say)
    assert sent.empty()


@pytest.mark.parametrize("error", [OSError("no such file"), MemoryError("too much")])
def test_a_file_that_cannot_be_read_is_logged_and_said(
    arm: Robot, error: Exception, caplog: pytest.LogCaptureFixture
) -> None:
    def broken() -> bytes:
        raise error

    sent: Queue[do.Intent] = Queue()
    UploadReader(arm, sent.put).read(Upload("x.csv", broken, FACTS[0]))
    assert sent.get(timeout=TIMEOUT) == do.Say(f"the file could not be read: {error}")
    (record,) = caplog.records
    assert record.exc_info is not None
    assert record.exc_info[1] is error


def test_of_several_motions_the_first_is_taken_and_the_others_are_offered(read: Read) -> None:
    rows = "".join(f"{name},0.{i},0,0,0,0\n" for name in ("walk", "run") for i in range(3))
    content = f"id,a,b,c,d,e\n{rows}".encode()
    intent, file, told = read("two.csv", content)
    assert isinstance(intent, do.SetTarget)
    assert intent.target.name == "walk"
    assert file == do.ShowFile(("walk", "run"))
    assert isinstance(told, do.Say)
    assert "2 motions in it: choose one below the upload" in told.text
    other, *_ = read("two.csv", content, motion="run")
    assert isinstance(other, do.SetTarget)
    assert other.target.name == "run"


def test_what_cannot_be_known_is_asked_and_can_be_said(read: Read) -> None:
    content = b"a,b,c,d,e\n30,20,10,40,20\n31,21,11,41,21\n"  # d and e have no limits
    said, file = read("x.csv", content)
    assert isinstance(said, do.Say)
    assert not said.good
    assert "in degrees" in said.text
    assert "Say it under File" in said.text
    assert file == do.ShowFile()
    intent, *_ = read("x.csv", content, said=Said(unit="degrees"))
    assert isinstance(intent, do.SetTarget)
    np.testing.assert_allclose(intent.target.array[0], np.radians([30, 20, 10, 40, 20]), rtol=1e-6)
