"""One page: its document, what is computed of it, and the loop that brings them on the screen.

    a hand -> intent -> update -> document -> wanted -> engine -> result -> picture -> screen

Only this loop's thread makes documents and writes handles. Everyone else hands in events.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable, Mapping
from typing import TypeAlias

import viser
from msgspec.structs import replace

from ...core.errors import InputError
from ...robot.description import Robot
from ..engine.engine import Delivered, Engine, Failed
from ..state import intents as do
from ..state.computed import Computed, Entry
from ..state.document import Document, ExportOptions
from ..state.facts import Facts
from ..state.history import History, gesture_of
from ..state.lessons import Lesson
from ..state.on_models import close_model, open_model
from ..state.on_recognition import advance, break_off, follow
from ..state.opening import check_fits
from ..state.picture import Picture
from ..state.results import ExportedFile
from ..state.statecode import MAX_LINE, encode, unpacked
from ..state.update import update
from ..state.wanted import export_work, take_away_work, wanted
from ..state.work import ExportWork, Slot, TakeAwayWork, Work
from . import asked
from .bridge import Bridge
from .hand import intent_of
from .lessons import at_step
from .library import Library
from .panels.bound import HELD_SECONDS
from .presenting import Audience, Presence, Presentations, Presented
from .screen import Screen
from .uploads import CODE_SUFFIX

# After the last event all is written that was held back: widgets that a person holds, the tab's
# document.
SETTLE_SECONDS = HELD_SECONDS + 0.1
KEEP_SECONDS = 0.25  # at least, between two documents that the tab gets
SLOW_SECONDS = 0.4  # from one iteration of a slow run to the next
PHONE_WIDTH = 576  # pixels, of a page; viser's own breakpoint
AS_IT_IS = ExportOptions("csv", beyond_limits=True)
STOPPED = "The page met a fault and stopped. Reload it to go on."
NOT_KEPT = "This upload is too long for the tab to keep: after a reload it has to be chosen again"
Event: TypeAlias = do.Intent | Delivered | Failed | Presented | Audience | asked.AnyAsked
log = logging.getLogger(__name__)


class Session:
    """The life of one page on the server.

    Args:
        opening: what to begin with, where the tab brings no document.
        ended: called when the page has met a fault and takes nothing any more.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        library: Library,
        lessons: Mapping[str, Lesson],
        presentations: Presentations,
        engine: Engine,
        robot: Robot,
        opening: Document,
        ended: Callable[[], None],
    ) -> None:
        self._client, self._library, self._robot = client, library, robot
        self._lessons, self._ended = lessons, ended
        self._history = History(opening)
        self._computed = Computed.nothing()
        self._export: ExportWork | TakeAwayWork | None = None  # the last file that was asked for
        self._paced = (-1, 0.0)  # iterations of a slow run, and when the next one is due
        self._events: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._settled = False  # all that was held back is written
        self._greeted = False  # the page has said what its tab keeps
        self._tab: Document | None = None  # what the tab keeps
        self._tab_time = 0.0
        self._unproven = False  # the tab has just brought its document, which may lead to a fault
        self._idle = threading.Condition()
        self._shown: Picture | None = None
        self._closed = False
        self._presence = Presence(presentations, self.send)
        self._work = engine.open(self.send)
        name = f"page-{client.client_id}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def send(self, event: Event) -> None:
        """Hand in what a person or the engine says; from any thread, returns at once."""
        if not self._closed:
            self._events.put(event)

    @property
    def document(self) -> Document:
        return self._history.present

    @property
    def _facts(self) -> Facts:
        return self._library.facts(choice.name for choice in self.document.models)

    def close(self) -> None:
        """End the loop and all work, without waiting; called when the browser has gone."""
        self._closed = True
        self._presence.close()
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
        while True:
            self._ask()
            self._show(screen)
            for event in self._next_events():
                self._presence.own_way(event)
                try:
                    self._apply(event, screen, time.monotonic())
                    self._follow_run()
                except InputError as error:
                    screen.say(str(error))
                if isinstance(event, Delivered | Failed):
                    self._ask()  # what was answered and is wanted again later is asked for anew
            if self._closed:
                return

    def _apply(self, event: Event, screen: Screen, now: float) -> None:
        """What an event makes of the document, of the history, or of what is computed."""
        match event:
            case Delivered():
                self._deliver(event, screen)
            case Failed(slot, work, message):
                self._fail(slot, work, message, screen)
            case asked.Hello():
                self._greet(event, screen)
            case asked.Resized():
                screen.resized(event.width, event.height, event.page_width)
            case asked.Looked():
                self._look(event, screen)
            case asked.Present(on):
                self._presence.present(on)
            case do.PresentPage():
                self._presence.present(True)
            case asked.Follow(on):
                self._presence.follow(on)
            case Presented() | Audience():
                self._history = self._history.revise(self._presence.hear(event, self.document))
            case asked.Broken():
                screen.say(event.reason)
            case asked.Asked():
                self._apply_hand(event, screen, now)
            case do.Undo():
                self._go(self._history.undo(), "Nothing to undo", screen)
            case do.Redo():
                self._go(self._history.redo(), "Nothing to redo", screen)
            case do.RestoreCode(code):
                self._history = self._history.step(self._decode(code), "", now)
            case do.OpenModel(name, beside):
                (newcomer,) = self._library.facts([name])
                after = open_model(self._facts, self.document, newcomer, beside=beside)
                self._history = self._history.step(after, "", now)
            case do.CloseModel():
                self._history = self._history.step(close_model(self._facts, self.document), "", now)
            case do.GoToStep():
                after = at_step(self._lessons, self._library, self._robot, self.document, event)
                self._history = self._history.step(after, "", now)
            case do.ExportMotion():
                self._ask_for_file(self.document.export)
            case do.DownloadMotion():
                self._ask_for_file(AS_IT_IS)
            case do.TakeAwayRun(what):
                self._export = take_away_work(self._facts, self.document, self._picture.trace, what)
                self._computed = self._computed.without(("export", 0))
            case do.ShowCode():
                self._show_code(screen)
            case do.ShowFile():
                screen.show_file(event)
            case do.Say(text, good):
                screen.say(text, good=good)
            case _:
                after = update(self._facts, self.document, event)
                self._history = self._history.step(after, gesture_of(event), now)
                if event == do.StartRecognition() and after.recognition.method == "live":
                    screen.played = None  # the page goes back to the first frame

    def _ask(self) -> None:
        """Have the engine do what is missing, and nothing else."""
        works = self._wanted()
        self._computed = self._computed.keep(works)
        self._work.want(self._computed.missing(works))

    def _wanted(self) -> dict[Slot, Work]:
        works = wanted(self._facts, self.document, self._computed)
        if self._export is not None:
            works["export", 0] = self._export
        return works

    # --- the browser's own part ---
    def _greet(self, hello: asked.Hello, screen: Screen) -> None:
        """The page is there, for the first time or again; it may bring what it showed before."""
        self._greeted = True
        self._presence.greet(hello)
        screen.resized(hello.width, hello.height, hello.page_width)
        if hello.page_width <= PHONE_WIDTH:
            screen.fold()
        if hello.document:
            # What cannot be shown here (of other models, say) stays with the tab until somebody
            # goes on with something else.
            self._tab = self.document
            self._tab = self._decode(hello.document)
            self._history, self._unproven = History(self._tab), True
        if hello.playback is not None:  # it went on playing while there was no server
            for intent in (
                do.SetSpeed(hello.playback.speed),
                do.SetLoop(hello.playback.loop),
                do.SetPlaying(hello.playback.playing, hello.playback.frame),
            ):
                after = update(self._facts, self.document, intent)
                self._history = self._history.revise(after)
            screen.played = self.document.playback

    def _apply_hand(self, word: asked.ByHand, screen: Screen, now: float) -> None:
        """A hand on a board or on the time bar; the page shows what it did there already."""
        self._apply(intent_of(word, self._picture), screen, now)
        if isinstance(word, asked.MoveOnMap | asked.MoveOnLandscape):
            screen.heard = word.number
        if isinstance(word, asked.SetPlaying | asked.Seek | asked.SetSpeed | asked.SetLoop):
            screen.played = self.document.playback

    def _look(self, word: asked.Looked, screen: Screen) -> None:
        """A person looks elsewhere; the page shows that already."""
        seen = screen.looked(word, self.document.seen)
        self._history = self._history.revise(update(self._facts, self.document, do.Look(seen)))

    # --- results ---
    def _deliver(self, event: Delivered, screen: Screen) -> None:
        self._computed = self._computed.put(
            self._wanted(), event.slot, Entry(event.work, event.result, event.done)
        )
        file = event.result
        if isinstance(file, ExportedFile) and event.work == self._export:
            self._client.send_file_download(file.file_name, file.content, save_immediately=True)
            screen.say(file.summary, good=True)

    def _follow_run(self) -> None:
        """Have the latent where a recognition has brought it."""
        trace = self._picture.whole_trace
        if trace is not None:
            self._history = self._history.revise(follow(self._facts, self.document, trace))

    def _pace(self, now: float) -> float | None:
        """Take a slow run one iteration further when it is time; seconds until that is."""
        run = self.document.run
        if run is None or run.settled or run.paused or not run.settings.slow:
            return None
        if run.done != self._paced[0]:
            self._paced = run.done, now + SLOW_SECONDS
        left = self._paced[1] - now
        if left <= 0 and run.until == run.done:
            self._history = self._history.revise(advance(self.document))
            self._follow_run()
            return 0.0
        return max(left, 0.0) if run.until == run.done else None

    def _ask_for_file(self, options: ExportOptions) -> None:
        """Of the motion that is on the screen now; once more, where it was written before."""
        self._export = export_work(self._facts, self.document, options)
        self._computed = self._computed.without(("export", 0))

    def _fail(self, slot: Slot, work: Work, message: str, screen: Screen) -> None:
        if self._wanted().get(slot) != work:
            return
        self._computed = self._computed.fail(slot, work, message)
        if slot[0] == "recognition":
            self._history = self._history.revise(break_off(self._facts, self.document))
        if slot[0] == "export":
            self._export = None
        screen.say(message)

    # --- history and codes ---
    def _go(self, to: History, otherwise: str, screen: Screen) -> None:
        if to is self._history:
            screen.say(otherwise, good=True)
        self._history = to

    def _decode(self, code: str) -> Document:
        """The document of a code; its models are loaded where they are not yet."""
        document = unpacked(code)
        check_fits(self._library.facts(choice.name for choice in document.models), document)
        return document

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
        screen.show_presence(self._presence.shown)
        now = time.monotonic()
        self._presence.publish(self.document, now, settled=self._settled)
        self._keep(screen, now)
        with self._idle:
            self._shown = picture
            self._idle.notify_all()

    def _keep(self, screen: Screen, now: float) -> None:
        """Have the tab keep what was just shown, though not at every step of a drag."""
        document = self.document
        if (
            not self._greeted
            or document == self._tab
            or (now - self._tab_time < KEEP_SECONDS and not self._settled)
        ):
            return
        code = encode(document)
        if len(code) > asked.MAX_DOCUMENT:
            code = encode(replace(document, target=None, run=None))
            if self._tab is None or document.target != self._tab.target:
                screen.say(NOT_KEPT, good=True)
        screen.keep(code)
        self._tab, self._tab_time = document, now

    def _next_events(self) -> list[Event]:
        """All waiting events; none, once, when they have rested for a moment or a run goes on."""
        events: list[Event] = []
        timeout = None if self._settled else SETTLE_SECONDS
        wait = self._pace(time.monotonic())
        if wait is not None:
            timeout = wait if timeout is None else min(wait, timeout)
        try:
            event = self._events.get(timeout=timeout)
            while True:
                if event is not None:
                    events.append(event)
                event = self._events.get_nowait()
        except queue.Empty:
            self._settled = not events
            self._unproven &= bool(events)
            return events

    # --- beginning and end ---
    def _run(self) -> None:
        screen = None
        try:
            bridge = Bridge(self._client, self.send)
            screen = Screen(
                self._client,
                bridge,
                self._robot,
                self._facts,
                self._library.offers(),
                self._lessons,
                self.send,
            )
            self._loop(screen)
        except Exception:  # the thread's boundary: an error here must not pass unseen
            if not self._closed:
                log.exception("the page of browser %s broke off", self._client.client_id)
                self._break_off(screen)
        finally:
            self._presence.close()
            self._work.close()  # it may have been closed just before something more was wanted

    def _break_off(self, screen: Screen | None) -> None:
        """Stop, and say so. What the tab keeps is what was shown before the fault.

        Where that led to the fault by itself, the tab keeps nothing, and a reload begins anew.
        """
        if screen is not None and self._unproven:
            screen.keep("")
        self.close()
        self._ended()
        self._client.add_notification("That did not work", STOPPED, color="red")
