"""Undo and redo: what is one step, what is left alone, and that all else comes back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import (
    Added,
    Camera,
    Document,
    ExportOptions,
    Playback,
    RecognitionSettings,
    Run,
    Seen,
    Zoom,
)
from rnnpb_explorer.app.state.history import LEFT_ALONE, MAX_UNDO, REST_SECONDS, History
from rnnpb_explorer.app.state.opening import learned_latent
from rnnpb_explorer.app.state.statecode import decode, encode
from rnnpb_explorer.app.state.wanted import wanted

from ..app_states import (
    FACTS,
    RUN,
    Page,
    make_facts,
    make_target,
    make_trace,
    opened,
)

LEARNED = (0.5, -0.3, 0.2)


def mu_of(page: Page) -> tuple[float, ...]:
    return tuple(round(value, 12) for value in page.document.current.latent.mu)


def on_map(x: float, gesture: int) -> do.MoveOnMap:
    return do.MoveOnMap(0, (0, 1), (x, 0.0), gesture)


def on_landscape(x: float, gesture: int) -> do.MoveOnLandscape:
    return do.MoveOnLandscape(0, ("μ1", "μ2"), (x, 0.0), gesture)


def test_undo_and_redo_walk_through_what_a_person_did() -> None:
    page = Page()
    seen = [page.document]
    for intent in (do.SelectMotion(1), do.SetMu(0, 0.9), do.NewNoise(), do.SetColouring("valence")):
        seen.append(page.do(intent).document)
    for document in reversed(seen[:-1]):
        assert page.do(do.Undo()).document == document
    assert page.do(do.Undo()).document == seen[0]  # there is nothing before
    for document in seen[1:]:
        assert page.do(do.Redo()).document == document
    assert page.do(do.Redo()).document == seen[-1]


def test_nothing_to_undo_is_the_same_history() -> None:
    history = History(opened())
    assert history.undo() is history
    assert history.redo() is history


def test_a_new_step_forgets_what_was_undone() -> None:
    page = Page().do(do.SetMu(0, 0.6), do.Undo(), do.SetMu(1, 0.6), do.Redo())
    assert mu_of(page) == (0.5, 0.6, 0.2)


def test_undo_goes_back_only_so_far() -> None:
    page = Page().do(*[do.NewNoise()] * (MAX_UNDO + 20))
    assert len(page.history.past) == MAX_UNDO == 100


# --- what is one step ---
def test_a_drag_is_one_step_however_far_and_however_long() -> None:
    page = Page()
    for x in (0.1, 0.2, 0.3, 0.4):
        page.do(on_map(x, gesture=7))
        page.now += 60.0
    assert mu_of(page.do(do.Undo())) == LEARNED


def test_two_drags_are_two_steps_even_on_two_boards() -> None:
    page = Page().do(on_landscape(0.6, 1), on_landscape(0.7, 2), on_map(0.0, 3), do.Undo())
    assert mu_of(page) == (0.7, 0.0, 0.2)
    assert mu_of(page.do(do.Undo())) == (0.6, 0.0, 0.2)


def test_a_slider_is_one_step_until_it_rests() -> None:
    page = Page().do(do.SetMu(0, 0.6))
    page.now = 0.8
    page.do(do.SetMu(0, 0.7))
    page.now = 1.61
    page.do(do.SetMu(0, 0.8), do.Undo())
    assert mu_of(page) == (0.7, -0.3, 0.2)
    assert mu_of(page.do(do.Undo())) == LEARNED


def test_short_rests_do_not_add_up() -> None:
    page = Page()
    for step in range(1, 10):
        page.now = 0.5 * step
        page.do(do.SetMu(0, 0.1 * step))
    assert mu_of(page.do(do.Undo())) == LEARNED


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (do.SetMu(0, 0.6), do.SetMu(1, 0.6)),
        (do.SetSigma(0, 0.6), do.SetSigma(1, 0.6)),
        (do.SetMu(0, 0.6), do.SetSigma(0, 0.6)),
        (do.SetSigma(1, 0.6), do.SetMu(1, 0.6)),
        (do.SetRecognitionOption("trials", 3), do.SetRecognitionOption("iterations", 50)),
    ],
    ids=str,
)
def test_two_sliders_are_two_steps(first: do.DocumentIntent, second: do.DocumentIntent) -> None:
    page = Page().do(first)
    once = page.document
    assert page.do(second, do.Undo()).document == once
    assert page.do(do.Undo()).document == opened()


@pytest.mark.parametrize("intent", [do.NewNoise(), do.RandomiseLatent()], ids=str)
def test_what_is_no_gesture_never_merges(intent: do.DocumentIntent) -> None:
    page = Page().do(intent)
    once = page.document
    assert page.do(intent, do.Undo()).document == once


def test_a_gesture_that_goes_on_after_undo_begins_anew() -> None:
    for intents in (
        (do.SetMu(0, 0.6), do.Undo(), do.SetMu(0, 0.7)),
        (on_map(0.1, 7), do.Undo(), on_map(0.2, 7)),
    ):
        assert mu_of(Page().do(*intents, do.Undo())) == LEARNED


# --- what undo leaves alone ---
def test_looking_is_no_step_and_stays_through_undo() -> None:
    facts = (make_facts(12, "wide"),)
    page = Page(facts).do(do.SetMu(0, 0.1))
    page.do(do.Seek(3), do.SetSpeed(2.0), do.SetLoop(False), do.ShowSliders(8))
    assert len(page.history.past) == 1
    seen = page.document
    for way in (do.Undo(), do.Redo()):
        page.do(way)
        assert (page.document.playback, page.document.first_slider) == (seen.playback, 8)
    assert page.document == seen


def test_another_model_has_its_own_pages_of_sliders() -> None:
    """The 97th dimension of one model is none of the other's."""
    facts = (make_facts(12, "wide"), make_facts(128, "widest"))
    page = Page(facts).do(do.SelectModel(1), do.ShowSliders(96), do.Undo())
    assert (page.document.active, page.document.first_slider) == (0, 0)
    assert page.do(do.Redo()).document.first_slider == 96


