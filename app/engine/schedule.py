"""Which piece comes next, and for whom: logic alone, without threads, clock or lock.

A page has a place for each slot; a place has a job while something is computed for it, and pages
that want the same share one. What comes next is decided anew for every piece.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count

from ..state.results import RecognitionTrace, Result
from ..state.work import Slot, Work
from .cache import Cache
from .deliveries import Delivered, Delivery, Failed
from .job import Priority, Round, Stage, Steps, Task


@dataclass(eq=False)
class Client:
    """A page as the schedule knows it.

    served: when a piece was last taken for it, by priority, as a number that grows.
    post: what it has not been told yet. called: somebody is telling it.
    """

    deliver: Callable[[Delivery], None]
    places: dict[Slot, Place] = field(default_factory=dict)
    served: dict[Priority, int] = field(default_factory=dict)
    post: deque[Delivery] = field(default_factory=deque)
    called: bool = False


@dataclass(eq=False)
class Place:
    """One slot of a page.

    work: what is wanted there. turn: grows from who came or was served first to who was last; newer
        work that takes the place of one that waits keeps it.
    job: what is under way for it: of this work, or of an older one that is being finished.
    """

    client: Client
    slot: Slot
    work: Work
    turn: int
    job: Job | None = None


@dataclass(eq=False)
class Job:
    """A work under way.

    waiting: tasks of the round with a piece to do. taken: tasks that workers have.
    begun: since the last stage a piece was taken. over: it needs no more.
    """

    work: Work
    steps: Steps
    places: dict[Place, None] = field(default_factory=dict)  # a set that keeps its order
    round: Round | None = None
    waiting: deque[Task] = field(default_factory=deque)
    taken: int = 0
    latest: Result | None = None
    begun: bool = False
    over: bool = False

    @property
    def finishing(self) -> bool:
        """Whether it goes on to its next stage whatever newer work comes."""
        return self.begun and self.round is not None and self.round.finish


@dataclass(frozen=True)
class Progress:
    """How far a job came between two rounds: stages, then a round, a fault, or the end."""

    stages: Sequence[Stage]
    round: Round | None = None
    fault: str | None = None


Batch = list[tuple[Job, Task]]


class Schedule:
    """All pages' work.

    Args:
        begin: the steps of a work that is wanted since a time.
        advance: has a job go on to its next round; raises nothing.
    """

    def __init__(
        self,
        begin: Callable[[Work, float], Steps],
        advance: Callable[[Job], Progress],
        cache: Cache,
    ) -> None:
        self._begin, self._advance, self._cache = begin, advance, cache
        self._jobs: dict[Work, Job] = {}
        self._mail: dict[Client, None] = {}
        self._numbers = count()

    # --- what pages want ---
    def want(self, client: Client, works: Mapping[Slot, Work], now: float) -> None:
        """All that a page wants from now on."""
        for slot in client.places.keys() - works.keys():
            self._leave(client.places.pop(slot))
        for slot, work in works.items():
            place = client.places.get(slot)
            if place is None:
                place = Place(client, slot, work, next(self._numbers))
                client.places[slot] = place
                self._start(place, now)
            elif place.work != work:
                self._replace(place, work, now)

    def drop(self, client: Client) -> None:
        """A page has gone."""
        self.want(client, {}, 0.0)
        client.post.clear()
        self._mail.pop(client, None)

    def _replace(self, place: Place, work: Work, now: float) -> None:
        place.work = work
        if place.job is not None and place.job.finishing:
            return  # the newest follows when that is done
        if place.job is None:
            place.turn = next(self._numbers)
        self._leave(place)
        self._start(place, now)

    def _start(self, place: Place, now: float) -> None:
        known = self._cache.get(place.work)
        if known is not None:
            self._post(place, Delivered(place.slot, place.work, known, done=True))
            return
        job = self._jobs.get(place.work)
        if job is not None:
            job.places[place], place.job = None, job
            if job.latest is not None:
                self._post(place, Delivered(place.slot, job.work, job.latest, done=False))
            return
        job = Job(place.work, self._begin(place.work, now), {place: None})
        self._jobs[job.work] = place.job = job
        self.progress(job, self._advance(job), now)

    def _leave(self, place: Place) -> None:
        job, place.job = place.job, None
        if job is not None:
            del job.places[place]
            if not job.places:
                self._end(job)

    def _end(self, job: Job) -> None:
        job.over = True
        job.waiting.clear()
        if self._jobs.get(job.work) is job:
            del self._jobs[job.work]

    # --- what workers do ---
    def take(self, now: float) -> Batch:
        """The next piece to do, and others that are done in the same call; [] = none for now."""
        ready = [job for job in self._jobs.values() if _ready(job, now)]
        if not ready:
            return []
        ready.sort(key=self._rank)
        batch = [self._take(ready[0], ready[0].waiting[0])]
        for job in ready:
            for task in list(job.waiting):
                if task.joins([one for _, one in batch]):
                    batch.append(self._take(job, task))
        return batch

    def _rank(self, job: Job) -> tuple[Priority, bool, tuple[int, int]]:
        """Of one priority what is to be finished, then the page served least recently."""
        assert job.round is not None
        priority = job.round.priority
        first = min((place.client.served.get(priority, -1), place.turn) for place in job.places)
        return priority, not job.finishing, first

    def _take(self, job: Job, task: Task) -> tuple[Job, Task]:
        assert job.round is not None
        job.waiting.remove(task)
        job.taken += 1
        job.begun = True
        number = next(self._numbers)
        for place in job.places:
            place.client.served[job.round.priority] = place.turn = number
        return job, task

    def busy(self, now: float) -> bool:
        """Whether there is anything to do or to tell right now."""
        if any(_ready(job, now) for job in self._jobs.values()):
            return True
        return any(not client.called for client in self._mail)

    def next_time(self, now: float) -> float | None:
        """When there will be a piece to do that has to wait until then."""
        times = [job.round.not_before for job in self._jobs.values() if job.waiting and job.round]
        return min((time for time in times if time > now), default=None)

    def stepped(self, job: Job, task: Task, *, finished: bool) -> bool:
        """A piece was done; whether the round is over, and the job can go on."""
        job.taken -= 1
        if not finished and not job.over:
            job.waiting.appendleft(task)  # what was begun first, or it would pile up
        return not (job.over or job.waiting or job.taken)

    def progress(self, job: Job, progress: Progress, now: float) -> None:
        """Tell of what a job came to, and queue what it needs next."""
        for stage in progress.stages:
            if job.over:
                return
            self._tell(job, stage, now)
        if job.over:
            return
        if progress.fault is not None:
            self.fail(job, progress.fault, now)
        elif progress.round is not None:
            job.round = progress.round
            job.waiting.extend(progress.round.tasks)
        else:
            self._detach(job, now)

    def fail(self, job: Job, message: str, now: float) -> None:
        """A job has met a fault: whoever wants it is told, once."""
        if not job.over:
            for place in job.places:
                self._post(place, Failed(place.slot, job.work, message))
            self._detach(job, now)

    def _tell(self, job: Job, stage: Stage, now: float) -> None:
        job.latest, job.begun = stage.result, False
        if stage.done or isinstance(stage.result, RecognitionTrace):
            self._cache.put(job.work, stage.result)
        for place in job.places:
            self._post(place, Delivered(place.slot, job.work, stage.result, stage.done))
        if stage.done:
            self._detach(job, now)
            return
        for place in [place for place in job.places if place.work != job.work]:
            self._leave(place)
            self._start(place, now)

    def _detach(self, job: Job, now: float) -> None:
        """End a job that has come to something; places that want newer work go on to that."""
        places = list(job.places)
        self._end(job)
        for place in places:
            place.job = None
        for place in places:
            if place.work != job.work:
                self._start(place, now)

    # --- what pages are told ---
    def _post(self, place: Place, delivery: Delivery) -> None:
        place.client.post.append(delivery)
        self._mail[place.client] = None

    def mail(self) -> tuple[Client, list[Delivery]] | None:
        """What one page has to be told, in order; nobody else tells it anything before `told`."""
        for client in self._mail:
            if not client.called:
                client.called = True
                del self._mail[client]
                deliveries = list(client.post)
                client.post.clear()
                return client, deliveries
        return None

    def told(self, client: Client) -> None:
        client.called = False


def _ready(job: Job, now: float) -> bool:
    return bool(job.waiting) and job.round is not None and job.round.not_before <= now
