"""What a page asks: each comes up as one message, checked before anything else sees it.

The browser's side is `Asked` in `static/web/messages.js`, under the same names.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated

import msgspec
from msgspec import Meta

from ...core.errors import InputError
from ...core.walk import STEPS
from ..state.document import Zoom

MAX_DOCUMENT = 900_000  # characters: a state code with the longest upload in it
MAX_PAYLOAD = 2_000  # characters of everything that carries no document
FARTHEST = 1e6  # of any coordinate of a PB
PER_SECOND = 120.0  # messages; a hand makes 25, and a key held down some more
BURST = 240.0

Axis = Annotated[int, Meta(ge=0, lt=128)]
Axes = Annotated[list[Axis], Meta(min_length=1, max_length=2)]
Coordinate = Annotated[float, Meta(ge=-FARTHEST, le=FARTHEST)]
Coordinates = Annotated[list[Coordinate], Meta(min_length=1, max_length=2)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
Model = Annotated[int, Meta(ge=0, lt=100)]
Frame = Annotated[float, Meta(ge=0, le=1e6)]
Pixels = Annotated[int, Meta(ge=0, le=100_000)]
Ratio = Annotated[float, Meta(gt=0, le=20)]
Speed = Annotated[float, Meta(ge=0.05, le=20)]


class Asked(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="type"):
    """One thing that the page asks."""


class Playback(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a page plays that was there before this connection."""

    playing: bool
    frame: Frame
    speed: Speed
    loop: bool


class Hello(Asked, frozen=True, tag=True):
    """The first word on a connection; only then does a page get what is shown.

    document: what `DocumentShown` left with the tab. width, height: of the canvas in CSS pixels,
    ratio: device pixels for one. page_width, page_height: of the window. dark: what the person's
    system prefers. playback: None on a page that is new. present: the key that the tab presents
    with. follow: the code in the page's address; free: it has let go of that.
    """

    document: Annotated[str, Meta(max_length=MAX_DOCUMENT)] | None
    width: Pixels
    height: Pixels
    ratio: Ratio
    page_width: Pixels
    page_height: Pixels
    dark: bool
    playback: Playback | None
    present: Annotated[str, Meta(pattern="^[A-Za-z0-9_-]{32}$")] | None = None
    follow: Annotated[str, Meta(pattern="^[A-Za-z0-9_-]{12}$")] | None = None
    free: bool = False


class MoveOnMap(Asked, frozen=True, tag=True):
    """The puck along components of a model's map: `to` has a value for each of `axes`.

    gesture: equal from press to release. number: counts all moves of the page, for
    `PuckShown.heard`. done: the hand has let go.
    """

    model: Model
    axes: Axes
    to: Coordinates
    gesture: Count
    number: Count
    done: bool


class MoveOnLandscape(Asked, frozen=True, tag=True):
    """The puck in the landscape's own axes, whose labels are `axes`; the rest as MoveOnMap."""

    model: Model
    axes: Annotated[list[Annotated[str, Meta(max_length=20)]], Meta(min_length=1, max_length=2)]
    to: Coordinates
    gesture: Count
    number: Count
    done: bool


class SelectMotion(Asked, frozen=True, tag=True):
    model: Model
    index: Annotated[int, Meta(ge=0, lt=1_000_000)]


class SelectAdded(Asked, frozen=True, tag=True):
    """index: among the points that were added to any map."""

    index: Annotated[int, Meta(ge=0, lt=1_000)]


class WalkTo(Asked, frozen=True, tag=True):
    """step: of the way to the goal."""

    step: Annotated[int, Meta(ge=0, le=STEPS)]


class SetPlaying(Asked, frozen=True, tag=True):
    """frame: where playback was when it was started or stopped."""

    playing: bool
    frame: Frame


class Seek(Asked, frozen=True, tag=True):
    """A frame that one has gone to and rests on."""

    frame: Frame


class SetSpeed(Asked, frozen=True, tag=True):
    speed: Speed


class SetLoop(Asked, frozen=True, tag=True):
    loop: bool


class SetJoint(Asked, frozen=True, tag=True):
    """The joint whose curve is drawn; None for all."""

    joint: Annotated[int, Meta(ge=0, lt=1000)] | None


class SetObserved(Asked, frozen=True, tag=True):
    """share: of the reference motion that is observed."""

    share: Annotated[float, Meta(gt=0, le=1)]


class Looked(Asked, frozen=True, tag=True):
    """Where a person looks, after that has rested.

    map, landscape: what the boards are zoomed to. tab: of the panel, by its label. turned: whether
    a hand was on the camera; where that is now viser says itself.
    """

    map: Zoom | None
    landscape: Zoom | None
    map_2: Zoom | None
    landscape_2: Zoom | None
    tab: Annotated[str, Meta(max_length=40)]
    turned: bool


class Undo(Asked, frozen=True, tag=True):
    pass


class Redo(Asked, frozen=True, tag=True):
    pass


class Present(Asked, frozen=True, tag=True):
    """Have others follow this page, or no longer."""

    on: bool


class Follow(Asked, frozen=True, tag=True):
    """Come back to what is presented, or let go of it."""

    on: bool


class Resized(Asked, frozen=True, tag=True):
    """The canvas has another size; as Hello."""

    width: Pixels
    height: Pixels
    ratio: Ratio
    page_width: Pixels
    page_height: Pixels


class Broken(Asked, frozen=True, tag=True):
    """The page's own part cannot run there."""

    reason: Annotated[str, Meta(max_length=500)]


ByHand = (
    MoveOnMap
    | MoveOnLandscape
    | SelectMotion
    | SelectAdded
    | WalkTo
    | SetPlaying
    | Seek
    | SetSpeed
    | SetLoop
    | SetJoint
    | SetObserved
    | Undo
    | Redo
)
AnyAsked = ByHand | Hello | Looked | Present | Follow | Resized | Broken
_decoder: msgspec.json.Decoder[AnyAsked] = msgspec.json.Decoder(AnyAsked)


def parse(payload: object) -> AnyAsked:
    """What a page asks, from the text that it sent.

    Raises:
        InputError: it is no text, too long, or not what it should be.
    """
    if not isinstance(payload, str):
        raise InputError(f"a page's message is text, got {type(payload).__name__}")
    if len(payload) > MAX_DOCUMENT + MAX_PAYLOAD:
        raise InputError(f"a page's message of {len(payload)} characters")
    try:
        asked: AnyAsked = _decoder.decode(payload)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise InputError(f"a page's message: {error}") from error
    if len(payload) > MAX_PAYLOAD and not isinstance(asked, Hello):
        raise InputError(f"{type(asked).__name__} of {len(payload)} characters")
    if isinstance(asked, MoveOnMap | MoveOnLandscape) and len(asked.axes) != len(asked.to):
        raise InputError(f"{len(asked.axes)} axes and {len(asked.to)} coordinates")
    return asked


class Allowance:
    """How many messages a page may still send: so many a second, and some more at once."""

    def __init__(
        self,
        per_second: float = PER_SECOND,
        burst: float = BURST,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._per_second, self._burst, self._clock = per_second, burst, clock
        self._left, self._time = burst, clock()

    def spend(self) -> bool:
        """Whether there is one left, which is then spent."""
        now = self._clock()
        self._left = min(self._burst, self._left + (now - self._time) * self._per_second)
        self._time = now
        if self._left < 1:
            return False
        self._left -= 1
        return True
