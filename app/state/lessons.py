"""A lesson: steps that each set the screen, say what to look at, and leave the hands free. Pure.

Lessons are files (`page/lessons.py`); all that a person reads of one stands in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import msgspec
from msgspec import Meta, Struct

from ...core.errors import InputError
from ...core.recognition_run import Method
from ...core.walk import STEPS
from ...core.windows import Window
from . import intents as do
from .document import MAX_PB, MIN_OBSERVED, Document, Hand, Name
from .facts import Facts
from .update import update

Text = Annotated[str, Meta(min_length=1, max_length=1000)]
Label = Annotated[str, Meta(min_length=1, max_length=60)]
Tab = Literal["Explore", "Recognise", "Robot", "View", "Help"]


class Setting(Struct, frozen=True, forbid_unknown_fields=True):
    """What a step sets the screen to; what is not named stays as it is.

    models: one, or two to compare. sigma: the same in every dimension. walk: a step of the way to
    `goal`, the way as one motion, or neither. example: a target that ships with the app; "": none.
    recognise: start now.
    """

    models: Annotated[tuple[Name, ...], Meta(min_length=1, max_length=2)] | None = None
    motion: Name | None = None
    sigma: Annotated[float, Meta(ge=0, le=MAX_PB)] | None = None
    goal: Name | None = None
    walk: Annotated[int, Meta(ge=0, le=STEPS)] | Literal["morph", "no"] | None = None
    hand: Hand | None = None
    window: Window | None = None
    ghosts: bool | None = None
    joint: Name | None = None
    tab: Tab | None = None
    example: Name | None = None
    revealed: bool | None = None
    method: Method | None = None
    observed: Annotated[float, Meta(ge=MIN_OBSERVED, le=1)] | None = None
    slow: bool | None = None
    recognise: bool = False
    playing: bool | None = None


class Step(Struct, frozen=True, forbid_unknown_fields=True):
    """say: what one sees. ask: what to do, or to foretell before the next step shows it."""

    say: Text
    ask: Text
    set: Setting = Setting()


class Words(Struct, frozen=True, forbid_unknown_fields=True):
    """What the buttons are called; step: where one is, with {step} and {steps} in it."""

    back: Label
    next: Label
    close: Label
    step: Label

    def __post_init__(self) -> None:
        try:
            self.at(1, 2)
        except (KeyError, ValueError, IndexError, AttributeError) as error:
            raise ValueError("step: only {step} and {steps} can stand in braces") from error
        if len({self.back, self.next, self.close}) < 3:
            raise ValueError("back, next and close have to differ")

    def at(self, step: int, steps: int) -> str:
        return self.step.format(step=step, steps=steps)


class Lesson(Struct, frozen=True, forbid_unknown_fields=True):
    title: Label
    words: Words
    step: Annotated[tuple[Step, ...], Meta(min_length=1, max_length=50)]


def set_screen(facts: Facts, document: Document, setting: Setting) -> Document:
    """The document as a step sets it, but for its models and its target.

    Raises:
        InputError: it speaks of a motion or a joint that the model does not know.
    """
    for intent in _intents(facts, document, setting):
        document = update(facts, document, intent)
    return document


def _intents(facts: Facts, document: Document, wanted: Setting) -> Iterator[do.DocumentIntent]:
    one = facts[document.active]
    if wanted.motion is not None:
        yield do.SelectMotion(_known(wanted.motion, one.motions, one.name))
    if wanted.sigma is not None:
        for dim in range(one.pb_dim):
            yield do.SetSigma(dim, wanted.sigma)
    if wanted.goal:
        _known(wanted.goal, one.motions, one.name)
    if wanted.joint:
        _known(wanted.joint, one.joints, one.name)
    simple: tuple[do.DocumentIntent | None, ...] = (
        None if wanted.goal is None else do.SetGoal(wanted.goal),
        None if wanted.hand is None else do.SetHand(wanted.hand),
        None if wanted.window is None else do.SetWindow(wanted.window),
        None if wanted.ghosts is None else do.SetGhosts(wanted.ghosts),
        None if wanted.joint is None else do.SetJoint(wanted.joint),
        None if wanted.revealed is None else do.SetRevealed(wanted.revealed),
    )
    yield from (intent for intent in simple if intent is not None)
    if wanted.walk is not None:
        yield do.WalkTo(None if wanted.walk == "no" else wanted.walk)
    if wanted.tab is not None:
        tab = "" if wanted.tab == "Explore" else wanted.tab
        yield do.Look(msgspec.structs.replace(document.seen, tab=tab))
    for name in ("method", "observed", "slow"):
        value = getattr(wanted, name)
        if value is not None:
            yield do.SetRecognitionOption(name, value)
    if wanted.recognise:
        yield do.StartRecognition()
    if wanted.playing is not None:
        yield do.SetPlaying(wanted.playing)


def _known(name: str, names: tuple[str, ...], model: str) -> int:
    if name not in names:
        raise InputError(f"this step speaks of {name}, which {model} does not know")
    return names.index(name)
