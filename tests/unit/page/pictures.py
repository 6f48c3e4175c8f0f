"""Pictures for the tests of panels, boards and robots, made up or of a session that is served."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rnnpb_explorer.app.page.session import Session
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.results import CheckedMotion, MotionResult, RecognitionTrace
from rnnpb_explorer.app.state.wanted import wanted
from rnnpb_explorer.robot.safety_report import SafetyReport, Violation

from ..app_states import FACTS, MOTION, RUN, Page
from ..wire_browser import TIMEOUT


class Clock:
    """A clock that a test moves."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def opening(facts: Facts = FACTS) -> Picture:
    """The opening screen before anything was computed."""
    return Page(facts).picture


def open_screen(facts: Facts = FACTS) -> Picture:
    """The opening screen with everything that it shows."""
    return Page(facts).compute().picture


def page_of(picture: Picture) -> Page:
    """A page on which somebody can go on from the picture."""
    page = Page(picture.facts, picture.document)
    page.computed = picture.computed
    return page


def after(picture: Picture, *asked: do.DocumentIntent) -> Picture:
    """The picture once a person did this; what is computed is behind then."""
    return page_of(picture).do(*asked).picture


def answered(picture: Picture) -> Picture:
    """The picture once motions and landscapes have come."""
    return page_of(picture).compute().picture


def came_to(picture: Picture, trace: RecognitionTrace) -> Picture:
    """The picture once its run has come so far."""
    return page_of(picture).deliver(RUN, trace, done=False).picture


def broke_off(picture: Picture, message: str) -> Picture:
    """The picture once its run has failed."""
    return page_of(picture).fail(RUN, message).picture


def checked(
    picture: Picture,
    *violations: Violation,
    model: int = 0,
    limited: float | None = None,
    unchecked: tuple[str, ...] = (),
) -> Picture:
    """The picture once a model's motion was checked, and found to break these limits."""
    page = page_of(picture)
    slot = (MOTION[0], model)
    shown = picture.motion(model)
    assert shown is not None
    within = None if limited is None else np.full_like(shown, limited)
    check = CheckedMotion(SafetyReport(violations, unchecked), within)
    return page.deliver(slot, MotionResult(shown, check)).picture


def until(session: Session, condition: Callable[[Picture], bool]) -> Picture:
    """Wait until a picture that fulfils the condition has been shown; that picture."""
    seen: list[Picture] = []

    def fulfils(picture: Picture) -> bool:
        seen[:] = [picture]
        return condition(picture)

    assert session.wait_for(fulfils, TIMEOUT)
    return seen[0]


def complete(picture: Picture) -> bool:
    """Whether all that this picture shows has been computed."""
    return not picture.computed.missing(wanted(picture.facts, picture.document))
