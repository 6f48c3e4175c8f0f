"""The command `rnnpb-explorer`, as a person at a terminal meets it."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from rnnpb_explorer.app.commands.explorer import main
from rnnpb_explorer.app.page.door import address_for_others
from rnnpb_explorer.core.checkpoint import save_checkpoint, shipped_checkpoints
from rnnpb_explorer.core.model import RNNPB

from .wire_browser import WireBrowser

COMMAND = Path(sys.executable).with_name("rnnpb-explorer")
TIMEOUT = 90.0  # seconds until a test that hangs has failed; nothing waits for it otherwise


@pytest.fixture
def checkpoint(tiny_model: RNNPB, tmp_path: Path) -> str:
    path = tmp_path / "tiny.pt"
    save_checkpoint(tiny_model, path)
    return str(path)


@pytest.fixture(autouse=True)
def signals() -> Iterator[None]:
    """`main` takes the signals; pytest gets them back."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def serving(*arguments: str) -> tuple[subprocess.Popen[str], str]:
    """The running command and its first line."""
    process = subprocess.Popen(
        [COMMAND, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    watchdog = threading.Timer(TIMEOUT, process.kill)
    watchdog.start()
    assert process.stdout is not None
    line = process.stdout.readline()
    watchdog.cancel()
    return process, line


@pytest.mark.skipif(not COMMAND.exists(), reason="rnnpb-explorer is not installed beside python")
@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGINT])
def test_it_says_where_it_serves_and_ends_when_told(checkpoint: str, ending: int) -> None:
    process, line = serving("--ckpt", checkpoint, "--port", "0")
    try:
        words = line.split()
        assert words[:-1] == ["rnnpb-explorer", "is", "ready", "at"]
        with urllib.request.urlopen(words[-1], timeout=20) as response:
            assert response.status == 200
        process.send_signal(ending)
        rest, errors = process.communicate(timeout=TIMEOUT)
    finally:
        process.kill()
    assert process.returncode == 0
    assert "Traceback" not in errors
    assert "http" not in rest


