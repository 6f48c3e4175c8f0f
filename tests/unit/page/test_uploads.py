"""Files that somebody uploads: motions, state codes, and what is neither."""

from __future__ import annotations

import threading
from queue import Queue

import numpy as np
import pytest

from rnnpb_explorer.app.page.uploads import UploadReader, read_upload
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.statecode import encode
from rnnpb_explorer.core.motion import MAX_CSV_BYTES, format_motion

from ..app_states import FACTS, JOINTS, opened, target_motion

TIMEOUT = 20.0  # seconds until a test that hangs has failed; nothing waits for it otherwise
TARGET = target_motion(frames=10)


def test_an_upload_becomes_the_target() -> None:
    content = format_motion(TARGET).encode()
    intent, told = read_upload("my wave.csv", content, FACTS[0])
    assert isinstance(intent, do.SetTarget)
    target = intent.target
    assert (target.name, target.joints, target.fps) == ("my wave", JOINTS, 20.0)
    np.testing.assert_array_equal(target.array, TARGET.positions)
    assert told == do.Say("my wave: 10 frames, ready to recognise", good=True)


def test_a_file_with_a_state_code_restores_it() -> None:
    code = encode(opened(FACTS, do.SetMu(0, 0.9)))
    assert read_upload("x.csv", code.encode(), FACTS[0]) == (do.RestoreCode(code),)


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
def test_an_upload_that_is_no_motion_is_refused_in_one_line(content: bytes, says: str) -> None:
    (said,) = read_upload("x.csv", content, FACTS[0])
    assert isinstance(said, do.Say)
    assert not said.good
    assert says in said.text
    assert "\n" not in said.text


@pytest.mark.parametrize("name", ["", "\n\r\x00.csv", "x" * 10_000 + ".csv", "<b>é\u202e.csv"])
def test_an_upload_may_be_called_anything(name: str) -> None:
    intent, _ = read_upload(name, format_motion(TARGET).encode(), FACTS[0])
    assert isinstance(intent, do.SetTarget)
    assert intent.target.name.isprintable()
    assert 0 < len(intent.target.name) <= 80


def test_what_is_chosen_while_another_file_is_read_stays_chosen() -> None:
    content = format_motion(TARGET).encode()
    begun, chosen = threading.Event(), threading.Event()

    def large() -> bytes:
        begun.set()
        assert chosen.wait(TIMEOUT)
        return content

    sent: Queue[do.Intent] = Queue()
    reader = UploadReader(sent.put)
    reader.read("large.csv", large, FACTS[0])
    assert begun.wait(TIMEOUT)
    reader.read("small.csv", lambda: content, FACTS[0])
    chosen.set()
    intent = sent.get(timeout=TIMEOUT)  # they are read one after the other
    assert isinstance(intent, do.SetTarget)
    assert intent.target.name == "small"
    assert isinstance(sent.get(timeout=TIMEOUT), do.Say)
    assert sent.empty()


@pytest.mark.parametrize("error", [OSError("no such file"), MemoryError("too much")])
def test_a_file_that_cannot_be_read_is_logged_and_said(
    error: Exception, caplog: pytest.LogCaptureFixture
) -> None:
    def broken() -> bytes:
        raise error

    sent: Queue[do.Intent] = Queue()
    UploadReader(sent.put).read("x.csv", broken, FACTS[0])
    assert sent.get(timeout=TIMEOUT) == do.Say(f"the file could not be read: {error}")
    (record,) = caplog.records
    assert record.exc_info is not None
    assert record.exc_info[1] is error
