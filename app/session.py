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
from typing import Literal

import numpy as np
import viser

from ..robot.description import Robot
from . import intents as do
from .compute import Computations
from .screen import Screen
from .stage import project
from .state import AppState, ModelFacts
from .statecode import encode
from .transitions import opening_work
from .update import update
from .worker import Lane

FRAME_SECONDS = 1 / 30
log = logging.getLogger(__name__)


class Session:
    """The life of one browser on the server.

    Args:
        state: what to open with.
        keep: gets every state that came to rest, so that a reload finds it again.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        facts: tuple[ModelFacts, ...],
        computations: Computations,
        robot: Robot,
        state: AppState,
        keep: Callable[[AppState], None],
    ) -> None:
        self.state = state
        self._client, self._facts, self._keep = client, facts, keep
        self._queue: queue.SimpleQueue[do.Intent | None] = queue.SimpleQueue()
        self._idle = threading.Condition()
        self._screen: Screen | None = None
        self._shown: AppState | None = None  # the last state that is on the screen
        self._motions = Lane("motions", computations.generate, self.send, _failure)
        self._landscapes = Lane("landscapes", computations.landscape, self.send, _failure)
        self._recognitions = Lane("recognitions", computations.recognise, self.send, _failure)
        self._exports = Lane("exports", computations.export, self.send, _failure)
        self._lanes = (self._motions, self._landscapes, self._recognitions, self._exports)
        self._robot = robot
        self._closed = False
        self._thread = threading.Thread(
            target=self._run, name=f"session-{client.client_id}", daemon=True
        )
        self._thread.start()

    def send(self, intent: do.Intent) -> None:
        """Hand in an intent; from any thread, returns at once."""
        self._queue.put(intent)

    def close(self) -> None:
        """End the loop and all work; called when the browser has gone."""
        self._closed = True
        self._queue.put(None)
        for lane in self._lanes:
            lane.close(timeout=5.0)
        self._keep(self.state)

    def wait_for(self, condition: Callable[[AppState], bool], timeout: float) -> bool:
        """Wait until a state that fulfils the condition was shown; for tests and screenshots."""
        with self._idle:
            return self._idle.wait_for(
                lambda: self._shown is not None and condition(self._shown), timeout
            )

    def screen_position(self, name: str) -> tuple[float, float]:
        """Pixels, from the 3D view's top left corner, of `puck-map` or `puck-landscape`."""
        if self._screen is None:
            raise RuntimeError("the screen is not built yet")
        boards = {
            "puck-map": self._screen.map_board.board,
            "puck-landscape": self._screen.landscape_board.board,
        }
        return self.project(np.asarray(boards[name].puck))

    def project(self, point: np.ndarray) -> tuple[float, float]:
        """Pixels, from the 3D view's top left corner, of a point of the scene."""
        camera = self._client.camera
        return project(
            point,
            camera.position,
            camera.wxyz,
            camera.fov,
            camera.image_width,
            camera.image_height,
        )

    # --- the loop ---
    def _run(self) -> None:
        try:
            self._screen = Screen(
                self._client,
                self._facts,
                self._robot,
                self.state,
                self.send,
                lambda: encode(self._facts, self.state),
            )
            self.state, works = opening_work(self._facts, self.state)
            self._submit(works)
            self._loop()
        except Exception:  # the thread's boundary: an error here must not pass unseen
            if not self._closed:
                log.exception("the session of browser %s broke off", self._client.client_id)

    def _loop(self) -> None:
        assert self._screen is not None
        last = time.monotonic()
        while not self._closed:
            intents = self._drain(last + FRAME_SECONDS - time.monotonic())
            now = time.monotonic()
            intents.append(do.Tick(now - last))
            last = now
            for intent in intents:
                self.state, works = update(self._facts, self.state, intent)
                self._submit(works)
            self._screen.show(self.state)
            self._keep(self.state)
            with self._idle:
                self._shown = self.state
                self._idle.notify_all()

    def _drain(self, wait: float) -> list[do.Intent]:
        """All waiting intents; when there are none, waits for the first until the next frame."""
        intents: list[do.Intent] = []
        try:
            intent = self._queue.get(timeout=max(wait, 0.001))
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
