"""A page that others follow: they show its document until they let go.

Who presents has a key, which never leaves its tab and this server; the link that others get holds a
code that follows from it, so that nobody who follows can present in its place. Both come with a
page's first word: after a reload, or on a server that was started again, all find each other.
"""

from __future__ import annotations

import base64
import hashlib
import secrets
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

from msgspec.structs import replace

from ..state import intents as do
from ..state.document import Document, Seen
from . import asked
from .shown import PresenceShown

CODE_LENGTH = 12
SECONDS_A_FOLLOWER = 0.01  # between two documents that are shown to all
# What a person does that the one who presents has not done.
OWN_WAY = (
    do.DocumentIntent
    | do.LibraryIntent
    | do.HistoryIntent
    | asked.MoveOnMap
    | asked.MoveOnLandscape
    | asked.SelectMotion
    | asked.SelectAdded
    | asked.WalkTo
    | asked.SetJoint
    | asked.SetObserved
    | asked.Undo
    | asked.Redo
)
NOT_ONES_OWN = do.PlaybackIntent | do.Look | do.ResetView


@dataclass(frozen=True, eq=False)
class Presented:
    """What is presented has changed; None: nothing is, for now."""

    document: Document | None


@dataclass(frozen=True)
class Audience:
    """How many pages follow; None: another page presents with this key now."""

    followers: int | None


Word: TypeAlias = Presented | Audience
Tell: TypeAlias = Callable[[Word], None]


@dataclass(eq=False)
class _Presentation:
    presenter: Tell | None = None
    document: Document | None = None
    followers: dict[Tell, None] = field(default_factory=dict)


def code_of(key: str) -> str:
    """What the link of a key holds."""
    digest = hashlib.sha256(key.encode()).digest()
    return base64.urlsafe_b64encode(digest).decode()[:CODE_LENGTH]


class Presentations:
    """All of a server; any thread may call. Pages are told by calls that only queue."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._by_code: dict[str, _Presentation] = {}

    def open(self, code: str, presenter: Tell) -> None:
        with self._lock:
            one = self._by_code.setdefault(code, _Presentation())
            if one.presenter not in (None, presenter):
                one.presenter(Audience(None))
            one.presenter = presenter
            presenter(Audience(len(one.followers)))

    def show(self, code: str, presenter: Tell, document: Document) -> None:
        with self._lock:
            one = self._by_code.get(code)
            if one is None or one.presenter != presenter:
                return
            one.document = document
            for follower in one.followers:
                follower(Presented(document))

    def close(self, code: str, presenter: Tell) -> None:
        """Nothing is presented until it is opened again; followers wait."""
        with self._lock:
            one = self._by_code.get(code)
            if one is None or one.presenter != presenter:
                return
            one.presenter = one.document = None
            for follower in one.followers:
                follower(Presented(None))
            self._forget(code)

    def join(self, code: str, follower: Tell) -> None:
        with self._lock:
            one = self._by_code.setdefault(code, _Presentation())
            one.followers[follower] = None
            follower(Presented(one.document))
            self._count(one)

    def leave(self, code: str, follower: Tell) -> None:
        with self._lock:
            one = self._by_code.get(code)
            if one is None or follower not in one.followers:
                return
            del one.followers[follower]
            self._count(one)
            self._forget(code)

    def _count(self, one: _Presentation) -> None:
        if one.presenter is not None:
            one.presenter(Audience(len(one.followers)))

    def _forget(self, code: str) -> None:
        one = self._by_code[code]
        if one.presenter is None and not one.followers:
            del self._by_code[code]


class Presence:
    """One page's part: it presents, follows, or neither.

    Args:
        tell: hands in what concerns this page.
    """

    def __init__(self, presentations: Presentations, tell: Tell) -> None:
        self._presentations, self._tell = presentations, tell
        self._key: str | None = None  # while this page presents
        self._code = ""  # of what it presents or follows
        self._follows = self._free = False
        self._followers = 0
        self._there = False  # somebody presents
        self._published: Document | None = None
        self._published_at = 0.0
        self._taken: Seen | None = None  # where the presenter looked last

    def greet(self, hello: asked.Hello) -> None:
        """What the tab brings: its key, or the link that it was opened with."""
        self.close()
        if hello.present is not None:
            self._open(hello.present)
        elif hello.follow is not None:
            self._code, self._follows, self._free = hello.follow, True, hello.free
            self._presentations.join(self._code, self._tell)

    def present(self, on: bool) -> None:
        if on and self._key is None:
            self.close()
            self._open(secrets.token_urlsafe(24))
        elif not on and self._key is not None:
            self.close()

    def _open(self, key: str) -> None:
        self._key, self._code, self._published = key, code_of(key), None
        self._presentations.open(self._code, self._tell)

    def follow(self, on: bool) -> None:
        """Let go, or come back to what is presented now."""
        if self._follows:
            self._free = not on
            if on:
                self._presentations.join(self._code, self._tell)  # and be told

    def own_way(self, event: object) -> None:
        """A hand on a page that follows lets go."""
        if self._follows and isinstance(event, OWN_WAY) and not isinstance(event, NOT_ONES_OWN):
            self._free = True

    def hear(self, word: Word, document: Document) -> Document:
        """The page's document after what the others did."""
        if isinstance(word, Audience):
            if word.followers is None:
                self._key, self._code = None, ""
            self._followers = word.followers or 0
            return document
        self._there = word.document is not None
        if word.document is None or not self._follows or self._free:
            return document
        # Everybody looks around on their own until the presenter does.
        seen = document.seen if word.document.seen == self._taken else word.document.seen
        self._taken = word.document.seen
        return replace(word.document, seen=seen)

    def publish(self, document: Document, now: float, *, settled: bool) -> None:
        """Show others what is here now, though not every step of a drag: it would cost the hand
        that drags. The last one is shown once all is settled.
        """
        if self._key is None or document is self._published:
            return
        if now - self._published_at < SECONDS_A_FOLLOWER * self._followers and not settled:
            return
        self._published, self._published_at = document, now
        self._presentations.show(self._code, self._tell, document)

    @property
    def shown(self) -> PresenceShown:
        role = "presents" if self._key is not None else "follows" if self._follows else ""
        return PresenceShown(
            role, self._key, self._code, self._followers, there=self._there, free=self._free
        )

    def close(self) -> None:
        if self._key is not None:
            self._presentations.close(self._code, self._tell)
        if self._follows:
            self._presentations.leave(self._code, self._tell)
        self._key, self._code, self._follows = None, "", False
        self._followers, self._there = 0, False
