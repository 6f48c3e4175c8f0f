"""Models opened on a page, in place of another or beside it, and closed again."""

from __future__ import annotations

from dataclasses import replace as copied

import numpy as np
import pytest
from msgspec.structs import replace

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.computed import Computed, Entry
from rnnpb_explorer.app.state.document import MAX_MODELS, Added, Document
from rnnpb_explorer.app.state.facts import Facts, ModelFacts
from rnnpb_explorer.app.state.history import History
from rnnpb_explorer.app.state.on_models import close_model, open_model
from rnnpb_explorer.app.state.opening import check_fits, opening_document
from rnnpb_explorer.app.state.wanted import wanted
from rnnpb_explorer.core.errors import InputError

from ..app_states import PUBLISHED, after, make_facts, make_target, motion_result, opened

ONE, TWO = make_facts(name="one"), make_facts(12, "two", ("bow", "jump", "wave"))
OTHER_JOINTS = make_facts(3, "arm", joints=("x", "y"))
KNOWN = {one.name: one for one in (ONE, TWO, OTHER_JOINTS, *(make_facts(name=n) for n in "abc"))}


def facts_of(document: Document) -> Facts:
    return tuple(KNOWN[choice.name] for choice in document.models)


def with_model(document: Document, newcomer: ModelFacts, *, beside: bool = False) -> Document:
    """It opens, and what comes of it fits the models that it names."""
    made = open_model(facts_of(document), document, newcomer, beside=beside)
    check_fits(facts_of(made), made)
    return made


def names(document: Document) -> list[str]:
    return [choice.name for choice in document.models]


def test_a_model_takes_the_active_ones_place_at_the_same_motion() -> None:
    document = opened((ONE,), do.SelectMotion(1), do.SetLandscapeAxes((1, 2)), do.SetJoint("c"))
    document = with_model(document, TWO)
    assert names(document) == ["two"]
    assert document.current.latent.motion == 0  # bow
    np.testing.assert_array_equal(document.current.latent.mu, TWO.mu[0])
    assert document.joint == "c"
    assert with_model(document, ONE).current.latent.mu == tuple(ONE.mu[1].tolist())


def test_one_that_is_on_the_page_becomes_the_active_one() -> None:
    document = with_model(opening_document((ONE, TWO)), TWO)
    assert (names(document), document.active) == (["one", "two"], 1)


def test_a_model_beside_is_compared_with_one_hand() -> None:
    document = with_model(opened((ONE,)), TWO, beside=True)
    assert names(document) == ["one", "two"]
    assert document.compare
    assert (document.active, document.on_boards, document.hand) == (0, (0, 1), "absolute")
    document = with_model(document, KNOWN["a"], beside=True)  # another one to compare with
    assert (names(document), document.on_boards) == (["one", "a"], (0, 1))
    document = with_model(document, KNOWN["b"])  # in place of the active one
    assert (names(document), document.compare) == (["b", "a"], True)


def test_a_page_takes_so_many_models() -> None:
    document = opening_document((ONE, TWO, KNOWN["a"], KNOWN["b"]))
    with pytest.raises(InputError, match=f"{MAX_MODELS} models are on the page"):
        with_model(document, KNOWN["c"], beside=True)
    assert names(with_model(document, KNOWN["c"])) == ["c", "two", "a", "b"]


def test_other_joints_are_refused_in_words() -> None:
    with pytest.raises(InputError, match="one and arm cannot be compared: they move other joints"):
        with_model(opened((ONE,)), OTHER_JOINTS, beside=True)
    facts = (ONE, OTHER_JOINTS)
    with pytest.raises(InputError, match="cannot be compared"):
        after(facts, opening_document(facts), do.SetCompare(True))
    three = (ONE, TWO, OTHER_JOINTS)
    compared = after(three, opening_document(three), do.SetCompare(True))
    assert not after(three, compared, do.SelectModel(2)).compare
    compared = with_model(opened((ONE,)), TWO, beside=True)
    with pytest.raises(InputError, match="cannot be compared"):
        with_model(compared, OTHER_JOINTS)


def test_what_was_the_old_models_goes_with_it() -> None:
    point = Added(0, "mine", (0.0,) * 3, (0.1,) * 3)
    document = after((ONE,), opened((ONE,)), PUBLISHED, do.SetTarget(make_target()))
    document = replace(after((ONE,), document, do.StartRecognition()), added=(point,))
    made = with_model(document, TWO)
    assert (made.run, made.added) == (None, ())
    assert made.target == document.target
    beside = with_model(document, TWO, beside=True)
    assert beside.added == (point,)


@pytest.mark.parametrize("active", [0, 1, 2])
def test_a_closed_model_leaves_the_others_as_they_are(active: int) -> None:
    facts = (ONE, TWO, KNOWN["a"])
    points = tuple(Added(i, f"of {i}", (0.0,) * d, (0.1,) * d) for i, d in enumerate((3, 12, 3)))
    document = after(facts, opening_document(facts), do.SelectModel(active))
    document = replace(document, added=points)
    closed = close_model(facts, document)
    check_fits(facts_of(closed), closed)
    left = [i for i in range(3) if i != active]
    assert names(closed) == [facts[i].name for i in left]
    assert [facts[left[one.model]].name for one in closed.added] == [facts[i].name for i in left]
    assert closed.current.name in names(closed)


def test_the_last_model_stays_and_a_comparison_ends_with_one_of_its_models() -> None:
    assert close_model((ONE,), opened((ONE,))) == opened((ONE,))
    compared = with_model(opened((ONE,)), TWO, beside=True)
    closed = close_model((ONE, TWO), compared)
    assert (names(closed), closed.compare, closed.on_boards) == (["two"], False, (0,))


def test_undo_brings_a_model_back_with_its_sliders() -> None:
    history = History(opened((TWO,), do.ShowSliders(8)))
    history = history.step(with_model(history.present, ONE), "", 0.0)
    assert history.present.first_slider == 0
    assert names(history.undo().present) == ["two"]
    assert history.undo().present.first_slider == 8


def test_nothing_of_another_model_is_shown_in_its_place() -> None:
    document = opened((ONE,))
    works = wanted((ONE,), document)
    computed = Computed.nothing()
    for slot in (("motion", 0), ("landscape", 0)):
        work = works[slot]  # type: ignore[index]
        entry = Entry(work, motion_result(works["motion", 0]), done=True)  # type: ignore[arg-type]
        computed = computed.put(works, slot, entry)  # type: ignore[arg-type]
    twin = copied(ONE, name="twin")
    assert len(computed.keep(works).entries) == 2
    there = wanted((twin,), open_model((ONE,), document, twin, beside=False))
    assert computed.keep(there).entries.keys() <= there.keys() - {("landscape", 0)}
