"""One browser: its state, its queue of intents, its worker, and the loop that brings them together.

    widget or board -> intent -> queue -> update -> work -> lane -> intent -> queue -> ... -> screen

Only this loop's thread makes new states and writes handles. Everyone else hands in intents.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import viser

from ...robot.description import Robot
from ..engine.compute import Computations
from ..engine.worker import Lane
from ..state import intents as do
from ..state.document import AppState, ModelFacts
from ..state.statecode import encode
from ..state.transitions import notify, opening_work, stop_recognition
from ..state.update import update
from .boards.board import REDRAW_SECONDS
from .panels.bound import HELD_SECONDS
from .screen import Screen

FRAME_SECONDS = 1 / 30
# Widgets that a person holds and boards that are drawn now and then are written late; this long
# after the last change all is written.
SETTLE_SECONDS = max(HELD_SECONDS, REDRAW_SECONDS) + 0.1
MOST_FAULTS = 2  # pages in a row that stopped on one screen; then it is given up
STOPPED = "The page met a fault and stopped. Reload it to go on."
LOST = "What was on the screen cannot be shown any more; this is the opening screen."
log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Kept:
    """The last state that a page had on its screen, and how many pages in a row it broke."""

    state: AppState
    faults: int = 0


class Session:
    """The life of one page on the server.

    Args:
        browser: a name that all pages of a browser share.
        opening: what to open with where there is nothing else that can be shown.
        kept: what the page had on its screen before.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        browser: str,
        facts: tuple[ModelFacts, ...],
        computations: Computations,
        robot: Robot,
        opening: AppState,
        kept: Kept | None = None,
    ) -> None:
        self.browser = browser
        self.state = opening if kept is None else kept.state
        self._client, self._facts, self._robot = client, facts, robot
        self._opening, self._kept = opening, kept
        self._faults = 0 if kept is None else kept.faults
        self._queue: queue.SimpleQueue[do.Intent | None] = queue.SimpleQueue()
        self._idle = threading.Condition()
        self._screen: Screen | None = None
        self._shown: AppState | None = None  # the last state that is on the screen
        name = f"session-{client.client_id}"
        self._motions = Lane(f"{name} motions", computations.generate, self.send, _failure)
        self._landscapes = Lane(f"{name} landscapes", computations.landscape, self.send, _failure)
        self._recognitions = Lane(
            f"{name} recognitions", computations.recognise, self.send, _failure
        )
        self._exports = Lane(f"{name} exports", computations.export, self.send, _failure)
        self._lanes = (self._motions, self._landscapes, self._recognitions, self._exports)
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def send(self, intent: do.Intent) -> None:
        """Hand in an intent; from any thread, returns at once."""
        self._queue.put(intent)

    @property
    def kept(self) -> Kept | None:
        """What a reload brings back; None where nothing could be shown."""
        return self._kept

    def close(self) -> None:
        """End the loop and all work, without waiting; called when the browser has gone."""
        self._closed = True
        self._queue.put(None)
        for lane in self._lanes:
            lane.close()

    def join(self, timeout: float) -> None:
        """Wait until a closed session's threads have ended, at most `timeout` seconds."""
        deadline = time.monotonic() + timeout
        for thread in (self._thread, *self._lanes):
            thread.join(max(deadline - time.monotonic(), 0.0))

    def wait_for(self, condition: Callable[[AppState], bool], timeout: float) -> bool:
        """Wait until a state that fulfils the condition was shown; for tests and screenshots."""
        with self._idle:
            return self._idle.wait_for(
                lambda: self._shown is not None and condition(self._shown), timeout
            )

    # --- the loop ---
    def _run(self) -> None:
        try:
            self._open()
            self._loop()
        except Exception:  # the thread's boundary: an error here must not pass unseen
            if not self._closed:
                log.exception("the session of browser %s broke off", self._client.client_id)
                self._break_off()

    def _open(self) -> None:
        """Show what the page had on its screen; the opening screen where that cannot be."""
        if self._kept is None:
            self._begin(self._opening)
            return
        if self._faults < MOST_FAULTS:
            try:
                self._begin(self._kept.state)
                return
            except Exception:
                if self._closed:
                    raise
                log.exception("browser %s: the kept screen is lost", self._client.client_id)
        self._kept, self._faults = None, 0
        self._client.gui.reset()  # whatever of the screen was built
        self._client.scene.reset()
        self._begin(self._opening, LOST)

    def _begin(self, state: AppState, notice: str = "") -> None:
        self.state = stop_recognition(state)[0]  # its worker went with the page before
        self._screen = Screen(
            self._client,
            self._facts,
            self._robot,
            self.state,
            self.send,
            lambda: encode(self._facts, self.state),
        )
        if notice:
            self.state = notify(self.state, notice)
        self.state, works = opening_work(self._facts, self.state)
        self._show(self._screen)
        self._submit(works)

    def _break_off(self) -> None:
        """Stop, and say so. What was shown before the fault is kept, what led to it is not."""
        if self._kept is not None:
            self._kept = Kept(self._kept.state, self._faults + 1)
        for lane in self._lanes:
            lane.close()
        self._client.add_notification("That did not work", STOPPED, color="red")

    def _loop(self) -> None:
        assert self._screen is not None
        last = changed = time.monotonic()
        while not self._closed:
            rests = last - changed > SETTLE_SECONDS
            intents = self._drain(None if rests else last + FRAME_SECONDS - time.monotonic())
            now = time.monotonic()
            # Time at rest is not the motion's: one that is played then begins where it stands.
            tick = do.Tick(0.0 if rests else now - last)
            before, last = self.state, now
            for intent in (*intents, tick):
                self.state, works = update(self._facts, self.state, intent)
                self._submit(works)
            if intents or self.state is not before:
                changed = now
            self._show(self._screen)

    def _show(self, screen: Screen) -> None:
        screen.show(self.state)
        self._kept = Kept(self.state)
        with self._idle:
            self._shown = self.state
            self._idle.notify_all()

    def _drain(self, wait: float | None) -> list[do.Intent]:
        """All waiting intents; when there are none, waits for the first, `wait` seconds at most."""
        intents: list[do.Intent] = []
        try:
            intent = self._queue.get(timeout=None if wait is None else max(wait, 0.001))
            while True:
                if intent is not None:
                    intents.append(intent)
                intent = self._queue.get_nowait()
        except queue.Empty:
            return intents

    def _submit(self, works: tuple[do.Work, ...]) -> None:
        for work in works:
            match work:
                case do.GenerateWork():
                    self._motions.submit(work, key=work.model)
                case do.LandscapeWork():
                    self._landscapes.submit(work, key=work.model)
                case do.RecogniseWork():
                    self._recognitions.submit(work)
                case do.CancelRecogniseWork():
                    self._recognitions.cancel()
                case do.ExportWork():
                    self._exports.submit(work)
                case do.SendFile():
                    self._client.send_file_download(
                        work.file_name, work.content.encode(), save_immediately=True
                    )


_KINDS: dict[type, Literal["motion", "landscape", "recognition", "export"]] = {
    do.GenerateWork: "motion",
    do.LandscapeWork: "landscape",
    do.RecogniseWork: "recognition",
    do.ExportWork: "export",
}


def _failure(
    work: do.GenerateWork | do.LandscapeWork | do.RecogniseWork | do.ExportWork, message: str
) -> do.Intent:
    return do.WorkFailed(_KINDS[type(work)], work.request, message)
