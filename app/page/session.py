"""One page: its document, what is computed of it, and the loop that brings them on the screen.

    a hand -> intent -> update -> document -> wanted -> engine -> result -> picture -> screen

Only this loop's thread makes documents and writes handles. Everyone else hands in events.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import viser

from ...core.errors import InputError
from ...robot.description import Robot
from ..engine.engine import Delivered, Engine, Failed
from ..state import intents as do
from ..state.computed import Computed, Entry
from ..state.document import Document, ExportOptions
from ..state.facts import Facts
from ..state.history import History, gesture_of
from ..state.on_latent import end_run
from ..state.on_recognition import follow
from ..state.picture import Picture
from ..state.results import ExportedFile
from ..state.statecode import MAX_LINE, decode, encode
from ..state.update import update
from ..state.wanted import export_work, wanted
from ..state.work import ExportWork, Slot, Work
from .boards.board import REDRAW_SECONDS
from .panels.bound import HELD_SECONDS
from .screen import Screen
from .uploads import CODE_SUFFIX

FRAME_SECONDS = 1 / 30
# Widgets that a person holds and boards that are drawn now and then are written late; this long
# after the last event all is written.
SETTLE_SECONDS = max(HELD_SECONDS, REDRAW_SECONDS) + 0.1
AS_IT_IS = ExportOptions("csv", beyond_limits=True)
MOST_FAULTS = 2  # pages in a row that stopped on one document; then it is given up
STOPPED = "The page met a fault and stopped. Reload it to go on."
LOST = "What was on the screen cannot be shown any more; this is the opening screen."
Event = do.Intent | Delivered | Failed
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Kept:
    """The last document that a page had on its screen, and how many pages in a row it broke."""

    document: Document
    faults: int = 0


class Session:
    """The life of one page on the server.

    Args:
        browser: a name that all pages of a browser share.
        opening: what to open with where there is nothing else that can be shown.
        ended: called when the page has met a fault and takes nothing any more.
        kept: what the page had on its screen before.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        browser: str,
        facts: Facts,
        engine: Engine,
        robot: Robot,
        opening: Document,
        ended: Callable[[], None],
        kept: Kept | None = None,
    ) -> None:
        self.browser = browser
        self._client, self._facts, self._robot = client, facts, robot
        self._opening, self._ended, self._kept = opening, ended, kept
        self._faults = 0 if kept is None else kept.faults
        self._history = History(opening if kept is None else kept.document)
        self._computed = Computed.nothing()
        self._export: ExportWork | None = None  # the last file that was asked for
        self._events: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._idle = threading.Condition()
        self._shown: Picture | None = None
        self._closed = False
        self._work = engine.open(self.send)
        name = f"page-{client.client_id}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def send(self, event: Event) -> None:
        """Hand in what a person or the engine says; from any thread, returns at once."""
        if not self._closed:
            self._events.put(event)

    @property
    def kept(self) -> Kept | None:
        """What a reload brings back; None where nothing could be shown."""
        return self._kept

    @property
    def document(self) -> Document:
        return self._history.present

    def close(self) -> None:
        """End the loop and all work, without waiting; called when the browser has gone."""
        self._closed = True
        self._events.put(None)
        self._work.close()

    def join(self, timeout: float) -> None:
        """Wait until a closed session's thread has ended, at most `timeout` seconds."""
        self._thread.join(timeout)

    def wait_for(self, condition: Callable[[Picture], bool], timeout: float) -> bool:
        """Wait until a picture that fulfils the condition was shown; for tests and screenshots."""
        with self._idle:
            return self._idle.wait_for(
                lambda: self._shown is not None and condition(self._shown), timeout
            )

    # --- the program, from a hand to the screen ---
    def _loop(self, screen: Screen) -> None:
        last = changed = time.monotonic()
        while True:
            rests = last - changed > SETTLE_SECONDS
            events = self._next_events(None if rests else last + FRAME_SECONDS - time.monotonic())
            if self._closed:
                return
            now = time.monotonic()
            before = self.document
            for event in events:
                try:
                    self._apply(event, screen, now)
                    self._follow_run()
                except InputError as error:
                    screen.say(str(error))
                if isinstance(event, Delivered | Failed):
                    self._ask()  # what was answered and is wanted again later is asked for anew
            # Time at rest is not the motion's: one that is played then begins where it stands.
            self._apply(do.Tick(0.0 if rests else now - last), screen, now)
            if events or self.document != before:
                changed = now
            last = now
            self._ask()
            self._show(screen)

    def _apply(self, event: Event, screen: Screen, now: float) -> None:
        """What an event makes of the document, of the history, or of what is computed."""
        match event:
            case Delivered():
                self._deliver(event, screen)
            case Failed(slot, work, message):
                self._fail(slot, work, message, screen)
            case do.Undo():
                self._go(self._history.undo(), "Nothing to undo", screen)
            case do.Redo():
                self._go(self._history.redo(), "Nothing to redo", screen)
            case do.RestoreCode(code):
                self._history = self._history.step(decode(self._facts, code), "", now)
            case do.ExportMotion():
                self._ask_for_file(self.document.export)
            case do.DownloadMotion():
                self._ask_for_file(AS_IT_IS)
            case do.ShowCode():
                self._show_code(screen)
            case do.ResetView():
                screen.reset_view()
            case do.Say(text, good):
                screen.say(text, good=good)
            case _:
                after = update(self._facts, self.document, event)
                self._history = self._history.step(after, gesture_of(event), now)

    def _ask(self) -> None:
        """Have the engine do what is missing, and nothing else."""
        works = self._wanted()
        self._computed = self._computed.keep(works)
        self._work.want(self._computed.missing(works))

    def _wanted(self) -> dict[Slot, Work]:
        works = wanted(self._facts, self.document)
        if self._export is not None:
            works["export", 0] = self._export
        return works

    # --- results ---
    def _deliver(self, event: Delivered, screen: Screen) -> None:
        self._computed = self._computed.put(
            self._wanted(), event.slot, Entry(event.work, event.result, event.done)
        )
        file = event.result
        if isinstance(file, ExportedFile) and event.work == self._export:
            self._client.send_file_download(
                file.file_name, file.content.encode(), save_immediately=True
            )
            screen.say(file.summary, good=True)

    def _follow_run(self) -> None:
        """Have the latent where a recognition has brought it."""
        trace = self._picture.trace
        if trace is not None:
            self._history = self._history.revise(follow(self._facts, self.document, trace))

    def _ask_for_file(self, options: ExportOptions) -> None:
        """Of the motion that is on the screen now; once more, where it was written before."""
        self._export = export_work(self._facts, self.document, options)
        self._computed = self._computed.without(("export", 0))

    def _fail(self, slot: Slot, work: Work, message: str, screen: Screen) -> None:
        if self._wanted().get(slot) != work:
            return
        self._computed = self._computed.fail(slot, work, message)
        if slot[0] == "recognition":
            self._history = self._history.revise(end_run(self.document))
        if slot[0] == "export":
            self._export = None
        screen.say(message)

    # --- history and codes ---
    def _go(self, to: History, otherwise: str, screen: Screen) -> None:
        if to is self._history:
            screen.say(otherwise, good=True)
        self._history = to

    def _show_code(self, screen: Screen) -> None:
        code = encode(self.document)
        if len(code) <= MAX_LINE:
            screen.show_code(code)
            return
        self._client.send_file_download(
            f"screen{CODE_SUFFIX}", code.encode(), save_immediately=True
        )
        screen.say(
            "The upload makes this code too long for a line; it was saved as a file", good=True
        )

    # --- the screen ---
    @property
    def _picture(self) -> Picture:
        return Picture(self._facts, self.document, self._computed)

    def _show(self, screen: Screen) -> None:
        picture = self._picture
        screen.show(picture)
        self._kept = Kept(self.document)
        with self._idle:
            self._shown = picture
            self._idle.notify_all()

    def _next_events(self, wait: float | None) -> list[Event]:
        """All waiting events; when there are none, waits for the first, `wait` seconds at most."""
        events: list[Event] = []
        try:
            event = self._events.get(timeout=None if wait is None else max(wait, 0.001))
            while True:
                if event is not None:
                    events.append(event)
                event = self._events.get_nowait()
        except queue.Empty:
            return events

    # --- beginning and end ---
    def _run(self) -> None:
        try:
            self._loop(self._open())
        except Exception:  # the thread's boundary: an error here must not pass unseen
            if not self._closed:
                log.exception("the page of browser %s broke off", self._client.client_id)
                self._break_off()
        finally:
            self._work.close()  # it may have been closed just before something more was wanted

    def _open(self) -> Screen:
        """Show what the page had on its screen; the opening screen where that cannot be."""
        if self._kept is None:
            return self._begin()
        if self._faults < MOST_FAULTS:
            try:
                return self._begin()
            except Exception:
                if self._closed:
                    raise
                log.exception("browser %s: the kept screen is lost", self._client.client_id)
        self._kept, self._faults = None, 0
        self._history = History(self._opening)
        self._client.gui.reset()  # whatever of the screen was built
        self._client.scene.reset()
        screen = self._begin()
        screen.say(LOST)
        return screen

    def _begin(self) -> Screen:
        screen = Screen(self._client, self._robot, self._picture, self.send)
        self._show(screen)
        return screen

    def _break_off(self) -> None:
        """Stop, and say so. What was shown before the fault is kept, what led to it is not."""
        if self._kept is not None:
            self._kept = Kept(self._kept.document, self._faults + 1)
        self.close()
        self._ended()
        self._client.add_notification("That did not work", STOPPED, color="red")
