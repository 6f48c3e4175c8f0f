"""pip install, told in a line: what it is doing and for how long, instead of a wall of text.

`make` runs it with the Python of the environment to install into, so it needs nothing but Python.
Its arguments are those of `pip install`; the end of what pip said is shown if it fails.
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Sequence

WIDTH = 79
LINES = 20  # of pip's that are shown if it fails
PIP = ("-m", "pip", "--disable-pip-version-check", "install", "--progress-bar", "off")
# What pip says, and what that means.
STEPS = (
    (re.compile(r"Collecting ([\w.-]+)"), "looking for {}"),
    (re.compile(r"\s*Downloading (?:\S*/)?(\S+ \(.+\))"), "downloading {}"),
    (re.compile(r"\s*(?:Using cached|Processing) (?:\S*/)?(\S+)"), "reading {}"),
    (
        re.compile(r"\s*(?:Preparing|Building|Getting requirements).* (?:wheel|metadata)"),
        "building",
    ),
    (re.compile(r"Installing collected packages: (.+)"), "unpacking {} packages"),
)


class Status:
    """A line on a terminal that says what is going on; elsewhere nothing until the end."""

    def __init__(self) -> None:
        self.doing = "starting pip"
        self._started = time.monotonic()
        self._terminal = sys.stderr.isatty()
        self._ended = threading.Event()
        self._clock = threading.Thread(target=self._tick, daemon=True)
        self._clock.start()

    @property
    def seconds(self) -> int:
        return round(time.monotonic() - self._started)

    def end(self, text: str) -> None:
        self._ended.set()
        self._clock.join()
        self._write(text)

    def _tick(self) -> None:
        while True:
            if self._terminal:
                self._write(f"installing, {self.seconds} s: {self.doing}"[:WIDTH])
            if self._ended.wait(1.0):
                return

    def _write(self, text: str) -> None:
        print(("\r\x1b[K" if self._terminal else "") + text, end="", file=sys.stderr, flush=True)


def step(line: str) -> str | None:
    """What a line of pip's output says that it is doing; None for all that need not be known."""
    for pattern, words in STEPS:
        if found := pattern.match(line):
            what = found[1] if found.groups() else ""
            return words.format(what.count(",") + 1 if "packages" in words else what)
    return None


def main(arguments: Sequence[str]) -> int:
    """Install; pip's own exit code."""
    print(
        "installing packages (the first time takes minutes, for torch above all)", file=sys.stderr
    )
    status = Status()
    said: deque[str] = deque(maxlen=LINES)
    command = [sys.executable, *PIP, *arguments]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
    ) as pip:
        assert pip.stdout is not None
        try:
            for line in pip.stdout:
                status.doing = step(line) or status.doing
                said.append(line)
        except KeyboardInterrupt:  # pip, in the same terminal, has heard it, too
            status.end("interrupted; the same command goes on\n")
            return 130
    if pip.returncode:
        status.end("".join(said))
    else:
        installed = [line for line in said if line.startswith("Successfully installed")]
        count = len(installed[-1].split()) - 2 if installed else 0
        status.end(f"installed {count} packages in {status.seconds} s\n")
    return pip.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
