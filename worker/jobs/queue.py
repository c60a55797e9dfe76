"""Jobs as the API sees them: submit, look up, cancel, keep for ever.

All state is in Redis, so any number of API processes can serve the same jobs.

Pinned answers, such as those that a paper cites, are kept for ever: their results have no lifetime, in Redis
or as addresses of the archive, and neither has the question by which the id of a job finds them.
"""

from __future__ import annotations

import json
import time
import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Self, cast

from redis import Redis
from redis.exceptions import RedisError

from worker.answers import JobRequest
from worker.answers.kinds import Answer, as_kept, known_answer, missing_parts, request_from_json
from worker.answers.layout import kind_of
from worker.answers.store import ResultStore
from worker.answers.tables import StoredTable
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkQueue
from worker.jobs.clients import JobView, Listing, Quotas, Subscriber, Subscription, Subscriptions, job_view
from worker.jobs.installation import Readiness, Roster, Versions, readiness
from worker.jobs.plan import InRedis, Plan, QueuePosition, plan
from worker.jobs.records import JobRecords
from worker.lua import Scripts
from worker.settings import WorkerSettings

_REWRITE_SECONDS = 10.0  # before a question that was kept is written again
_MAX_REMEMBERED = 10_000


class JobLookup(InRedis):
    """Finds jobs of any version of the solver, and their answers."""

    def __init__(self, redis: Redis, settings: WorkerSettings | None = None) -> None:
        super().__init__(redis, settings or WorkerSettings())
        self.store = ResultStore(redis, self.settings)
        self.records = JobRecords(redis, self.settings)
        self.listing = Listing(redis, self.settings)
        self.versions = Versions(redis, self.settings)
        self._remembered: dict[str, float] = {}
        self._of_others: dict[str, Self] = {}

    def known(self, request: JobRequest) -> Answer | None:
        """Returns the complete answer if it is known or follows from known documents, else None."""
        return known_answer(request, self.store)

    def get(self, job_id: str) -> JobView | None:
        """Returns the current state of a job of any version of the solver, or None if there is none."""
        view = self.records.view(job_id)
        if view is None and (other := self._other(job_id)) is not None:
            return other.records.view(job_id)
        return view

    def of(self, job_id: str) -> Self:
        """Returns the queue of the version of the solver to which a job belongs that was looked up."""
        return self._of_others.get(job_id, self)

    def _other(self, job_id: str) -> Self | None:
        """Returns the queue of another version of the solver that has a job, or None."""
        version = self.versions.other_of(job_id)
        if version is None:
            return None
        if len(self._of_others) >= _MAX_REMEMBERED:
            self._of_others.clear()
        return self._of_others.setdefault(job_id, type(self)(self.redis, self.settings.of_version(version)))

    def result(self, job_id: str) -> Answer | None:
        """Returns the answer of a job that succeeded, or None if it did not or its results have expired."""
        return self.outcome(job_id)[1]

    def outcome(self, job_id: str) -> tuple[JobView | None, Answer | None]:
        """Returns the current state of a job, None if there is none, and its answer as `result` does."""
        record = self.records.request(job_id)
        if record is None:
            other = self._other(job_id)
            return (None, None) if other is None else other.outcome(job_id)
        view, request, errors = record
        if view.status != "succeeded":
            return view, None
        answer = known_answer(request, self.store, errors)
        return view, answer if answer is not None else self._stopped(job_id)

    def _stopped(self, job_id: str) -> Answer | None:
        """The best that a search had found when it was stopped, which is the answer of its job alone."""
        stopped = cast("bytes | None", self.redis.hget(self.keys.job(job_id).record, "stopped"))
        text = None if stopped is None else self.store.get_text(stopped.decode())
        return None if text is None else cast(Answer, json.loads(text))

    def remember(self, request: JobRequest) -> bool:
        """Keep a question with a known answer, for `asked`; returns False if Redis refuses."""
        now = time.monotonic()
        if now - self._remembered.get(request.job_id, -_REWRITE_SECONDS) < _REWRITE_SECONDS:
            return True
        key, ttl = self.store.keys.question(request.job_id), self.settings.job_ttl
        try:
            self.store.keep_text(key, _kept_text(request), ttl)
        except RedisError:
            return False
        if len(self._remembered) >= _MAX_REMEMBERED:
            self._remembered.clear()
        self._remembered[request.job_id] = now
        return True

    def kept_answer(self, job_id: str) -> Answer | None:
        """Returns the answer to a question that is kept, or None if there is none or it has expired."""
        kept = self._kept_question(job_id)
        if kept is None:
            other = self._other(job_id)
            return None if other is None else other.kept_answer(job_id)
        return self.known(kept)

    def question(self, job_id: str) -> JobRequest | None:
        """Returns what was asked in a job that succeeded, or answered without one; None if not known."""
        record = self.records.request(job_id)
        if record is not None and record[0].status == "succeeded":
            return record[1]
        return self._kept_question(job_id)

    def _kept_question(self, job_id: str) -> JobRequest | None:
        """Returns a question that was answered without a job, if it is kept."""
        kept = cast("bytes | None", self.redis.get(self.store.keys.question(job_id)))
        if kept is None:
            return None
        return request_from_json(zlib.decompress(kept), self.settings.solver_version)

    def with_position(self, view: JobView) -> JobView:
        """Returns the state of a job with its position in the queue, if it waits there."""
        if view.status != "queued":
            return view
        own = self.of(view.id)
        reply = own._run("queue_position", own.keys.names(view.id), job_id=view.id)
        return replace(view, place=QueuePosition(reply[0], reply[1] / 1000) if reply else None)

    def readiness(self) -> Readiness:
        """Returns whether a job would be done now.

        Raises:
            RedisError: Redis cannot be reached, or accepts no data.
        """
        return readiness(self.redis, self.settings)

    def workers(self) -> int:
        """Returns the number of live workers of this version of the solver."""
        return len(Roster(self.redis, self.settings).names())