def test_a_page_of_sliders_shows_in_the_document() -> None:
    facts = (make_facts(12, "wide"),)
    document = Page(facts).do(do.SetPlaying(False), do.ShowSliders(8)).document
    assert document.first_slider == 8
    assert decode(facts, encode(document)).first_slider == 8
    for first in (-1, 12, 500):
        assert Page(facts, document).do(do.ShowSliders(first)).document == document


# --- all else comes back ---
@pytest.mark.parametrize(
    "facts",
    [
        FACTS,
        (make_facts(stochastic=False),),
        (make_facts(mu=[[0.5, -0.3, 0.2]] * 3 + [[0.5, -0.3, 0.2 + 1e-9]]),),
    ],
    ids=["stochastic", "deterministic", "all but the same"],
)
def test_undo_of_a_selection_brings_the_window_back(facts: Any) -> None:
    page = Page(facts).do(do.SetWindow("sd"), do.SetMu(0, 0.55), do.SetMu(0, 1.8))
    before = page.document
    assert before.current.anchor == (1.8, -0.3, 0.2)
    page.do(do.SelectMotion(3))
    assert page.document.current.anchor != before.current.anchor
    page.do(do.Undo())
    assert page.document.current.anchor == (1.8, -0.3, 0.2)
    assert page.wanted == wanted(facts, before)


def test_undo_of_an_upload_leaves_the_comparison_as_it_was() -> None:
    page = Page().do(do.SetUseTarget(False), do.SetTarget(make_target()))
    assert page.document.use_target
    page.do(do.Undo())
    assert (page.document.target, page.document.use_target) == (None, False)
    first = make_target(name="first")
    page.do(do.SetTarget(first), do.SetUseTarget(False), do.SetTarget(make_target(7)), do.Undo())
    assert (page.document.target, page.document.use_target) == (first, False)


