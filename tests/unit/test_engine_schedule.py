"""What comes next, and who is told: pieces that only say that they were done, without threads."""

from __future__ import annotations

import gc
import logging
import weakref

import pytest

from rnnpb_explorer.app.engine.deliveries import Delivery
from rnnpb_explorer.app.engine.job import Steps

from .engine_shop import REST, Shop


@pytest.fixture
def shop() -> Shop:
    return Shop()


# --- one page ---
def test_a_work_is_done_and_every_stage_told_in_order(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a")
    assert shop.run() == ["motion a", "check motion a"]
    assert page.told == [("m", "motion a"), ("m", "checked motion a!")]


def test_what_is_waited_for_most_comes_first(shop: Shop) -> None:
    page = shop.page()
    page.want(r="recognition a", l="landscape a", m="motion a")
    shop.now = REST
    done = shop.run()
    assert done[:6] == ["motion a", "check motion a", *["coarse landscape a"] * 4]
    assert done[6:] == [*["recognition a"] * 4, *["complete landscape a"] * 2]


def test_a_motion_that_comes_later_overtakes_at_the_next_piece(shop: Shop) -> None:
    first, second = shop.page(), shop.page()
    first.want(r="recognition a")
    shop.run(1)
    second.want(m="motion b")
    assert shop.run(3) == ["motion b", "check motion b", "recognition a"]


def test_wanting_the_same_again_is_nothing(shop: Shop) -> None:
    page = shop.page()
    for _ in range(3):
        page.want(r="recognition a")
        shop.run(1)
    assert shop.begun == ["recognition a"]
    shop.run()
    page.want(r="recognition a")
    assert shop.run() == []
    assert [value for _, value in page.told] == [
        *(f"recognition a {number}" for number in (1, 2, 3)),
        "recognition a 4!",
    ]


def test_of_what_waits_only_the_newest_is_done(shop: Shop) -> None:
    page = shop.page()
    for name in ("old", "newer", "newest"):
        page.want(m=f"motion {name}")
    assert shop.run() == ["motion newest", "check motion newest"]


def test_every_slot_has_its_newest(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a1", n="motion b1")
    page.want(m="motion a2", n="motion b1")
    assert shop.run(2) == ["motion a2", "motion b1"]


def test_newer_work_keeps_the_turn_of_the_older(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a1", n="motion b")
    for number in range(2, 5):
        page.want(m=f"motion a{number}", n="motion b")
    assert shop.run(1) == ["motion a4"]


def test_a_slot_that_never_rests_does_not_starve_another_of_its_page(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a0", n="motion b")
    done = []
    for number in range(1, 4):
        done += shop.run(1)
        page.want(m=f"motion a{number}", n="motion b")
    assert done == ["motion a0", "motion b", "motion a2"]


def test_work_that_waits_and_is_no_longer_wanted_vanishes(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a", r="recognition a")
    page.want(m="motion a")
    assert shop.run() == ["motion a", "check motion a"]


def test_work_under_way_ends_at_the_next_piece(shop: Shop) -> None:
    page = shop.page()
    page.want(r="recognition a")
    shop.run(2)
    page.want()
    assert shop.run() == []
    assert page.told == [("r", "recognition a 1"), ("r", "recognition a 2")]


def test_newer_work_ends_the_older_at_the_next_piece(shop: Shop) -> None:
    page = shop.page()
    page.want(r="recognition a")
    shop.run(2)
    page.want(r="recognition b")
    assert shop.run() == ["recognition b"] * 4
    assert page.told[2:][0] == ("r", "recognition b 1")


def test_a_piece_in_a_workers_hands_when_its_work_is_dropped_comes_to_nothing(shop: Shop) -> None:
    page = shop.page()
    page.want(r="recognition a")
    schedule = shop.crew._schedule
    ((job, task),) = schedule.take(0.0)
    page.want()
    assert not schedule.stepped(job, task, finished=task.step())
    assert shop.run() == []
    assert page.told == []


def test_a_check_is_not_made_of_a_motion_that_is_no_longer_wanted(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a")
    shop.run(1)
    page.want(m="motion b")
    assert shop.run() == ["motion b", "check motion b"]


def test_done_work_that_is_wanted_again_is_not_done_again(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a")
    shop.run()
    page.want()
    page.want(m="motion a")
    assert shop.run() == []
    assert page.told[2:] == [("m", "checked motion a!")]


# --- a landscape in a drag ---
def test_a_coarse_landscape_once_begun_is_finished_and_then_comes_the_newest(shop: Shop) -> None:
    page = shop.page()
    page.want(l="landscape a")
    shop.run(1)
    page.want(l="landscape b")
    page.want(l="landscape c")
    assert shop.run() == [*["coarse landscape a"] * 3, *["coarse landscape c"] * 4]
    assert page.told == [("l", "coarse landscape a"), ("l", "coarse landscape c")]


def test_a_drag_without_rest_does_not_starve_its_landscape(shop: Shop) -> None:
    page = shop.page()
    for number in range(12):  # newer work for every piece that is done
        page.want(l=f"landscape {number}")
        shop.run(1)
    assert [value for _, value in page.told] == [
        f"coarse landscape {number}" for number in (0, 4, 8)
    ]


def test_a_coarse_landscape_that_has_not_begun_is_not_finished(shop: Shop) -> None:
    page = shop.page()
    page.want(l="landscape a", m="motion a")
    shop.run(1)
    page.want(l="landscape b", m="motion a")
    assert "coarse landscape a" not in shop.run()


def test_going_back_to_the_landscape_that_is_being_finished_goes_on_with_it(shop: Shop) -> None:
    page = shop.page()
    page.want(l="landscape a")
    shop.run(1)
    page.want(l="landscape b")
    page.want(l="landscape a")
    shop.now = REST
    shop.run()
    assert shop.begun == ["landscape a"]
    assert page.told == [("l", "coarse landscape a"), ("l", "complete landscape a!")]


def test_a_coarse_landscape_that_nobody_wants_is_not_finished(shop: Shop) -> None:
    first, second = shop.page(), shop.page()
    first.want(l="landscape a")
    second.want(l="landscape b")
    shop.run(2)
    first.want()
    second.close()
    assert shop.run() == []


def test_the_complete_landscape_waits_until_its_work_has_rested(shop: Shop) -> None:
    page = shop.page()
    shop.now = 10.0
    page.want(l="landscape a")
    shop.run()
    shop.now = 10.0 + REST - 0.01
    assert shop.run() == []
    assert page.told == [("l", "coarse landscape a")]
    shop.now = 10.0 + REST
    assert shop.run() == ["complete landscape a"] * 2
    assert page.told[1:] == [("l", "complete landscape a!")]


def test_a_complete_landscape_ends_at_the_next_piece_when_the_window_moves(shop: Shop) -> None:
    page = shop.page()
    page.want(l="landscape a")
    shop.now = REST
    assert shop.run(5)[-1] == "complete landscape a"
    page.want(l="landscape b")
    assert "complete landscape a" not in shop.run()


def test_the_crew_knows_when_the_rest_will_be_over(shop: Shop) -> None:
    shop.now = 3.0
    shop.page().want(l="landscape a")
    schedule = shop.crew._schedule
    assert schedule.next_time(3.0) is None
    shop.run()
    assert not schedule.busy(3.0)
    assert schedule.next_time(3.0) == 3.0 + REST
    assert schedule.busy(3.0 + REST)


# --- several pages ---
def test_pages_take_turns(shop: Shop) -> None:
    first, second = shop.page(), shop.page()
    first.want(r="recognition a")
    second.want(r="recognition b")
    assert shop.run() == ["recognition a", "recognition b"] * 4


def test_the_page_served_least_recently_goes_first(shop: Shop) -> None:
    first, second, third = shop.page(), shop.page(), shop.page()
    first.want(r="recognition a")
    second.want(r="recognition b")
    shop.run(3)
    third.want(r="recognition c")
    assert shop.run(3) == ["recognition c", "recognition b", "recognition a"]


def test_a_hand_that_never_rests_does_not_starve_other_pages(shop: Shop) -> None:
    busy, patient = shop.page(), shop.page()
    patient.want(m="motion p1", n="motion p2")
    done = []
    for number in range(4):
        busy.want(m=f"motion b{number}")
        done += shop.run(1)
    assert done == ["motion p1", "motion b1", "motion p2", "motion b3"]


def test_turns_are_counted_within_a_priority(shop: Shop) -> None:
    """Motions that a page drags do not cost its recognition the turn."""
    dragging, other = shop.page(), shop.page()
    other.want(r="recognition b")
    shop.run(1)
    dragging.want(m="motion a")
    shop.run(2)
    dragging.want(r="recognition a", m="motion a")
    assert shop.run(2) == ["recognition a", "recognition b"]


def test_a_finishing_landscape_goes_before_the_others(shop: Shop) -> None:
    """All of them would be as late as the last otherwise."""
    pages = [shop.page() for _ in range(3)]
    for page, name in zip(pages, "abc", strict=True):
        page.want(l=f"landscape {name}")
    assert shop.run() == [f"coarse landscape {name}" for name in "abc" for _ in range(4)]


def test_the_same_work_of_two_pages_is_done_once(shop: Shop) -> None:
    first, second = shop.page(), shop.page()
    first.want(r="recognition a")
    second.want(x="recognition a")
    assert shop.run() == ["recognition a"] * 4
    assert [value for _, value in first.told] == [value for _, value in second.told]
    assert {slot for slot, _ in second.told} == {"x"}


def test_who_joins_later_gets_what_there_is_and_what_comes(shop: Shop) -> None:
    first, second = shop.page(), shop.page()
    first.want(r="recognition a")
    shop.run(2)
    second.want(r="recognition a")
    assert shop.run() == ["recognition a"] * 2
    assert [value for _, value in second.told] == [
        "recognition a 2",
        "recognition a 3",
        "recognition a 4!",
    ]


def test_a_page_that_leaves_takes_nothing_from_who_wants_the_same(shop: Shop) -> None:
    first, second = shop.page(), shop.page()
    first.want(r="recognition a")
    second.want(r="recognition a")
    shop.run(1)
    first.close()
    assert shop.run() == ["recognition a"] * 3
    assert len(first.told) == 1
    assert second.told[-1] == ("r", "recognition a 4!")


def test_shared_work_counts_for_everyone_who_wants_it(shop: Shop) -> None:
    first, second, third = shop.page(), shop.page(), shop.page()
    first.want(r="recognition shared")
    second.want(r="recognition shared", s="recognition own")
    third.want(r="recognition third")
    assert shop.run(2) == ["recognition shared", "recognition third"]


def test_a_page_is_one_of_many_in_its_own_slots(shop: Shop) -> None:
    """Ten slots do not make ten turns."""
    many, one = shop.page(), shop.page()
    many.want(**{f"s{number}": f"recognition {number}" for number in range(10)})
    one.want(r="recognition one")
    assert shop.run(4).count("recognition one") == 2


# --- pieces that are done together ---
def test_pieces_that_wait_at_the_same_moment_are_done_in_one_call(shop: Shop) -> None:
    pages = [shop.page() for _ in range(5)]
    for page, name in zip(pages, "abcde", strict=True):
        page.want(t=f"together {name}")
    assert shop.run() == ["a + b + c", "d + e"]
    assert [page.told for page in pages] == [[("t", f"together {name}!")] for name in "abcde"]


def test_a_fault_in_a_batch_is_only_one_pages(shop: Shop, caplog: pytest.LogCaptureFixture) -> None:
    pages = [shop.page() for _ in range(3)]
    for page, name in zip(pages, ("a", "faulty", "c"), strict=True):
        page.want(t=f"together {name}")
    assert shop.run() == ["a", "c"]
    assert pages[0].told == [("t", "together a!")]
    assert pages[1].told == [("t", "failed: str failed: by nought")]
    assert pages[2].told == [("t", "together c!")]


# --- faults ---
def test_bad_input_is_told_in_its_own_words_to_who_wanted_it(shop: Shop) -> None:
    first, second, third = shop.page(), shop.page(), shop.page()
    first.want(m="wrong a")
    second.want(n="wrong a")
    third.want(m="motion b")
    shop.run()
    assert first.told == [("m", "wrong a"), ("m", "failed: row 3 has a gap")]
    assert second.told == [("n", "wrong a"), ("n", "failed: row 3 has a gap")]
    assert third.told[-1] == ("m", "checked motion b!")


def test_any_other_fault_is_one_line_and_logged(
    shop: Shop, caplog: pytest.LogCaptureFixture
) -> None:
    page = shop.page()
    page.want(m="broken a", n="motion b")
    with caplog.at_level(logging.ERROR):
        shop.run()
    assert ("m", "failed: str failed: one by nought") in page.told
    assert "ZeroDivisionError" in caplog.text
    assert page.told[-1] == ("n", "checked motion b!")


def test_a_fault_before_the_first_piece_is_told_as_well(shop: Shop) -> None:
    page = shop.page()
    page.want(m="late a", n="motion b")
    shop.run()
    assert page.told[0] == ("m", "failed: no such thing")
    assert page.told[-1] == ("n", "checked motion b!")


def test_what_failed_is_tried_again_when_it_is_wanted_anew(shop: Shop) -> None:
    page = shop.page()
    page.want(m="wrong a")
    shop.run()
    page.want(m="wrong a", n="motion b")
    assert "wrong a" not in shop.run()
    page.want(n="motion b")
    page.want(m="wrong a", n="motion b")
    assert shop.run() == ["wrong a"] * 2
    assert page.told.count(("m", "failed: row 3 has a gap")) == 2


def test_newer_work_follows_the_one_that_failed_while_it_was_finished(shop: Shop) -> None:
    shop._kinds["landscape"] = shop._failing_landscape
    page = shop.page()
    page.want(l="landscape a")
    shop.run(1)
    page.want(l="motion b")
    shop.run()
    assert page.told == [("l", "failed: no"), ("l", "motion b"), ("l", "checked motion b!")]


def test_a_page_that_does_not_take_what_comes_costs_nobody_else(
    shop: Shop, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(delivery: Delivery) -> None:
        raise ZeroDivisionError("no room")

    handle, other = shop.crew.open(refuse), shop.page()
    handle.want({"m": "motion a"})  # type: ignore[dict-item]
    other.want(m="motion a")
    with caplog.at_level(logging.ERROR):
        shop.run()
    assert other.told[-1] == ("m", "checked motion a!")
    assert "no room" in caplog.text


# --- telling ---
def test_a_page_may_want_something_as_soon_as_it_is_told(shop: Shop) -> None:
    told = []

    def take(delivery: Delivery) -> None:
        told.append(delivery)
        handle.want({"m": "motion b"})  # type: ignore[dict-item]

    handle = shop.crew.open(take)
    handle.want({"m": "motion a"})  # type: ignore[dict-item]
    assert shop.run() == ["motion a", "motion b", "check motion b"]


def test_a_page_is_told_one_thing_after_the_other(shop: Shop) -> None:
    page = shop.page()
    page.want(r="recognition a")
    schedule = shop.crew._schedule
    job, task = schedule.take(0.0)[0]
    schedule.stepped(job, task, finished=task.step())
    schedule.progress(job, shop.crew._schedule._advance(job), 0.0)
    client, deliveries = schedule.mail() or pytest.fail("there is mail")
    assert len(deliveries) == 1
    job, task = schedule.take(0.0)[0]
    schedule.stepped(job, task, finished=task.step())
    schedule.progress(job, shop.crew._schedule._advance(job), 0.0)
    assert schedule.mail() is None  # another worker has the page's ear
    schedule.told(client)
    assert schedule.mail() is not None


def test_a_page_that_was_closed_is_told_nothing_and_gets_nothing(shop: Shop) -> None:
    page = shop.page()
    page.want(m="motion a")
    shop.run(1)
    page.close()
    page.want(m="motion b")
    assert shop.run() == []
    assert page.told == [("m", "motion a")]
    page.close()  # twice is once


def test_a_page_that_is_closed_is_not_told_what_it_was_about_to_be(shop: Shop) -> None:
    first, second = shop.page(), shop.page()
    first.want(m="motion a")
    shop.run()
    second.want(m="motion a")
    second.close()
    shop.run()
    assert second.told == []


def test_a_closed_crew_begins_nothing_that_waits(shop: Shop) -> None:
    shop.page().want(m="motion a")
    shop.crew.close(0.0)
    assert shop.run() == []


def test_nothing_is_kept_of_a_page_that_left(shop: Shop) -> None:
    kept: list[weakref.ref[object]] = []

    class Heavy:
        pass

    def heavy(work: str, wanted_at: float) -> Steps:
        trace = Heavy()
        kept.append(weakref.ref(trace))
        yield from shop._recognition(work, wanted_at)
        del trace

    shop._kinds["heavy"] = heavy
    page = shop.page()
    page.want(r="heavy a", s="heavy b")
    shop.run(3)
    assert [one() is not None for one in kept] == [True, True]
    page.close()
    gc.collect()
    assert [one() for one in kept] == [None, None]


# --- several workers ---
def test_pieces_of_a_round_are_there_for_all_workers_and_the_next_round_waits(shop: Shop) -> None:
    page = shop.page()
    page.want(l="landscape a")
    schedule = shop.crew._schedule
    first, second = schedule.take(0.0), schedule.take(0.0)
    assert len(first) == len(second) == 1
    assert schedule.take(0.0) == []  # the second round needs both
    for (job, task), goes_on in zip((*second, *first), (False, True), strict=True):
        assert schedule.stepped(job, task, finished=task.step()) == goes_on


def test_a_long_task_goes_on_before_the_next_one_of_its_round_begins(shop: Shop) -> None:
    page = shop.page()
    page.want(l="landscape a")
    schedule = shop.crew._schedule
    ((job, task),) = schedule.take(0.0)
    assert not schedule.stepped(job, task, finished=False)
    assert schedule.take(0.0) == [(job, task)]