class JobQueue(JobLookup):
    """The jobs of one installation."""

    def __init__(self, redis: Redis, settings: WorkerSettings | None = None) -> None:
        super().__init__(redis, settings)
        self.attempts = Attempts(redis, self.settings)
        self.chunks = ChunkQueue(redis, self.settings)
        self.subscriptions = Subscriptions(redis, self.settings)
        self.quotas = Quotas(redis, self.settings)

    def submit(
        self,
        request: JobRequest,
        deadline_s: float | None = None,
        *,
        is_unknown: bool = False,
        by: Subscription | None = None,
    ) -> JobView:
        """Submit a request for a table or another document; returns its job.

        The job fails if it is not done in `deadline_s` seconds. If several clients submit it, the latest of
        their deadlines counts; None is no deadline.

        Joins a job that is queued or running, or has succeeded and still has its results. A job that failed,
        was canceled, lost a part of its record, or whose results have expired is restarted. `is_unknown`:
        the answer was looked up a moment ago, so that one in a single part need not be looked up again. `by`:
        the client, which is a subscriber of a job that is made now.

        Raises:
            QueueFullError: the lane of a new job holds too much work.
        """
        is_missing = is_unknown and len(request.parts) == 1
        if is_missing:  # most often there has been no such job
            view = self._make(request, request.parts, "", deadline_s, by)
            if view is not None:
                return view
        seen = self._reconciled(request.job_id)
        if seen is not None and not seen.is_terminal:
            return self._joined(seen, deadline_s)
        succeeded = seen if seen is not None and seen.status == "succeeded" else None
        todo = request.parts if is_missing and not succeeded else missing_parts(request, self.store)
        if succeeded and not todo:
            return succeeded
        view = self._make(request, todo, seen.run if seen else "", deadline_s, by)
        if view is not None:
            return view
        view = self.records.view(request.job_id)
        if view is None:
            return self.submit(request, deadline_s, is_unknown=is_unknown, by=by)
        return self._joined(view, deadline_s)

    def _reconciled(self, job_id: str) -> JobView | None:
        """The job as it stands once a run that lost a part of its record has ended."""
        seen = self.records.view(job_id)
        is_lost = seen is not None and not seen.is_terminal and not self.records.reconcile(job_id)
        return self.records.view(job_id) if is_lost else seen

    def _make(
        self,
        request: JobRequest,
        todo: Sequence[str],
        seen_run: str,
        deadline_s: float | None,
        by: Subscription | None,
    ) -> JobView | None:
        """Make a job in place of the run that was seen, and queue it; None if another client was faster."""
        job = self.plan(request, len(todo))
        created = self.records.create(request, todo, seen_run, job, deadline_s, by)
        if created is None:
            return None
        self.chunks.enqueue(created.refs, job.lane)
        if not created.event:
            return self.records.view(request.job_id)
        view = job_view(request.job_id, created.fields)
        return replace(view, event=created.event)

    def plan(self, request: JobRequest, parts: int) -> Plan:
        """Returns the lane and the chunks of a job that computes this number of parts of a request."""
        cost = request.cost
        is_long = request.kind.by_slices and cost.once > self.settings.chunk_seconds
        if is_long and self.store.has_eliminant(request):
            cost = replace(cost, once=0.0)
        return plan(cost, parts, self.settings, is_shared=request.kind.shares > 1)

    def submit_for(
        self,
        who: Subscriber,
        request: JobRequest,
        seconds: float = 0.0,
        deadline_s: float | None = None,
        *,
        is_unknown: bool = False,
    ) -> JobView:
        """Submit a request for a client that may wait `seconds` for it; only such clients can end its job."""
        while True:
            by = Subscription(who, seconds)
            view: JobView | None = self.submit(request, deadline_s, is_unknown=is_unknown, by=by)
            if view is not None and not view.is_terminal:
                if view.event or self.subscriptions.add(view.id, who, seconds):  # some are made with it
                    return view
                view = self.get(view.id)
            if view is not None and view.status in ("succeeded", "failed"):
                return view  # otherwise the others have just withdrawn, and it begins again

    def withdraw(self, job_id: str, who: Subscriber) -> JobView | None:
        """Withdraw a client from a job, which is canceled if it was the last; returns the job."""
        self.subscriptions.withdraw(job_id, who)
        if who.is_known:
            self.quotas.forget(who.client, job_id)
        self.chunks.withdraw(self.records.cancel(job_id, if_unwanted=True) or [])
        return self.get(job_id)

    def leave(self, job_id: str, who: Subscriber) -> None:
        """Record that a waiting client has disconnected. Its job continues unless all have withdrawn."""
        self.subscriptions.leave(job_id, who)
        self.chunks.withdraw(self.records.cancel(job_id, if_unwanted=True) or [])

    def cancel(self, job_id: str) -> JobView | None:
        """Cancel a queued or running job for all subscribers; a job that has ended is unchanged.

        A search that has found something first ends with that as its answer; if canceled again, at once.
        """
        entries = self.records.cancel(job_id)
        if entries:
            self.chunks.withdraw(entries)
        return self.records.view(job_id)

    def _joined(self, view: JobView, deadline_s: float | None) -> JobView:
        """Returns a job that another client submitted too, with the later of the deadlines."""
        if not view.is_terminal and view.deadline_at is not None:
            self.subscriptions.extend_deadline(view.id, deadline_s)
            view = self.records.view(view.id) or view
        return view


