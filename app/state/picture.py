"""What is on the screen: a document and what is computed of it by now. Panels draw this."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from ...core.recognition_run import Posterior
from ...core.verdict import Explained, explained
from ...core.windows import Landscape
from .computed import Computed
from .document import Document, ModelChoice, Run
from .facts import Facts, ModelFacts
from .on_recognition import at_best
from .planes import fitting_axes
from .results import (
    BeliefResult,
    CheckedMotion,
    CodebookResult,
    ExportedFile,
    LandscapeResult,
    MotionResult,
    RecognitionTrace,
    StretchResult,
    WaysResult,
)
from .wanted import (
    GHOSTS,
    export_work,
    given_target,
    joint_indices,
    known_reference,
    known_ways,
    landscape_work,
    recognise_work,
    seen_target,
    ways_work,
)
from .work import LandscapeWork, Slot

RunStatus = Literal["idle", "running", "finished", "cancelled", "failed"]


@dataclass(frozen=True, eq=False)
class Picture:
    """One page's screen. What has been computed may be behind the document, and says so."""

    facts: Facts
    document: Document
    computed: Computed

    def of(self, model: int) -> Picture:
        """The same as if that model were the active one, along axes that it has."""
        if model == self.document.active:
            return self
        document, dim = self.document, self.facts[model].pb_dim
        axes = document.landscape_axes
        document = replace(
            document,
            active=model,
            map_axes=fitting_axes(document.map_axes, dim),
            landscape_axes="pca" if axes == "pca" else fitting_axes(axes, dim),
        )
        return Picture(self.facts, document, self.computed)

    @property
    def active(self) -> int:
        return self.document.active

    @property
    def model(self) -> ModelFacts:
        """The model that the boards, sliders and recognition speak of."""
        return self.facts[self.active]

    @property
    def choice(self) -> ModelChoice:
        return self.document.current

    # --- motions ---
    def motion(self, index: int | None = None) -> NDArray[np.float32] | None:
        """(T, J) the newest motion of a model, by default of the active one."""
        entry = self.computed.entries.get(("motion", self.active if index is None else index))
        return entry.result.positions if entry and isinstance(entry.result, MotionResult) else None

    def reference(self, index: int | None = None) -> NDArray[np.float32] | None:
        """(T', J) what a model's motion is compared with."""
        index = self.active if index is None else index
        known = known_reference(self.facts, self.document, index)
        if known is not None:
            return known
        entry = self.computed.entries.get(("reference", index))
        return entry.result.positions if entry and isinstance(entry.result, MotionResult) else None

    @cached_property
    def seen_target(self) -> NDArray[np.float32] | None:
        """(T', J) of the active model's target what one may see."""
        return seen_target(self.facts, self.document, self.active)

    def ghosts(self, index: int) -> tuple[NDArray[np.float32], ...]:
        """(T, J) each: the newest samples of a model, once all of them are there.

        While it walks to the goal, its motion on the shortest way. Without either, what the belief
        is torn between, where that is more than one thing.
        """
        if self.document.walk is not None:
            walk = self.computed.entries.get(("walk", index))
            there = walk.result if walk else None
            return (there.positions,) if isinstance(there, MotionResult) else ()
        if not self.document.ghosts:
            torn = self.belief if index == self.active and self.document.explanations else None
            return torn.motions if torn is not None and len(torn.motions) > 1 else ()
        slots: list[Slot] = [("ghost", GHOSTS * index + number) for number in range(GHOSTS)]
        results = [self.computed.entries[s].result for s in slots if s in self.computed.entries]
        motions = tuple(r.positions for r in results if isinstance(r, MotionResult))
        whole = len(motions) == GHOSTS and len({len(motion) for motion in motions}) == 1
        return motions if whole else ()

    @property
    def checked(self) -> CheckedMotion | None:
        """What the active model's newest motion asks of the robot; comes after the motion."""
        entry = self.computed.entries.get(("motion", self.active))
        return entry.result.check if entry and isinstance(entry.result, MotionResult) else None

    # --- the landscape ---
    @property
    def landscape(self) -> tuple[LandscapeWork, Landscape] | None:
        """The active model's newest one, and what was asked for: it may be of another plane."""
        entry = self.computed.entries.get(("landscape", self.active))
        if entry is None or not isinstance(entry.result, LandscapeResult):
            return None
        assert isinstance(entry.work, LandscapeWork)
        return entry.work, entry.result.values

    @cached_property
    def landscape_complete(self) -> bool:
        """Whether the active model's landscape is the one that is wanted now, every cell of it."""
        entry = self.computed.entries.get(("landscape", self.active))
        return (
            entry is not None
            and entry.done
            and not self._passing_through
            and entry.answers(landscape_work(self.facts, self.document, self.active))
        )

    @property
    def _passing_through(self) -> bool:
        run = self.document.run
        return run is not None and not run.settled and run.model == self.active

    # --- recognition ---
    @cached_property
    def trace(self) -> RecognitionTrace | None:
        """The iterations of the document's run, as far as it went; None where there is none."""
        work = recognise_work(self.facts, self.document)
        entry = self.computed.entries.get(("recognition", 0))
        if work is None or work.iterations == 0 or entry is None or not entry.answers(work):
            return None
        assert isinstance(entry.result, RecognitionTrace)
        run = self.document.run
        return None if run is None or run.done == 0 else entry.result.first(run.done)

    @property
    def whole_trace(self) -> RecognitionTrace | None:
        """All iterations that are there, those that are not to be shown yet, too."""
        work = recognise_work(self.facts, self.document)
        entry = self.computed.entries.get(("recognition", 0))
        if work is None or entry is None or not entry.answers(work):
            return None
        return entry.result if isinstance(entry.result, RecognitionTrace) else None

    @property
    def run_status(self) -> RunStatus:
        run = self.document.run
        if run is None:
            return "idle"
        if not run.settled:
            return "running"
        if self.run_failure:
            return "failed"
        return "finished" if run.finished else "cancelled"

    @property
    def run_failure(self) -> str:
        """Why the run broke off; "" where it did not."""
        return self.computed.failures.get(("recognition", 0), (None, ""))[1]

    @property
    def drawn_run(self) -> tuple[Run, RecognitionTrace] | None:
        """The run and its iterations, where they belong to the active model's boards."""
        run, trace = self.document.run, self.trace
        if run is None or trace is None or run.model != self.active:
            return None
        return run, trace

    @property
    def posterior(self) -> Posterior | None:
        """The Gaussian belief where the active model stands, once a run has ended there."""
        drawn = self.drawn_run
        if drawn is None or not drawn[0].follows or not at_best(drawn[0]):
            return None
        return drawn[1].posterior

    @property
    def belief(self) -> BeliefResult | None:
        """The active model's newest belief over its codebook, where it is shown."""
        shown = self.document.cloud and given_target(self.facts, self.document, self.active)
        entry = self.computed.entries.get(("belief", self.active))
        if not shown or entry is None or not isinstance(entry.result, BeliefResult):
            return None
        return entry.result

    @property
    def codebook(self) -> CodebookResult | None:
        """How far the active model's codebook has grown."""
        entry = self.computed.entries.get(("codebook", self.active))
        return entry.result if entry and isinstance(entry.result, CodebookResult) else None

    def stretch(self, index: int) -> StretchResult | None:
        """A model's newest one; it may be behind the puck."""
        entry = self.computed.entries.get(("stretch", index))
        return entry.result if entry and isinstance(entry.result, StretchResult) else None

    def ways(self, index: int) -> WaysResult | None:
        """From a model's selected motion to the goal."""
        return known_ways(self.facts, self.document, index, self.computed)

    @property
    def ways_wanted(self) -> bool:
        """Whether there is a way from the active model's selected motion."""
        return ways_work(self.facts, self.document, self.active) is not None

    @cached_property
    def explained(self) -> Explained | None:
        """How much of the target the active model's motion explains, as it was observed."""
        document, motion = self.document, self.motion()
        target = given_target(self.facts, document, self.active)
        if target is None or motion is None or len(motion) != len(target):
            return None
        run = document.run
        ours = run is not None and run.model == self.active
        settings = run.settings if run is not None and ours else document.recognition
        joints = joint_indices(self.model, settings.joints)
        observed = max(1, int(settings.observed * len(target)))
        return explained(motion, target.array, observed, joints or None)

    # --- files ---
    @property
    def exported(self) -> str:
        """One line on the file that was written of this very motion with these very options."""
        entry = self.computed.entries.get(("export", 0))
        if entry is None or not isinstance(entry.result, ExportedFile):
            return ""
        work = export_work(self.facts, self.document)
        return entry.result.summary if entry.answers(work) else ""
