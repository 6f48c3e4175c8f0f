"""What the page shows of a recognition: cloud, posterior, paths, verdict, panels, joints."""

from __future__ import annotations

import dataclasses
import tomllib
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
import viser
from msgspec.structs import replace

from rnnpb_explorer.app.page.examples import examples
from rnnpb_explorer.app.page.panels.curves import densities
from rnnpb_explorer.app.page.panels.joints import parts_of
from rnnpb_explorer.app.page.panels.recognise import RecognisePanel
from rnnpb_explorer.app.page.views import (
    cloud_shown,
    curves_shown,
    map_shown,
    path_shown,
    puck_shown,
)
from rnnpb_explorer.app.page.words import (
    belief_lines,
    joints_line,
    minimised_line,
    nearest_line,
    run_line,
    verdict_lines,
)
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.results import BeliefResult, CodebookResult, MotionResult
from rnnpb_explorer.core.belief import Cloud, Mode
from rnnpb_explorer.core.recognition_run import Posterior
from rnnpb_explorer.robot.description import load_robot
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS
from rnnpb_explorer.robot.reading import read_motions

from ..app_states import (
    BELIEF,
    CODEBOOK,
    FACTS,
    MOTION,
    RUN,
    Page,
    make_facts,
    make_target,
    make_trace,
)
from .widgets import hand, labelled

TARGET = make_target(frames=10)
ROBOT = load_robot("pepper")
MU = FACTS[0].mu


def a_cloud(steps: int = 2) -> Cloud:
    return Cloud(
        frames=np.arange(steps) * 12,
        pbs=MU[:3].astype(np.float32),
        weights=np.array([[0.5, 0.25, 0.25], [0.81, 0.09, 0.1]], np.float32)[:steps],
        entropy=np.array([1.5, 0.9], np.float32)[:steps],
        modes=(Mode(MU[0].astype(np.float32), 0.8), Mode(MU[2].astype(np.float32), 0.2)),
        nearest=np.deg2rad(np.array([3.0, 20.0, 5.0, 9.0], np.float32)),
        entries=512,
    )


def believing() -> Page:
    page = Page().do(do.SetTarget(TARGET)).compute()
    page.deliver(CODEBOOK, CodebookResult(512, 512, 7.2))
    return page.deliver(BELIEF, BeliefResult(a_cloud(), (TARGET.array, TARGET.array)))


def run_to_its_end(trials: int = 2, **posterior: Any) -> Page:
    page = believing().do(do.SetRecognitionOption("method", "global"), do.StartRecognition())
    trace = make_trace(np.linspace(0, 1, 4 * trials * 3).reshape(4, trials, 3), finished=True)
    if posterior:
        trace = dataclasses.replace(trace, posterior=Posterior(np.zeros(3), **posterior))
    page.deliver(RUN, trace)
    work: Any = page.wanted[MOTION]
    return page.deliver(MOTION, MotionResult(TARGET.array + np.float32(0.05)), work=work)


# --- boards ---
def test_the_cloud_is_on_the_map() -> None:
    shown = cloud_shown(believing().picture)
    np.testing.assert_allclose(shown.places, FACTS[0].latent_map.points[:3, :2], atol=1e-6)
    np.testing.assert_array_equal(shown.weights[0], [255, 180, 180])
    assert shown.near == ("wave", "rest")
    np.testing.assert_allclose(shown.mass, [0.8, 0.2])
    nothing = cloud_shown(Page().picture)
    assert (len(nothing.places), nothing.entries) == (0, 0)
    off = believing().do(do.SetCloud(False)).picture
    assert len(cloud_shown(off).places) == 0


