"""What is on the screen: a document and what is computed of it by now. Panels draw this."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.windows import Landscape
from .computed import Computed
from .document import Document, ModelChoice, Run
from .facts import Facts, ModelFacts
from .results import (
    CheckedMotion,
    ExportedFile,
    LandscapeResult,
    MotionResult,
    RecognitionTrace,
)
from .wanted import (
    GHOSTS,
    export_work,
    known_reference,
    landscape_work,
    recognise_work,
    seen_target,
)
from .work import LandscapeWork, Slot

RunStatus = Literal["idle", "running", "finished", "cancelled", "failed"]


@dataclass(frozen=True, eq=False)
class Picture:
    """One page's screen. What has been computed may be behind the document, and says so."""

    facts: Facts
    document: Document
    computed: Computed

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
        """GHOSTS of (T, J): the newest samples of a model, once all of them are there."""
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
        work = recognise_work(self.document)
        entry = self.computed.entries.get(("recognition", 0))
        if work is None or work.iterations == 0 or entry is None or not entry.answers(work):
            return None
        assert isinstance(entry.result, RecognitionTrace)
        return entry.result.first(work.iterations)

    @property
    def run_status(self) -> RunStatus:
        run = self.document.run
        if run is None:
            return "idle"
        if not run.settled:
            return "running"
        if self.run_failure:
            return "failed"
        return "finished" if run.complete else "cancelled"

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

    # --- files ---
    @property
    def exported(self) -> str:
        """One line on the file that was written of this very motion with these very options."""
        entry = self.computed.entries.get(("export", 0))
        if entry is None or not isinstance(entry.result, ExportedFile):
            return ""
        work = export_work(self.facts, self.document)
        return entry.result.summary if entry.answers(work) else ""
