"""Whatever a person does in whatever order, and however late workers answer: the screen holds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rnnpb_explorer.app.page.panels.playback import frame_of
from rnnpb_explorer.app.page.panels.readout import readout
from rnnpb_explorer.app.page.panels.recognise import status_line
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import AppState, initial_state
from rnnpb_explorer.app.state.slices import drawable_axes, inside_window, landscape_slice
from rnnpb_explorer.app.state.statecode import decode, encode
from rnnpb_explorer.app.state.transitions import Facts, opening_work, target_of
from rnnpb_explorer.app.state.update import update

from .app_states import (
    after,
    landscape_result,
    make_facts,
    make_trace,
    motion_result,
    target_motion,
)

SIDE_BY_SIDE = (
    make_facts(3, "three"),
    make_facts(1, "line", ("bow", "jump", "wave")),
    make_facts(12, "wide", joints=("v", "w", "x", "y", "z")),
)
ALONE = (make_facts(3, "three"),)

index = st.integers(-1, 12)
value = st.floats(-25, 25) | st.sampled_from([math.nan, math.inf, -math.inf])
axes = st.lists(index, max_size=3).map(tuple)
point = st.lists(value, max_size=3).map(tuple)
gesture = st.integers(1, 3)
targets = st.sampled_from(
    [target_motion(10), target_motion(4, "other"), target_motion(joints=("v", "w", "x", "y", "z"))]
)
codes = st.sampled_from(
    [
        encode(facts, state)
        for facts in (ALONE, SIDE_BY_SIDE)
        for opened in [initial_state(facts)]
        for state in (
            opened,
            after(facts, opened, do.SelectModel(1), do.RandomiseLatent(), do.SetWindow("sd")),
            after(facts, opened, do.SetTarget(target_motion(10)), do.SetLandscapeAxes("pca")),
        )
    ]
)
intents = st.one_of(
    st.builds(do.SelectModel, index),
    st.builds(do.SelectMotion, index),
    st.builds(do.SetMu, index, value),
    st.builds(do.SetSigma, index, value),
    st.builds(do.MoveOnMap, axes, point, gesture),
    st.builds(do.MoveOnMap, st.just((0, 1)), st.tuples(value, value), gesture),
    st.builds(do.MoveOnLandscape, point, gesture),
    st.builds(do.SetMapAxes, axes),
    st.builds(do.SetLandscapeAxes, axes | st.just("pca")),
    st.builds(do.SetWindow, st.sampled_from(["absolute", "sd"])),
    st.builds(do.Tick, st.floats(0, 100)),
    st.builds(do.Seek, st.integers(-5, 200)),
    st.builds(do.SetLoop, st.booleans()),
    st.builds(do.SetSpeed, st.floats(-1, 9)),
    st.builds(do.SetUseTarget, st.booleans()),
    st.builds(do.SetSideBySide, st.booleans()),
    st.builds(do.SetEyes, st.booleans()),
    st.builds(do.SetExportOption, st.just("file_format"), st.sampled_from(["json", "bvh"])),
    st.builds(do.SetTarget, targets),
    st.builds(do.RestoreCode, codes),
    st.builds(do.RefuseTarget, st.text(max_size=5)),
    st.builds(do.ScrubRecognition, index, index),
    st.builds(
        do.SetRecognitionOption,
        st.sampled_from(["observed", "iterations", "trials"]),
        st.floats(-5, 500),
    ),
    st.sampled_from(
        [
            *(do.ResetLatent(), do.RandomiseLatent(), do.NewNoise(), do.ClearNoise()),
            *(do.Undo(), do.Redo(), do.TogglePlaying(), do.SetPlaying(True)),
            do.ExportMotion(),
            *(do.StartRecognition(), do.CancelRecognition(), do.ClearTarget()),
        ]
    ),
)


class Screen:
    """A state with the work that it has asked for, and what of it has been told to stop."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self.asked: list[do.Work] = []
        self.wanted_run: int | None = None  # request of the run that a worker is at
        self.state, works = opening_work(facts, initial_state(facts))
        self._take(works)

    def do(self, intent: do.Intent) -> None:
        self.state, works = update(self.facts, self.state, intent)
        self._take(works)
        self.check()

    def _take(self, works: tuple[do.Work, ...]) -> None:
        for work in works:
            if isinstance(work, do.CancelRecogniseWork):
                self.wanted_run = None
                continue
            self.asked.append(work)
            if isinstance(work, do.RecogniseWork):
                self.wanted_run = work.request

    def answer(self, work: do.Work, how: int) -> None:
        """A worker reports on work, which may be long out of date."""
        if isinstance(work, do.GenerateWork):
            self.do(motion_result(work))
        elif isinstance(work, do.LandscapeWork):
            self.do(landscape_result(work, complete=how > 0))
        elif isinstance(work, do.RecogniseWork):
            dim = self.facts[work.model].pb_dim
            path = np.linspace(-1, 1, (how + 2) * work.trials * dim)
            trace = make_trace(path.reshape(how + 2, work.trials, dim))
            self.do(do.RecognitionStepped(work.request, trace))
            if how == 3:
                self._over(work)
                self.do(do.WorkFailed("recognition", work.request, "broken"))
            elif how > 0:
                self._over(work)
                self.do(do.RecognitionFinished(work.request))

    def _over(self, work: do.RecogniseWork) -> None:
        if self.wanted_run == work.request:
            self.wanted_run = None

    def check(self) -> None:
        state, facts = self.state, self.facts
        current = facts[state.active]
        assert drawable_axes(state.map_axes, current.pb_dim)
        assert state.landscape_axes == "pca" or drawable_axes(state.landscape_axes, current.pb_dim)
        assert 0.0 <= state.playback.phase <= 1.0
        self._check_run(state)
        for number, (one, model) in enumerate(zip(facts, state.models, strict=True)):
            latent = model.latent
            for vector in (latent.mu, latent.sigma, latent.epsilon, model.anchor):
                assert vector.shape == (one.pb_dim,)
                assert np.isfinite(vector).all()
            if model.motion is not None:
                assert 0 <= frame_of(state, number) < len(model.motion.positions)
        # What is drawn of the active model is what was asked for, the puck inside its window.
        if state.recognition.status != "running":
            where = landscape_slice(current, state, state.current)
            asked = state.current.landscape_asked
            assert asked is not None
            np.testing.assert_allclose(asked.center, where.center, atol=1e-8)
            np.testing.assert_allclose(asked.directions, where.directions, atol=1e-8)
            assert asked.radius == where.radius
            assert asked.target is target_of(facts, state, state.active)
            assert inside_window(current, state, state.current)
        assert readout(current, state)
        assert status_line(state.recognition) is not None

    def _check_run(self, state: AppState) -> None:
        """It is running on the screen exactly when a worker is at it, undone or not."""
        running = state.recognition.status == "running"
        assert running == (self.wanted_run is not None)
        if running:
            assert state.recognition.request == self.wanted_run
        for moment in (*state.undo, *state.redo):
            assert moment.recognition.status != "running"


def play(facts: Facts, data: st.DataObject, steps: int) -> Screen:
    screen = Screen(facts)
    for _ in range(steps):
        if data.draw(st.integers(0, 3)) == 0:
            work = data.draw(st.sampled_from(screen.asked[-6:]))
            screen.answer(work, data.draw(st.integers(0, 3)))
        else:
            screen.do(data.draw(intents))
    return screen


@given(st.data())
@settings(deadline=None, max_examples=60)
def test_one_model_holds(data: st.DataObject) -> None:
    play(ALONE, data, steps=25)


@given(st.data())
@settings(deadline=None, max_examples=60)
def test_models_side_by_side_hold(data: st.DataObject) -> None:
    play(SIDE_BY_SIDE, data, steps=25)


@given(st.data())
@settings(deadline=None, max_examples=20)
def test_every_screen_that_can_be_reached_has_a_code(data: st.DataObject) -> None:
    screen = play(SIDE_BY_SIDE, data, steps=15)
    code = encode(screen.facts, screen.state)
    # A code says whether an upload is looked at; with the same one there, the same code comes out.
    here = replace(initial_state(screen.facts), recognition=screen.state.recognition)
    assert encode(screen.facts, decode(screen.facts, here, code)) == code
