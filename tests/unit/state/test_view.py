"""How things are shown: playback, axes, windows, colours, and the robot's options."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import Document, ExportOptions
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.planes import landscape_plane
from rnnpb_explorer.app.state.wanted import export_work, wanted

from ..app_states import (
    FACTS,
    LANDSCAPE,
    MOTION,
    MU,
    ONE_DIMENSION,
    TWELVE_DIMENSIONS,
    Page,
    after,
    landscape_of,
    make_facts,
    motion_of,
    newly_wanted,
    opened,
)

PAIR = (make_facts(name="one"), make_facts(name="two"))
LAST = 11  # the opening motion has 12 frames


def frame(*intents: do.PlaybackIntent, document: Document | None = None) -> float:
    """Where playback rests after these, of 12 frames."""
    playback = Page(FACTS, document).do(*intents).document.playback
    return playback.phase * LAST


# --- playback: the browser has the clock, the document how it goes on and where it rests ---
@pytest.mark.parametrize(
    ("asked", "got"), [(0.0, 0.1), (99.0, 3.0), (-1, 0.1), (math.nan, 1.0), (2.5, 2.5)]
)
def test_speed_stays_within_reason(asked: float, got: float) -> None:
    assert opened(FACTS, do.SetSpeed(asked)).playback.speed == got


def test_the_browser_says_where_it_rests() -> None:
    rested = opened(FACTS, do.SetPlaying(False, 5.5))
    assert (rested.playback.playing, frame(document=rested)) == (False, 5.5)
    assert frame(do.SetPlaying(True), document=rested) == 5.5
    assert frame(do.SetPlaying(False, 99.0)) == LAST
    assert frame(do.SetPlaying(False, math.nan), document=rested) == 5.5


def test_without_loop_play_begins_again_at_the_end() -> None:
    ended = opened(FACTS, do.SetLoop(False), do.SetPlaying(False, LAST))
    again = after(FACTS, ended, do.TogglePlaying())
    assert (again.playback.playing, again.playback.phase) == (True, 0.0)


@pytest.mark.parametrize(
    ("asked", "got"), [(7, 7), (0, 0), (LAST, LAST), (99, LAST), (-4, 0), (2.5, 2.5)]
)
def test_seeking_pauses_at_a_frame(asked: float, got: float) -> None:
    assert not opened(FACTS, do.Seek(asked)).playback.playing
    assert frame(do.Seek(asked)) == got


def test_the_phase_survives_a_change_of_length() -> None:
    page = Page().do(do.Seek(6), do.SelectMotion(3))  # of 21 frames
    assert page.document.playback.phase == 6 / 11


def test_playing_goes_on_while_the_latent_moves() -> None:
    assert Page().do(do.SetMu(0, 0.9)).document.playback.playing


def test_playback_wants_no_work() -> None:
    assert newly_wanted(FACTS, opened(), do.Seek(3), do.SetLoop(False)) == {}


# --- what the boards show ---
def test_other_axes_want_another_landscape() -> None:
    works = newly_wanted(FACTS, opened(), do.SetLandscapeAxes((2, 1)))
    assert set(works) == {LANDSCAPE}
    landscape = landscape_of(works)
    assert landscape.directions == ((0, 0, 1), (0, 1, 0))
    assert landscape.labels == ("μ3", "μ2")
    document = opened(FACTS, do.SetLandscapeAxes((2, 1)))
    assert landscape_plane(FACTS[0], document, document.current).middle.tolist() == [0.2, -0.3]


def test_the_plane_of_the_map_is_a_landscape_too() -> None:
    document = opened(FACTS, do.SetLandscapeAxes("pca"))
    landscape, latent_map = landscape_of(wanted(FACTS, document)), FACTS[0].latent_map
    np.testing.assert_allclose(landscape.directions, latent_map.components[:2], atol=1e-9)
    np.testing.assert_allclose(landscape.zero, latent_map.mean, atol=1e-9)
    np.testing.assert_allclose(landscape.center, MU[0], atol=1e-9)
    assert landscape.labels == ("PC1", "PC2")
    middle = landscape_plane(FACTS[0], document, document.current).middle
    np.testing.assert_allclose(middle, latent_map.project(MU[0])[:2])


def test_the_maps_axes_matter_to_the_landscape_only_in_its_own_plane() -> None:
    assert newly_wanted(FACTS, opened(), do.SetMapAxes((1, 2))) == {}
    pca = opened(FACTS, do.SetLandscapeAxes("pca"))
    landscape = landscape_of(newly_wanted(FACTS, pca, do.SetMapAxes((1, 2))))
    components = FACTS[0].latent_map.components[[1, 2]]
    np.testing.assert_allclose(landscape.directions, components, atol=1e-9)


@pytest.mark.parametrize(
    ("facts", "axes"),
    [
        *[(FACTS, axes) for axes in ((0,), (0, 0), (0, 3), (-1, 0), (0, 1, 2), ())],
        (ONE_DIMENSION, (0, 1)),
        (ONE_DIMENSION, (1,)),
    ],
)
def test_axes_that_there_are_not_change_nothing(facts: Facts, axes: tuple[int, ...]) -> None:
    assert opened(facts, do.SetMapAxes(axes), do.SetLandscapeAxes(axes)) == opened(facts)


@pytest.mark.parametrize("facts", [ONE_DIMENSION, FACTS, TWELVE_DIMENSIONS])
def test_the_same_view_again_changes_nothing(facts: Facts) -> None:
    axes = opened(facts).map_axes
    again = do.SetMapAxes(axes), do.SetLandscapeAxes(axes), do.SetWindow("absolute")
    assert opened(facts, *again) == opened(facts)


def test_a_window_that_loses_the_puck_moves_to_it() -> None:
    document = opened(FACTS, do.SetMu(0, 1.4))
    assert document.current.anchor == (0.5, -0.3, 0.2)
    document = after(FACTS, document, do.SetWindow("sd"))  # 0.7 sd is about 0.3
    assert document.current.anchor == (1.4, -0.3, 0.2)


def test_axes_along_which_the_puck_is_far_move_the_window_to_it() -> None:
    far = opened(FACTS, do.SetMu(2, 3.0))  # across the plane: the window stays
    assert far.current.anchor == tuple(MU[0])
    document = after(FACTS, far, do.SetLandscapeAxes((1, 2)))
    assert document.current.anchor == (0.5, -0.3, 3.0)
    document = opened(
        FACTS, do.SetLandscapeAxes("pca"), do.MoveOnMap(0, (2,), (4.0,), 1), do.SetMapAxes((0, 2))
    )
    assert document.current.anchor == document.current.latent.mu != tuple(MU[0])


def test_colours_joints_and_eyes_are_just_shown() -> None:
    shown = do.SetColouring("valence"), do.SetJoint("c"), do.SetEyes(False)
    assert newly_wanted(FACTS, opened(), *shown) == {}
    document = opened(FACTS, *shown)
    assert (document.colouring, document.joint, document.eyes) == ("valence", "c", False)
    assert after(FACTS, document, do.SetJoint("knee")) == document  # the model has none
    assert after(FACTS, document, do.SetJoint("")).joint == ""


# --- the robot ---
def test_the_limited_motion_is_made_only_while_it_is_seen_and_of_the_active_model() -> None:
    def checks(document: Document) -> list[str]:
        return [motion_of(wanted(PAIR, document), index).check for index in (0, 1)]

    assert checks(opened(PAIR)) == ["report", "report"]
    both = opened(PAIR, do.SetSideBySide(True))
    assert checks(both) == ["limited", "report"]
    assert checks(after(PAIR, both, do.SelectModel(1))) == ["report", "limited"]
    assert checks(after(PAIR, both, do.SetSideBySide(False))) == ["report", "report"]
    assert set(newly_wanted(PAIR, opened(PAIR), do.SetSideBySide(True))) == {MOTION}


def test_an_export_is_of_the_motion_on_the_screen() -> None:
    document = opened(
        FACTS,
        do.SetMu(0, 0.9),
        do.SetExportOption("file_format", "json"),
        do.SetExportOption("safe_posture", True),
    )
    work = export_work(FACTS, document)
    assert (work.name, work.options) == ("wave tiny", ExportOptions("json", safe_posture=True))
    assert (work.motion.pb, work.motion.steps) == ((0.9, -0.3, 0.2), 12)
    as_it_is = ExportOptions("csv", beyond_limits=True)
    assert export_work(FACTS, document, as_it_is).options == as_it_is


def test_a_format_that_there_is_not_changes_nothing() -> None:
    assert opened(FACTS, do.SetExportOption("file_format", "bvh")) == opened()
