"""Results and failures: which one is shown, what is still missing, what is forgotten."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.computed import Entry
from rnnpb_explorer.app.state.results import CheckedMotion, ExportedFile, MotionResult
from rnnpb_explorer.app.state.wanted import export_work
from rnnpb_explorer.core.windows import Landscape
from rnnpb_explorer.robot.safety_report import SafetyReport

from ..app_states import (
    LANDSCAPE,
    MOTION,
    REFERENCE,
    RUN,
    Page,
    landscape_result,
    make_target,
    make_trace,
    motion_of,
    motion_result,
)

EXPORT = ("export", 0)


def shown_landscape(page: Page) -> Landscape:
    shown = page.picture.landscape
    assert shown is not None
    return shown[1]


def paths() -> Iterator[np.ndarray]:  # type: ignore[type-arg]
    for steps in range(1, 4):
        yield np.zeros((steps + 1, 1, 3))


def test_everything_is_missing_at_first_and_nothing_once_it_is_there() -> None:
    page = Page()
    assert page.missing == page.wanted
    assert page.picture.motion() is page.picture.reference() is page.picture.landscape is None
    page.compute()
    assert page.missing == {}
    motion = page.picture.motion()
    assert motion is not None
    assert motion.shape == (12, 5)
    assert page.picture.landscape_complete


def test_a_motion_is_shown_before_its_check_and_wanted_until_then() -> None:
    page = Page()
    motion = motion_result(motion_of(page.wanted))
    page.deliver(MOTION, motion, done=False)
    assert page.picture.motion() is motion.positions
    assert page.picture.checked is None
    assert MOTION in page.missing
    check = CheckedMotion(SafetyReport((), ()), None)
    page.deliver(MOTION, MotionResult(motion.positions, check))
    assert page.picture.checked is check
    assert MOTION not in page.missing


def test_an_outdated_motion_is_shown_only_until_there_is_the_newest() -> None:
    page = Page()
    old = motion_of(page.wanted)
    page.do(do.SetMu(0, 0.9))
    page.deliver(MOTION, motion_result(old), work=old)
    motion = page.picture.motion()
    assert motion is not None
    assert motion[0, 0] == 0.5
    assert MOTION in page.missing
    page.deliver(MOTION, motion_result(motion_of(page.wanted)))
    page.deliver(MOTION, motion_result(old), work=old)
    motion = page.picture.motion()
    assert motion is not None
    assert motion[0, 0] == np.float32(0.9)


def test_coarse_gives_way_to_complete_and_never_the_other_way_round() -> None:
    page = Page()
    coarse, complete = landscape_result(complete=False), landscape_result()
    page.deliver(LANDSCAPE, coarse, done=False)
    assert shown_landscape(page) is coarse.values
    assert not page.picture.landscape_complete
    assert LANDSCAPE in page.missing
    page.deliver(LANDSCAPE, complete)
    assert page.picture.landscape_complete
    page.deliver(LANDSCAPE, coarse, done=False)  # it was asked for twice
    assert shown_landscape(page) is complete.values
    assert page.picture.landscape_complete


def test_a_landscape_of_another_plane_is_shown_and_not_called_complete() -> None:
    page = Page().compute().do(do.SetMu(2, 0.9))
    assert page.picture.landscape is not None
    assert not page.picture.landscape_complete
    coarse = landscape_result(complete=False)
    page.deliver(LANDSCAPE, coarse, done=False)  # a newer coarse one replaces it
    assert shown_landscape(page) is coarse.values
    page.do(do.SetMu(2, 0.2))
    assert not page.picture.landscape_complete


def test_what_is_there_is_not_computed_again_after_undo() -> None:
    page = Page().compute().do(do.SetMu(2, 0.9), do.Undo())
    assert page.missing == {}
    assert page.picture.landscape_complete


def test_results_of_what_the_document_has_no_more_are_forgotten() -> None:
    page = Page().compute().do(do.SetTarget(make_target()))
    assert set(page.computed.entries) == {MOTION, LANDSCAPE}
    page.do(do.StartRecognition()).deliver(RUN, make_trace(np.zeros((3, 1, 3))), done=False)
    assert RUN in page.computed.entries
    page.do(do.ClearTarget())
    assert RUN not in page.computed.entries
    assert set(page.missing) == {MOTION, LANDSCAPE, REFERENCE}


def test_a_run_that_is_computed_again_is_shown_from_where_it_was() -> None:
    page = Page().do(do.SetTarget(make_target()), do.StartRecognition())
    for path in paths():
        page.deliver(RUN, make_trace(path), done=False)
    page.do(do.CancelRecognition())
    assert RUN not in page.missing
    page.do(do.Undo())  # it goes on
    assert RUN in page.missing
    for path in paths():
        page.deliver(RUN, make_trace(path), done=False)
        assert page.picture.trace is not None
        assert page.picture.trace.iterations == 3


# --- failures ---
def test_what_failed_is_wanted_again_and_the_failure_forgotten_once_it_was_not_wanted() -> None:
    page = Page()
    page.fail(LANDSCAPE, "out of memory")
    failed = page.wanted[LANDSCAPE]
    assert page.computed.failures == {LANDSCAPE: (failed, "out of memory")}
    page.do(do.SetMu(0, 0.6))  # the landscape stays as it is
    assert page.computed.failures == {LANDSCAPE: (failed, "out of memory")}
    page.do(do.SetLandscapeAxes((0, 2)))
    assert page.computed.failures == {}
    page.do(do.SetLandscapeAxes((0, 1)))
    assert page.missing[LANDSCAPE] == failed
    page.deliver(LANDSCAPE, landscape_result())
    assert page.picture.landscape_complete


def test_a_failure_of_a_run_stays_while_the_run_does() -> None:
    page = Page().do(do.SetTarget(make_target()), do.StartRecognition()).fail(RUN, "broken")
    page.do(do.SetMu(0, 0.1))
    assert page.picture.run_status == "failed"
    page.do(do.SetTarget(make_target(7)))
    assert page.computed.failures == {}
    assert page.picture.run_status == "idle"


# --- files ---
def test_a_file_is_of_this_very_motion_with_these_very_options() -> None:
    page = Page().compute()
    work = export_work(page.facts, page.document)
    file = ExportedFile("wave.csv", "a", "wave.csv: 12 frames")

    def written() -> Page:
        page.computed = page.computed.put({EXPORT: work}, EXPORT, Entry(work, file, True))
        return page

    assert written().picture.exported == "wave.csv: 12 frames"
    assert page.computed.missing({EXPORT: work}) == {}
    page.computed = page.computed.without(EXPORT)  # written once more
    assert page.computed.missing({EXPORT: work}) == {EXPORT: work}
    assert page.picture.exported == ""
    for other in (do.SetMu(0, 0.9), do.SetExportOption("file_format", "json")):
        page = Page().compute().do(other)
        assert written().picture.exported == ""