def _kept_text(request: JobRequest) -> bytes:
    """Returns what is kept of a question that is answered without a job, as `JobLookup.question` reads it."""
    return zlib.compress(as_kept(request).to_json().encode(), 1)


class NotPinnableError(Exception):
    """The answer is not there, or may change: a table with errors, or a search that was stopped."""


class Pins:
    """The pinned answers of one version of the solver."""

    def __init__(self, queue: JobLookup) -> None:
        self.queue = queue
        self.store = queue.store
        settings = queue.settings
        self._key = f"{settings.key_prefix}:{kind_of('pins', settings.solver_version)}"
        self._run = Scripts(queue.redis)

    def ids(self) -> list[str]:
        """Returns the ids of the jobs whose answers are pinned, sorted."""
        members = cast("set[bytes]", self.queue.redis.smembers(self._key))
        return sorted(raw.decode() for raw in members)

    def pin(self, job_id: str) -> None:
        """Keep the answer of a job, or of a question that was answered without one, for ever.

        Raises:
            NotPinnableError: it is not there, or may change.
        """
        request = self.queue.question(job_id)
        if request is None or not self._is_lasting(request):
            raise NotPinnableError(job_id)
        results, text = self._results(request), _kept_text(request)
        if not self._run("pin", self._keys(job_id), results=results, text=text, job_id=job_id):
            raise NotPinnableError(job_id)

    def unpin(self, job_id: str) -> bool:
        """Let an answer expire as others do; returns False if it was not pinned."""
        request = self.queue.question(job_id)
        results = [] if request is None else self._results(request)
        ttl = self.queue.settings.longest_lifetime
        is_over = self._run("unpin", self._keys(job_id), results=results, job_id=job_id, ttl=ttl)
        for other in self.ids() if is_over else ():  # they may share slices
            self.pin(other)
        return bool(is_over)

    def _is_lasting(self, request: JobRequest) -> bool:
        """Whether the answer is whole and will not change; keeps what it was put together from as its own."""
        answer = known_answer(request, self.store)
        if answer is None:
            return False
        if isinstance(answer, StoredTable):
            return not answer.has_errors and not missing_parts(request, self.store)
        self.store.put_document(request, answer)
        return True

    def _keys(self, job_id: str) -> dict[str, str]:
        return {"question": self.store.keys.question(job_id), "pins": self._key}

    def _results(self, request: JobRequest) -> Sequence[str]:
        keys = self.store.keys
        if request.kind.by_slices:
            return self.store.slice_keys(request, request.parts)
        return [keys.document(request.content_hash)]