@pytest.mark.skipif(not COMMAND.exists(), reason="rnnpb-explorer is not installed beside python")
@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGINT])
def test_it_ends_in_the_middle_of_a_drag_and_a_recognition(ending: int) -> None:
    process, line = serving("--port", "0")
    try:
        pages = [WireBrowser(line.split()[-1]) for _ in range(2)]
        for page in pages:
            page.wait_for(lambda page=page: "PuckShown" in page.shown)
        pages[0].set("Example", "halfway")
        pages[0].wait_for(lambda: any("ready to recognise" in one for one in pages[0].notices))
        pages[0].set("Method", "as published: sampling and Adam")
        pages[0].press("Start")
        pages[0].wait_for(lambda: len(pages[0].shown["PathShown"]["radii"]) > 2)
        pages[1].drag("map", *[(0.01 * i, 0.0) for i in range(60)])
        process.send_signal(ending)
        _, errors = process.communicate(timeout=TIMEOUT)
    finally:
        process.kill()
    assert process.returncode == 0
    assert "Traceback" not in errors


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="Linux says who catches what")
@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGINT])
def test_it_ends_while_it_loads(ending: int) -> None:
    process = subprocess.Popen(
        [COMMAND, "--port", "0"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    watchdog = threading.Timer(TIMEOUT, process.kill)
    watchdog.start()
    try:
        while not catches(process.pid, signal.SIGTERM):  # the later one; Python has one for SIGINT
            assert process.poll() is None
        process.send_signal(ending)
        _, errors = process.communicate(timeout=TIMEOUT)
    finally:
        watchdog.cancel()
        process.kill()
    assert process.returncode == 0
    assert "Traceback" not in errors


def catches(process: int, number: int) -> bool:
    """Whether a process has a handler of its own for a signal."""
    status = Path(f"/proc/{process}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt"))
    return bool(int(caught.split()[1], 16) >> (number - 1) & 1)


@pytest.mark.skipif(not COMMAND.exists(), reason="rnnpb-explorer is not installed beside python")
def test_over_ssh_it_says_how_to_bring_the_port_to_oneself(
    checkpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSH_CONNECTION", "192.0.2.7 50000 192.0.2.1 22")
    process, line = serving("--ckpt", checkpoint, "--port", "0")
    port = line.strip().rpartition(":")[2]
    process.terminate()
    _, errors = process.communicate(timeout=TIMEOUT)
    assert f"ssh -N -L {port}:127.0.0.1:{port} " in errors
    assert "@192.0.2.1" in errors


@pytest.mark.skipif(not COMMAND.exists(), reason="rnnpb-explorer is not installed beside python")
def test_serving_everybody_is_said_aloud(checkpoint: str) -> None:
    process, _ = serving("--ckpt", checkpoint, "--port", "0", "--host", "0.0.0.0", "--no-token")
    process.terminate()
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 0
    assert "everybody" in errors
    assert "no password" in errors


@pytest.mark.skipif(not COMMAND.exists(), reason="rnnpb-explorer is not installed beside python")
def test_the_printed_link_opens_the_door(checkpoint: str) -> None:
    arguments = ("--ckpt", checkpoint, "--port", "0", "--host", "0.0.0.0", "--token", "a&b")
    process, line = serving(*arguments)
    link = line.split()[-1]
    try:
        assert link.endswith("/?token=a%26b")
        remembers = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        with remembers.open(link, timeout=20) as response:
            assert response.status == 200
            assert "token" not in response.url
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(link.partition("?")[0], timeout=20)
    finally:
        process.terminate()
        _, errors = process.communicate(timeout=TIMEOUT)
    assert "everybody" not in errors
    others = address_for_others()
    assert (f"others open http://{others}:" in errors) == (others is not None)
    assert errors.count("/?token=a%26b") == (others is not None)


@pytest.mark.skipif(not COMMAND.exists(), reason="rnnpb-explorer is not installed beside python")
def test_a_terminal_shows_that_it_is_loading(checkpoint: str) -> None:
    terminal, other_end = pty.openpty()
    process = subprocess.Popen(
        [COMMAND, "--ckpt", checkpoint, "--port", "0"],
        stdout=other_end,
        stderr=other_end,
        env=os.environ | {"TERM": "xterm"},
    )
    watchdog = threading.Timer(TIMEOUT, process.kill)
    watchdog.start()
    os.close(other_end)
    shown = b""
    try:
        while part := os.read(terminal, 4096):
            shown += part
            if b" is ready at " in shown:
                process.terminate()
    except OSError:  # the end of a terminal
        pass
    finally:
        watchdog.cancel()
        os.close(terminal)
    assert process.wait(timeout=TIMEOUT) == 0
    assert b"loading the models and the robot" in shown
    assert b"\x1b[2Krnnpb-explorer is ready at http://" in shown  # over the line, which is gone


@pytest.mark.skipif(not COMMAND.exists(), reason="rnnpb-explorer is not installed beside python")
def test_bad_input_is_one_line_and_code_2() -> None:
    done = subprocess.run(
        [COMMAND, "--ckpt", "nope", "--port", "0"],
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("rnnpb-explorer: no checkpoint 'nope'")
    for name in shipped_checkpoints():
        assert name in done.stderr


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--bogus"], "--bogus"),
        (["extra"], "extra"),
        (["--port", "many"], "--port"),
        (["--port", "65536"], "65535"),
        (["--port", "-1"], "65535"),
        (["--seed", "-1"], "--seed"),
        (["--seed", "0.5"], "--seed"),
        (["--device", "tpu"], "--device"),
        (["--ckpt"], "--ckpt"),
        (["--por", "0"], "--por"),
        (["--robot", "nope.urdf"], "nope.urdf"),
        (["--robot", ""], ""),
        (["--data", "nope.csv"], "nope.csv"),
        (["--ckpt", "no\nsuch\x1b[31mfile"], "such"),
        (["--host", "256.1.1.1", "--token", "x"], "256.1.1.1"),
        (["--host", "0.0.0.0"], "--no-token"),
        (["--token", "x", "--no-token"], "--no-token"),
        (["--token"], "--token"),
        (["--token", "two words"], "--token"),
        (["--allow-origin", "course.example"], "course.example"),
        (["--allow-frame", "*"], "--allow-frame"),
    ],
    ids=lambda value: " ".join(value).replace("\n", " ") if isinstance(value, list) else "",
)
def test_what_it_cannot_use_is_named_in_one_line(
    checkpoint: str, capsys: pytest.CaptureFixture[str], arguments: list[str], says: str
) -> None:
    given = arguments if "--ckpt" in arguments else ["--ckpt", checkpoint, *arguments]
    assert main([*given, *([] if "--port" in given else ["--port", "0"])]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("rnnpb-explorer: ")
    assert err.count("\n") == 1
    assert err.rstrip("\n").isprintable()
    assert says in err


@pytest.mark.parametrize("content", [b"", b"no checkpoint", b"PK\x03\x04" + b"\x00" * 100])
def test_a_damaged_checkpoint_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    path = tmp_path / "damaged.pt"
    path.write_bytes(content)
    assert main(["--ckpt", str(path), "--port", "0"]) == 2
    assert "damaged.pt" in capsys.readouterr().err


def test_help_lists_every_flag(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    for flag in ("--ckpt", "--host", "--port", "--robot", "--data", "--device", "--seed"):
        assert flag in out
    for flag in ("--token", "--no-token", "--allow-origin", "--allow-frame"):
        assert flag in out