def test_the_full_covariance_is_on_the_map_and_a_band_on_the_curves() -> None:
    covariance = np.array([[0.5, 0.3, 0.0], [0.3, 0.4, 0.1], [0.0, 0.1, 0.2]])
    deviation = np.full((10, 5), 0.1)
    picture = run_to_its_end(covariance=covariance, deviation=deviation).picture
    components = FACTS[0].latent_map.components[:2]
    np.testing.assert_allclose(
        puck_shown(picture, None).covariance, components @ covariance @ components.T
    )
    curves = curves_shown(picture)
    motion = picture.motion()
    assert motion is not None
    np.testing.assert_allclose(curves.low, motion - 0.2, rtol=1e-5)
    np.testing.assert_allclose(curves.high, motion + 0.2, rtol=1e-5)
    assert curves_shown(believing().picture).low is None


def test_every_trial_has_a_way_of_its_own() -> None:
    picture = run_to_its_end(trials=3).picture
    shown = path_shown(picture)
    assert shown.others_on_map is not None
    assert shown.others_on_map.shape == (2, 4, 2)
    assert shown.early is None  # a matter of the published procedure
    paper = believing().do(
        do.SetRecognitionOption("trials", 2),
        do.SetRecognitionOption("iterations", 3),
        do.StartRecognition(),
    )
    trace = make_trace(np.zeros((4, 2, 3)))
    trace.early_update[1, 1] = True
    paper.deliver(RUN, trace)
    assert paper.document.run is not None
    early = path_shown(paper.picture).early
    assert early is not None
    assert early.tolist() == trace.early_update[:, paper.document.run.trial].tolist()


def test_own_points_are_on_the_map_of_their_model_alone() -> None:
    pair = (make_facts(name="one"), make_facts(name="two"))
    page = Page(pair).do(do.SetMu(0, 0.4), do.AddToMap("mine"))
    page.do(do.SelectModel(1), do.AddToMap("other"))
    shown = map_shown(page.picture)
    assert (shown.added_names, shown.added_index.tolist()) == (("other",), [1])
    back = map_shown(page.do(do.SelectModel(0)).picture)
    expected = pair[0].latent_map.project(page.document.added[0].mu)[:2]
    np.testing.assert_allclose(back.added, [expected])


def test_inferred_joints_are_marked() -> None:
    page = believing().do(do.SetRecognitionOption("joints", ("a", "c")))
    shown = curves_shown(page.picture)
    assert shown.unseen is not None
    assert shown.unseen.tolist() == [False, True, False, True, True]
    assert shown.reference is not None
    assert np.isnan(shown.reference[:8, 1]).all()
    assert joints_line(page.document, FACTS[0]) == "Inferred, not observed: b, d, e"
    assert curves_shown(believing().picture).unseen is None


# --- words ---
def test_never_done_alone() -> None:
    picture = run_to_its_end().picture
    lines = verdict_lines(picture)
    assert lines[0].startswith("Recognised: 9")
    assert "of the foretold" not in lines[0]  # nobody has seen it yet
    assert "Reveal the rest" in lines[-1]
    revealed = run_to_its_end().do(do.SetRevealed(True)).picture
    lines = verdict_lines(revealed)
    assert "of the foretold" in lines[0]
    assert "Error in the foretold part: 0.00250 rad²." in lines
    assert run_line(picture).startswith("Best: iteration ")
    assert verdict_lines(believing().picture) == []


def test_a_hand_on_it_is_said() -> None:
    page = run_to_its_end().do(do.SetMu(0, 0.9)).compute()
    assert "(moved by hand since)" in verdict_lines(page.picture)[0]


def test_what_is_hidden_is_scored_when_it_is_revealed() -> None:
    page = believing().do(
        do.SetRecognitionOption("method", "global"),
        do.SetRecognitionOption("joints", ("a", "b")),
        do.StartRecognition(),
    )
    page.deliver(RUN, make_trace(np.zeros((3, 1, 3)), finished=True)).compute()
    assert "not observed" not in verdict_lines(page.picture)[0]
    page.do(do.SetRevealed(True))
    assert "of the joints that were not observed" in verdict_lines(page.picture)[0]


