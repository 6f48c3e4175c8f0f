"""What is computed for a page: the newest result in each slot, and whether it is what is wanted.

Nothing here is ever undone or shared: it can be computed again from the document. One result a slot
is kept, so that a page's memory does not grow.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from .results import CodebookResult, RecognitionTrace, Result
from .work import RecogniseWork, Slot, Work

LASTING = ("motion", "landscape", "belief", "stretch")  # shown until the next one is there


@dataclass(frozen=True, eq=False)
class Entry:
    work: Work
    result: Result
    done: bool  # no further stage will come

    def answers(self, work: Work) -> bool:
        """Whether this is a stage of what that work comes to."""
        return _identity(self.work) == _identity(work)

    def satisfies(self, work: Work) -> bool:
        """Whether nothing is left to compute for that work."""
        if not self.answers(work):
            return False
        if isinstance(work, RecogniseWork) and isinstance(self.result, RecognitionTrace):
            return work.is_met_by(self.result)
        return self.done

    @property
    def stage(self) -> int:
        """How far it came: of two answers to one work, the one that came further is shown."""
        trace = self.result
        if isinstance(trace, RecognitionTrace):
            return 2 * trace.iterations + int(trace.finished)
        return int(self.done)


@dataclass(frozen=True, eq=False)
class Computed:
    """Immutable, so that what is shown does not change while it is shown."""

    entries: Mapping[Slot, Entry]
    failures: Mapping[Slot, tuple[Work, str]]  # of works that are still wanted

    @classmethod
    def nothing(cls) -> Computed:
        return cls({}, {})

    def codebook_entries(self, model: int) -> int:
        """How many motions of a model's codebook there are by now."""
        entry = self.entries.get(("codebook", model))
        return entry.result.entries if entry and isinstance(entry.result, CodebookResult) else 0

    def missing(self, wanted: Mapping[Slot, Work]) -> dict[Slot, Work]:
        """What of this has still to be computed."""
        return {
            slot: work
            for slot, work in wanted.items()
            if not (slot in self.entries and self.entries[slot].satisfies(work))
            and not (isinstance(work, RecogniseWork) and work.iterations == 0)
        }

    def put(self, wanted: Mapping[Slot, Work], slot: Slot, entry: Entry) -> Computed:
        """With a new result; an outdated one is kept only until there is none that is current."""
        known, work = self.entries.get(slot), wanted.get(slot)
        if work is None:
            return self
        late = not entry.answers(work) or (known is not None and entry.stage < known.stage)
        if known is not None and known.answers(work) and late:
            return self
        return replace(self, entries={**self.entries, slot: entry})

    def fail(self, slot: Slot, work: Work, message: str) -> Computed:
        return replace(self, failures={**self.failures, slot: (work, message)})

    def without(self, slot: Slot) -> Computed:
        return replace(self, entries={s: e for s, e in self.entries.items() if s != slot})

    def keep(self, wanted: Mapping[Slot, Work]) -> Computed:
        """Without the results of slots that the document has no more, and outdated failures."""
        entries = {
            slot: entry
            for slot, entry in self.entries.items()
            if _of_model_there(wanted, slot, entry.work)
            and (
                slot[0] in LASTING
                or (slot in wanted and (slot[0] != "recognition" or entry.answers(wanted[slot])))
            )
        }
        failures = {
            slot: (work, message)
            for slot, (work, message) in self.failures.items()
            if slot in wanted and _identity(work) == _identity(wanted[slot])
        }
        return replace(self, entries=entries, failures=failures)


def _of_model_there(wanted: Mapping[Slot, Work], slot: Slot, work: Work) -> bool:
    """Whether a place still has the model that this was computed with."""
    there = wanted.get(slot) or wanted.get(("motion", slot[1]))
    return getattr(there, "model", None) == getattr(work, "model", None)


def _identity(work: Work) -> Work:
    """How many iterations of a run are wanted is no part of what the run is."""
    return replace(work, iterations=0) if isinstance(work, RecogniseWork) else work
