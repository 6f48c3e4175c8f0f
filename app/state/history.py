"""Undo, redo and state codes: the way through documents. Pure.

Everything that a person does makes a step, but for what undo leaves alone: looking is not doing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from msgspec import structs

from . import intents as do
from .document import Document

MAX_UNDO = 100
REST_SECONDS = 0.8  # a slider that rests this long ends its gesture; a drag ends with the button
LEFT_ALONE = ("playback", "first_slider", "seen")  # of a document


@dataclass(frozen=True)
class History:
    """The document of now, those before it, and those that were taken back."""

    present: Document
    past: tuple[Document, ...] = ()
    future: tuple[Document, ...] = ()  # the next one at the end
    gesture: str = ""  # the gesture that made the present
    moved: float = 0.0  # seconds; when that gesture last did something

    def step(self, after: Document, gesture: str, now: float) -> History:
        """A person made `after` of the present, as part of a gesture ("" = one of its own)."""
        if _with_view_of(after, self.present) == self.present:  # something to look at, if anything
            return replace(self, present=after)
        on = gesture and gesture == self.gesture
        goes_on = on and (gesture.startswith("drag") or now - self.moved <= REST_SECONDS)
        past = self.past if goes_on else (*self.past, self.present)[-MAX_UNDO:]
        return History(after, past, (), gesture, now)

    def revise(self, present: Document) -> History:
        """The present came further by itself: nobody did anything."""
        return replace(self, present=present)

    def undo(self) -> History:
        """The document before; itself where there is none."""
        if not self.past:
            return self
        back = _with_view_of(self.past[-1], self.present)
        return History(back, self.past[:-1], (*self.future, self.present))

    def redo(self) -> History:
        if not self.future:
            return self
        on = _with_view_of(self.future[-1], self.present)
        return History(on, (*self.past, self.present), self.future[:-1])


def gesture_of(intent: do.Intent) -> str:
    """What goes on as one step of undo: one drag, one slider."""
    match intent:
        case do.MoveOnMap() | do.MoveOnLandscape():
            return f"drag {intent.gesture}"
        case do.SetMu() | do.SetSigma():
            return f"{type(intent).__name__} {intent.dim}"
        case do.SetRecognitionOption():
            return f"option {intent.name}"
        case do.SetErrorScale():
            return "error scale"
        case do.WalkTo(int()):
            return "walk"
        case do.ScrubRecognition():
            return "scrub"
        case _:
            return ""


def _with_view_of(document: Document, seen: Document) -> Document:
    """The document as it is being looked at; another model has other pages of sliders."""
    view = {name: getattr(seen, name) for name in LEFT_ALONE}
    if document.current.name != seen.current.name:
        del view["first_slider"]
    return structs.replace(document, **view)