def test_the_screen_names_what_is_minimised() -> None:
    page = believing()
    assert minimised_line(page.picture).endswith("all joints; no KL term")
    page.do(do.SetRecognitionOption("beta", 1e-3), do.SetRecognitionOption("joints", ("a", "b")))
    assert minimised_line(page.picture).endswith("2 joints, + 0.001/2 · KL(N(μ, σ²) ‖ N(0, I))")
    page.do(do.SetRecognitionOption("method", "live"))
    assert "held near the learned μ" in minimised_line(page.picture)


def test_closest_motions_and_the_codebook_in_words() -> None:
    picture = believing().picture
    assert (
        nearest_line(picture) == "Closest learned motions, off by: wave (3°), rest (5°), nod (9°)"
    )
    first, second = belief_lines(picture)
    assert first == "Codebook of 512 motions, made in 7 s."
    assert second == "At the end of the observed part: 80% near wave, 20% near rest."
    page = Page().do(do.SetTarget(TARGET))
    page.deliver(CODEBOOK, CodebookResult(128, 512, 0.0), done=False)
    assert belief_lines(page.picture) == [
        "The codebook grows: 128 of 512 motions; usable meanwhile."
    ]
    page.deliver(CODEBOOK, CodebookResult(512, 512, 0.0))
    assert "from this computer's cache" in belief_lines(page.picture)[0]


@pytest.mark.parametrize(
    ("method", "words"),
    [("global", "Recognising: iteration 2, lowest loss"), ("live", "Recognising: frame 2,")],
)
def test_how_far_it_is(method: str, words: str) -> None:
    page = believing().do(do.SetRecognitionOption("method", method), do.StartRecognition())
    page.deliver(RUN, make_trace(np.zeros((3, 1, 3))), done=False)
    assert run_line(page.picture).startswith(words)
    page.do(do.PauseRecognition(True))
    assert run_line(page.picture).startswith("Paused at")


