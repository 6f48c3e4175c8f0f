"""Whatever a person does in whatever order, and whatever arrives in between: the document holds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import Document
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.history import LEFT_ALONE
from rnnpb_explorer.app.state.on_recognition import follow
from rnnpb_explorer.app.state.planes import inside_window
from rnnpb_explorer.app.state.results import RecognitionTrace
from rnnpb_explorer.app.state.statecode import decode, encode
from rnnpb_explorer.app.state.wanted import wanted
from rnnpb_explorer.app.state.work import RecogniseWork
from rnnpb_explorer.core.errors import InputError

from ..app_states import RUN, Page, make_facts, make_target, make_trace, opened

OTHER_JOINTS = ("v", "w", "x", "y", "z")
ALONE = {dim: (make_facts(dim, f"D{dim}"),) for dim in (1, 2, 4, 12)}
SIDE_BY_SIDE = {
    (2, 1): (make_facts(2, "two"), make_facts(1, "line", ("bow", "jump", "wave"))),
    (4, 12): (make_facts(4, "four"), make_facts(12, "wide", joints=OTHER_JOINTS)),
    (12, 2): (make_facts(12, "wide", stochastic=False), make_facts(2, "two")),
}

index = st.integers(-1, 12)
value = st.floats(-25, 25) | st.sampled_from([math.nan, math.inf, -math.inf, 1e300])
axes = st.lists(index, max_size=3).map(tuple)
point = st.lists(value, max_size=3).map(tuple)
gesture = st.integers(1, 3)
model = st.integers(0, 1)
targets = st.sampled_from([make_target(), make_target(4), make_target(joints=OTHER_JOINTS)])
labels = st.sampled_from([("μ1",), ("μ1", "μ2"), ("PC1", "PC2"), ("μ3", "μ2")])
doing = st.one_of(
    st.builds(do.SelectModel, model | index),
    st.builds(do.SelectMotion, index),
    st.builds(do.SetMu, index, value),
    st.builds(do.SetSigma, index, value),
    st.builds(do.MoveOnMap, model, axes, point, gesture),
    st.builds(do.MoveOnMap, model, st.just((0, 1)), st.tuples(value, value), gesture),
    st.builds(do.MoveOnLandscape, model, labels, st.tuples(value, value), gesture),
    st.builds(do.SetMapAxes, axes),
    st.builds(do.SetLandscapeAxes, axes | st.permutations([0, 1]).map(tuple) | st.just("pca")),
    st.builds(do.SetWindow, st.sampled_from(["absolute", "sd"])),
    st.builds(do.SetJoint, st.sampled_from(["", "a", "v", "knee"])),
    st.builds(do.SetUseTarget, st.booleans()),
    st.builds(do.SetSideBySide, st.booleans()),
    st.builds(do.SetGoal, st.sampled_from(["", "bow", "wave", "fall"])),
    st.builds(do.WalkTo, st.integers(-1, 42) | st.sampled_from(["morph", None])),
    st.builds(do.SetExportOption, st.just("file_format"), st.sampled_from(["json", "bvh"])),
    st.sampled_from([do.ResetLatent(), do.RandomiseLatent(), do.NewNoise(), do.ClearNoise()]),
)
recognising = st.one_of(
    st.builds(do.SetTarget, targets),
    st.builds(do.SetTarget, st.just(make_target())),
    st.builds(do.ScrubRecognition, index, model),
    st.builds(
        do.SetRecognitionOption,
        st.sampled_from(["observed", "iterations", "trials"]),
        st.floats(-5, 500) | st.integers(1, 4),
    ),
    st.sampled_from([do.StartRecognition(), do.CancelRecognition(), do.ClearTarget()]),
    st.just(do.StartRecognition()),
)
looking = st.one_of(
    st.builds(do.ShowSliders, index),
    st.builds(do.SetPlaying, st.booleans(), st.none() | st.floats(-5, 200)),
    st.builds(do.Seek, st.integers(-5, 200)),
    st.builds(do.SetSpeed, st.floats(-1, 9) | st.just(math.nan)),
    st.builds(do.SetLoop, st.booleans()),
    st.just(do.TogglePlaying()),
)
back = st.sampled_from([do.Undo(), do.Redo()])


def trace_of(facts: Facts, work: RecogniseWork) -> RecognitionTrace:
    """What this work comes to, the same every time; its mu leave the window, and its sigma grow."""
    random = np.random.default_rng(work.seed)
    model = next(one for one in facts if one.name == work.model)
    shape = (work.iterations + 1, work.trials, model.pb_dim)
    loss = random.random(shape[:2])[1:]
    loss[::7] = math.nan
    path = random.normal(size=shape).cumsum(axis=0)
    return make_trace(path, loss=loss, sigma=float(random.integers(0, 9)), epsilon=1.5)


def without_view(document: Document) -> Document:
    view = {name: getattr(opened(ALONE[1]), name) for name in LEFT_ALONE}
    return replace(document, **view)


class Walk:
    """A page that somebody uses in any way, checked after every step."""

    def __init__(self, facts: Facts, data: st.DataObject) -> None:
        self.page, self.data = Page(facts), data
        self.asked: list[RecogniseWork] = []  # runs, some of them long out of date

    def go(self, steps: int) -> None:
        self.page.do(do.SetTarget(make_target()), do.SetRecognitionOption("iterations", 3))
        self._do(do.StartRecognition())
        self._remember()
        kinds = (doing, recognising, looking, back, st.builds(self._code))
        for _ in range(steps):
            self.page.now += self.data.draw(st.sampled_from([0.1, 2.0]))
            if self.asked and self.data.draw(st.integers(0, 2)) == 2:
                self._arrive()
            else:
                kind = self.data.draw(st.sampled_from((*kinds, doing, recognising)))
                self._do(self.data.draw(kind))
            self._check()
            self._remember()
        self._walk_back()

    def _code(self) -> do.RestoreCode:
        past = self.data.draw(st.sampled_from((*self.page.history.past[-5:], self.page.document)))
        return do.RestoreCode(encode(past))

    def _do(self, intent: do.DocumentIntent | do.HistoryIntent) -> None:
        page = self.page
        before, history = page.document, page.history
        try:
            page.do(intent)
        except InputError:
            assert page.history is history
            return
        if isinstance(intent, do.Undo | do.Redo) or page.history.past == history.past:
            return  # no step of its own
        after = page.history.present
        undone = page.history.undo()
        assert without_view(undone.present) == without_view(before)
        assert without_view(undone.redo().present) == without_view(after)
        assert wanted(page.facts, undone.present) == wanted(page.facts, before)
        assert wanted(page.facts, undone.redo().present) == wanted(page.facts, after)

    def _arrive(self) -> None:
        """Something of a run that was asked for: iterations, or its failure."""
        page, work = self.page, self.data.draw(st.sampled_from(self.asked[-3:]))
        steps = self.data.draw(st.integers(1, 5) | st.just(work.iterations) | st.none())
        if steps is None:
            if page.wanted.get(RUN) == work:
                page.fail(RUN, "broken")
            return
        trace = trace_of(page.facts, work).first(steps)
        page.deliver(RUN, trace, done=trace.iterations == work.iterations, work=work)

    def _remember(self) -> None:
        work = self.page.missing.get(RUN)
        if isinstance(work, RecogniseWork):
            self.asked.append(work)

    def _check(self) -> None:
        page, document = self.page, self.page.document
        assert decode(page.facts, encode(document)) == document  # within the bounds, too
        run, trace = document.run, page.picture.trace
        for index, (one, choice) in enumerate(zip(page.facts, document.models, strict=True)):
            passing = run is not None and document.running and run.model == index
            assert passing or inside_window(one, document, choice)
            assert (("landscape", index) in page.wanted) is not passing
        if run is not None and trace is not None:
            assert follow(page.facts, document, trace) == document
            assert 0 < trace.iterations <= run.settings.iterations
        assert document.running == (page.picture.run_status == "running")
        assert page.missing.keys() <= page.wanted.keys()

    def _walk_back(self) -> None:
        """All the way to the opening document, and again to the last."""
        history, ways = self.page.history, 0
        while history.past:
            history, ways = history.undo(), ways + 1
            decode(self.page.facts, encode(history.present))
        assert without_view(history.present) == without_view(opened(self.page.facts))
        for _ in range(ways):
            history = history.redo()
        assert without_view(history.present) == without_view(self.page.document)


@pytest.mark.parametrize("dim", ALONE)
@given(st.data())
@settings(max_examples=15)
def test_one_model_holds(dim: int, data: st.DataObject) -> None:
    Walk(ALONE[dim], data).go(steps=25)


@pytest.mark.parametrize("dims", SIDE_BY_SIDE, ids=str)
@given(st.data())
@settings(max_examples=15)
def test_models_side_by_side_hold(dims: tuple[int, int], data: st.DataObject) -> None:
    Walk(SIDE_BY_SIDE[dims], data).go(steps=25)