def test_undo_holds_no_trace() -> None:
    """Only plain values: nothing of a run but its settings and how far it came."""
    page = Page().do(do.SetTarget(make_target()))
    for _ in range(3):
        page.do(do.StartRecognition())
        page.deliver(RUN, make_trace(np.zeros((101, 1, 3))), done=True)
        page.do(do.NewNoise())
    documents = (*page.history.past, page.document)
    assert len(documents) == 8
    for document in documents:
        rest = replace(document, target=None)
        assert len(msgspec.msgpack.encode(rest)) < 1000
    page.do(*[do.Undo()] * 7)
    assert page.document == opened()
    assert RUN not in page.computed.entries


# --- a new field of the document ---
SETTINGS = RecognitionSettings(
    method="paper",
    observed=0.5,
    init="random",
    iterations=7,
    trials=3,
    joints=("a", "c"),
    beta=1e-3,
    slow=True,
)
ANOTHER: dict[str, Callable[[Document], Any]] = {
    "models": lambda it: tuple(
        replace(one, latent=learned_latent(FACTS[0], 2), anchor=(1.0, 2.0, 3.0))
        for one in it.models
    ),
    "active": lambda it: 1,
    "playback": lambda it: Playback(playing=False, phase=0.25, speed=2.0, loop=False),
    "target": lambda it: make_target(7),
    "use_target": lambda it: False,
    "recognition": lambda it: SETTINGS,
    "run": lambda it: Run(0, SETTINGS, 3, done=5, settled=True, follows=False, trial=2, shown=4),
    "added": lambda it: (Added(0, "mine", (0.1, 0.2, 0.3), (0.0, 0.5, 1.0)),),
    "cloud": lambda it: False,
    "explanations": lambda it: False,
    "error_scale": lambda it: 0.25,
    "map_axes": lambda it: (2, 0),
    "landscape_axes": lambda it: "pca",
    "window": lambda it: "sd",
    "colouring": lambda it: "arousal",
    "joint": lambda it: "c",
    "compare": lambda it: True,
    "pair": lambda it: (1, 0),
    "hand": lambda it: "sd",
    "goal": lambda it: "rest",
    "walk": lambda it: 7,
    "first_slider": lambda it: 2,
    "side_by_side": lambda it: True,
    "show_target": lambda it: False,
    "revealed": lambda it: True,
    "ghosts": lambda document: True,
    "eyes": lambda it: False,
    "export": lambda it: ExportOptions("naoqi", safe_posture=True, beyond_limits=True),
    "lesson": lambda it: "2_smooth",
    "lesson_step": lambda it: 3,
    "seen": lambda it: Seen(
        map=Zoom("PC", 0.0, 1.0, -1.0, 1.0),
        landscape_2=Zoom("PC", 0.0, 2.0, -1.0, 1.0),
        camera=Camera((3.0, 1.0, 2.0), (0.0, 0.0, 1.0)),
        tab="View",
    ),
    "seed": lambda it: 77,
    "draws": lambda it: 5,
}


@pytest.mark.parametrize("name", Document.__struct_fields__)
def test_every_choice_is_undone_shared_and_restored(name: str) -> None:
    """A new field of the document needs another value here and nothing more anywhere."""
    facts = (make_facts(name="one"), make_facts(name="two"))
    before = opened(facts, do.SetTarget(make_target()))
    value = ANOTHER[name](before)
    assert value != getattr(before, name)
    after = replace(before, **{name: value})
    assert decode(facts, encode(after)) == after
    history = History(before).step(after, "", 0.0)
    assert history.present == after
    if name in LEFT_ALONE:
        assert history.past == ()
        return
    assert history.undo().present == before
    assert history.undo().redo().present == after


def test_what_is_left_alone_is_looking() -> None:
    assert LEFT_ALONE == ("playback", "first_slider", "seen")
    assert REST_SECONDS == 0.8