# --- widgets ---
def test_a_run_is_paused_stepped_and_goes_on(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    panel = RecognisePanel(gui, FACTS, ROBOT, sent.append)
    page = believing().do(do.SetRecognitionOption("method", "global"), do.StartRecognition())
    page.deliver(RUN, make_trace(np.zeros((3, 1, 3))), done=False)
    panel.show(page.picture)
    assert not labelled(gui, "One step").visible
    hand(labelled(gui, "Pause the run"))
    panel.show(page.do(do.PauseRecognition(True)).picture)
    hand(labelled(gui, "One step"))
    hand(labelled(gui, "Go on with the run"))
    assert sent == [
        do.PauseRecognition(True),
        do.StepRecognition(),
        do.PauseRecognition(False),
    ]


def test_the_published_procedures_settings_are_there_for_it_alone(gui: viser.GuiApi) -> None:
    panel = RecognisePanel(gui, FACTS, ROBOT, lambda _: None)
    for method, visible in (("global", False), ("paper", True), ("live", False)):
        panel.show(believing().do(do.SetRecognitionOption("method", method)).picture)
        for label in ("Warm start", "Iterations", "Trials"):
            assert labelled(gui, label).visible == visible
        assert labelled(gui, "KL term, β").visible == (method != "live")
    plain = Page((make_facts(stochastic=False),)).do(do.SetTarget(TARGET)).picture
    panel.show(plain)
    assert not labelled(gui, "KL term, β").visible


def test_joints_are_chosen_by_part_and_one_by_one(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    facts = (make_facts(joints=PEPPER_JOINTS),)
    panel = RecognisePanel(gui, facts, ROBOT, sent.append)
    page = Page(facts)
    panel.show(page.picture)
    hand(labelled(gui, "Observed joints"), "left side")
    (intent,) = sent
    assert isinstance(intent, do.SetRecognitionOption)
    assert intent.value == tuple(j for j in PEPPER_JOINTS if j.startswith("L"))
    panel.show(page.do(intent).picture)
    assert not labelled(gui, "HeadYaw").value
    assert labelled(gui, "LHand").value
    hand(labelled(gui, "HeadYaw"), True)
    last = sent[-1]
    assert isinstance(last, do.SetRecognitionOption)
    assert isinstance(last.value, tuple)
    assert set(last.value) == {*intent.value, "HeadYaw"}  # type: ignore[misc]


def test_parts_of_other_bodies() -> None:
    parts = parts_of(("left_hip_yaw", "right_hip_yaw", "torso_pitch", "left_elbow"))
    assert parts["left side"] == ("left_hip_yaw", "left_elbow")
    assert parts["arms"] == ("left_elbow",)
    assert list(parts_of(("joint_1", "joint_2"))) == ["all joints"]


def test_what_is_taken_away(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    panel = RecognisePanel(gui, FACTS, ROBOT, sent.append)
    panel.show(run_to_its_end().picture)
    for label in (
        "Motion (CSV)",
        "Belief path (CSV)",
        "All of it (NPZ)",
        "Figure (PNG)",
        "Figure (SVG)",
        "Add to the map",
    ):
        hand(labelled(gui, label))
    assert sent == [
        do.DownloadMotion(),
        *map(do.TakeAwayRun, ("path", "arrays", "png", "svg")),
        do.AddToMap("given"),
    ]
    assert not labelled(gui, "Take my points away").visible
    panel.show(run_to_its_end().do(do.AddToMap("given")).picture)
    hand(labelled(gui, "Take my points away"))
    assert sent[-1] == do.RemoveAdded()


def test_the_panels_of_figure_5(gui: viser.GuiApi) -> None:
    panel = RecognisePanel(gui, FACTS, ROBOT, lambda _: None)
    page = run_to_its_end()
    panel.show(page.picture)
    curves = panel._curves
    assert curves._mu is not None
    assert curves._density is not None
    trace = page.picture.trace
    assert trace is not None
    assert page.document.run is not None
    trial = page.document.run.trial
    numbers, *mu = curves._mu.data
    assert numbers.tolist() == [1, 2, 3, 4]
    np.testing.assert_allclose(np.stack(mu, axis=1), trace.mu[:, trial])
    assert len(curves._density.data) == 4
    assert np.isnan(curves._loss.data[2]).all()  # the prediction error is not known yet
    panel.show(page.do(do.SetRevealed(True)).picture)
    assert not np.isnan(curves._loss.data[2]).any()


def test_densities_have_an_area_of_one() -> None:
    x, *curves = densities(np.array([0.0, 2.0]), np.array([0.5, 1.0]))
    for curve in curves:
        assert np.trapezoid(curve, x) == pytest.approx(1, abs=0.02)
    assert np.isfinite(np.stack(densities(np.zeros(2), np.zeros(2)))).all()


# --- the examples ---
def test_every_example_says_what_to_look_for_and_is_read() -> None:
    folder = files("rnnpb_explorer.static") / "examples"
    told = tomllib.loads((folder / "examples.toml").read_text())
    shipped = {file.name for file in folder.iterdir()}
    assert shipped == {"examples.toml", *(f"{name}.csv" for name in told)}
    for example in examples():
        reading = read_motions(example.read(), f"{example.name}.csv", PEPPER_JOINTS)
        assert len(reading.motion()) > 60
        assert len(example.look_for) > 40
        assert set(example.hidden) <= set(PEPPER_JOINTS)
    (half,) = (example for example in examples() if example.hidden)
    assert set(half.observed_joints(PEPPER_JOINTS)) == set(PEPPER_JOINTS) - set(half.hidden)
    assert half.observed_joints(("x",)) == ("x",)


def test_a_picture_of_another_length_has_no_share() -> None:
    page = believing()
    short = replace(page.document, target=make_target(7))
    assert Picture(FACTS, short, page.computed).explained is None
