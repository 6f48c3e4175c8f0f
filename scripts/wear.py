"""Does a server wear out? Pages that come and go, or one that is used for hours in fast motion.

    python scripts/wear.py pages 10000
    python scripts/wear.py use 7200

`pages N` opens N pages one after the other, each until its screen is complete, and closes them.
`use SECONDS` does what a person does in so many seconds, as fast as the server answers. A warm-up
comes first: some pages, or half of the time, in which codebooks and the cache of results get as
large as they may. At the end memory, threads and file handles of the server's process may not have
grown. Linux alone says them (/proc).
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tests" / "unit")]

from wire_browser import WireBrowser  # noqa: E402  (beside the tests, which are no package)

MOST_GROWTH = 50_000_000  # bytes
WARM_UP = 40  # pages
CIRCLE = [(0.3, 0.0), (0.2, 0.2), (0.0, 0.3), (-0.2, 0.2), (-0.3, 0.0), (-0.2, -0.2), (0.0, -0.3)]
WINDOWS = ("±1, as in the paper's Fig. 4", "±0.7 sd of the learned μ")
POOLED = 2  # threads that a pool may make later than others
LEAST = 0.3  # seconds of a round; faster would be a flood
ROUND_SECONDS = 30.0  # that a person takes for one round of use


@dataclass(frozen=True)
class State:
    """Of the server's process."""

    memory: int  # bytes
    threads: int
    handles: int

    @classmethod
    def of(cls, process: int) -> State:
        folder = Path(f"/proc/{process}")
        pages = int((folder / "statm").read_text().split()[1])
        count = [len(list((folder / name).iterdir())) for name in ("task", "fd")]
        return cls(pages * os.sysconf("SC_PAGESIZE"), *count)

    def __str__(self) -> str:
        return f"{self.memory / 1e6:.0f} MB, {self.threads} threads, {self.handles} handles"


def page(url: str) -> None:
    """One page comes, is complete, and goes."""
    browser = WireBrowser(url)
    browser.wait_for(lambda: browser.shown.get("LandscapeShown", {}).get("complete"))
    browser.leave()


class User:
    """A person at one page, without pauses."""

    def __init__(self, url: str) -> None:
        self._browser = WireBrowser(url)
        self._browser.wait_for(lambda: "PuckShown" in self._browser.shown)
        self._browser.wait_for_all()
        self._rounds = 0

    def round(self) -> None:
        """Half a minute of a person's time: motions, drags, sliders, noise, a recognition, undo."""
        browser, number = self._browser, self._rounds
        self._rounds += 1
        began = time.monotonic()
        browser.ask("SelectMotion", model=0, index=number % 72)
        browser.drag("map", *CIRCLE)
        browser.wait_for(lambda: browser.shown["PuckShown"]["heard"] == browser.moves)
        browser.set("μ 2", ((number % 7) - 3) / 4)
        browser.set("σ 1", (number % 5) / 4)
        for label in ("New", "None"):
            browser.set("Noise ε", label)
        browser.set("Compare with", ("deterministic", "weak", "nothing")[number % 3])
        browser.set("Way to", "Fear_1" if number % 2 else "choose …")
        browser.set("Uncertainty", bool(number % 2))
        browser.set("Example", ("slow_anger", "halfway", "wave")[number % 3])
        browser.press("Start")
        browser.set("Window", WINDOWS[number % 2])
        for _ in range(3):
            browser.ask("Undo")
        browser.ask("Looked", map=None, landscape=None, map_2=None, landscape_2=None, tab="View",
                    turned=False)  # fmt: skip
        browser.ask("SelectMotion", model=0, index=(number + 1) % 72)
        motion = browser.shown.get("MotionShown 0", {}).get("number")
        browser.ask("SetPlaying", playing=bool(number % 2), frame=3)
        browser.drag("map", (0.1, 0.1), (0.2, 0.1))
        browser.wait_for(lambda: browser.shown["MotionShown 0"]["number"] != motion)

        browser.wait_for(lambda: browser.shown["PuckShown"]["heard"] == browser.moves)
        browser.wait_for(lambda: browser.shown["LandscapeShown"]["complete"])
        time.sleep(max(LEAST - (time.monotonic() - began), 0))

    def leave(self) -> None:
        self._browser.leave()


def wear(process: int, warm_up: int, count: int, once: Callable[[], None]) -> int:
    """Do something so often, after so often to warm up; 1 where the server has grown."""
    for _ in range(warm_up):
        once()
    settle(process)
    before, started = State.of(process), time.monotonic()
    print(f"after {warm_up} to warm up: {before}", flush=True)
    for number in range(1, count + 1):
        once()
        if number % max(count // 10, 1) == 0:
            seconds = time.monotonic() - started
            print(f"{number:6} in {seconds:.0f} s: {State.of(process)}", flush=True)
    after = settle(process)
    growth = after.memory - before.memory
    worn = (
        growth > MOST_GROWTH
        or after.threads > before.threads + POOLED
        or after.handles > before.handles
    )
    print(f"{'WORN' if worn else 'as before'}: {after}, {growth / 1e6:+.1f} MB")
    return int(worn)


def settle(process: int) -> State:
    """The state once threads and handles have not fallen for a while."""
    state, since = State.of(process), time.monotonic()
    while time.monotonic() - since < 2.0:
        time.sleep(0.1)
        now = State.of(process)
        if now.threads < state.threads or now.handles < state.handles:
            since = time.monotonic()
        state = now
    return state


def main() -> int:
    parser = argparse.ArgumentParser(description="Does a server wear out?")
    parser.add_argument("what", choices=("pages", "use"))
    parser.add_argument("count", type=int, help="pages, or seconds of a person's time")
    asked = parser.parse_args()
    command = [sys.executable, "-m", "rnnpb_explorer.app.commands.explorer", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            url = server.stdout.readline().split()[-1]
            if asked.what == "pages":
                return wear(server.pid, WARM_UP, asked.count, lambda: page(url))
            user = User(url)
            half = int(asked.count / ROUND_SECONDS / 2)
            return wear(server.pid, half, half, user.round)
        finally:
            server.terminate()


if __name__ == "__main__":
    sys.exit(main())
