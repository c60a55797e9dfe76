"""Jobs as the API sees them: submit, look up, cancel.

All state is in Redis, so any number of API processes can serve the same jobs.
"""

from __future__ import annotations

import json
import time
import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import cast

from redis import Redis
from redis.exceptions import RedisError

from worker.answers import JobRequest
from worker.answers.kinds import Answer, as_kept, known_answer, missing_parts, request_from_json
from worker.answers.store import ResultStore
from worker.jobs.installation import Readiness, readiness
from worker.jobs.keys import InRedis
from worker.jobs.listing import Listing
from worker.jobs.plan import CHUNK_SECONDS, Plan, plan
from worker.jobs.quotas import Quotas
from worker.jobs.records import Client, JobRecords, NewJob
from worker.jobs.view import JobView
from worker.settings import WorkerSettings

_REWRITE_SECONDS = 10.0  # before a question that was kept is written again
_MAX_REMEMBERED = 10_000


class JobQueue(InRedis):
    """The jobs of one installation, and their answers."""

    def __init__(self, redis: Redis, settings: WorkerSettings | None = None) -> None:
        super().__init__(redis, settings or WorkerSettings())
        self.store = ResultStore(redis, self.settings)
        self.records = JobRecords(redis, self.settings)
        self.chunks = self.records.chunks
        self.listing = Listing(redis, self.settings)
        self.quotas = Quotas(redis, self.settings)
        self._remembered: dict[str, float] = {}

    # -- answers -----------------------------------------------------------------------------------

    def known(self, request: JobRequest) -> Answer | None:
        """Returns the complete answer if it is known or follows from known documents, else None."""
        return known_answer(request, self.store)

    def get(self, job_id: str) -> JobView | None:
        """Returns the current state of a job, or None if there is none."""
        return self.records.view(job_id)

    def result(self, job_id: str) -> Answer | None:
        """Returns the answer of a job that succeeded, or None if it did not or its results have expired."""
        return self.outcome(job_id)[1]

    def outcome(self, job_id: str) -> tuple[JobView | None, Answer | None]:
        """Returns the current state of a job, None if there is none, and its answer as `result` does."""
        record = self.records.request(job_id)
        if record is None:
            return None, None
        view, request, errors = record
        if view.status != "succeeded":
            return view, None
        answer = known_answer(request, self.store, errors)
        return view, answer if answer is not None else self._stopped(job_id)

    def _stopped(self, job_id: str) -> Answer | None:
        """The best that a search had found when it was stopped, which is the answer of its job alone."""
        stopped = self.records.stopped(job_id)
        text = None if stopped is None else self.store.get_text(stopped)
        return None if text is None else cast(Answer, json.loads(text))

    def remember(self, request: JobRequest) -> bool:
        """Keep a question with a known answer, for `kept_answer`; returns False if Redis refuses."""
        now = time.monotonic()
        if now - self._remembered.get(request.job_id, -_REWRITE_SECONDS) < _REWRITE_SECONDS:
            return True
        text = zlib.compress(as_kept(request).to_json().encode(), 1)
        try:
            self.redis.set(
                self.store.keys.question(request.job_id), text, ex=self.settings.result_ttl_seconds
            )
        except RedisError:
            return False
        if len(self._remembered) >= _MAX_REMEMBERED:
            self._remembered.clear()
        self._remembered[request.job_id] = now
        return True

    def kept_answer(self, job_id: str) -> Answer | None:
        """Returns the answer to a question that was answered without a job, or None if it has expired."""
        kept = cast("bytes | None", self.redis.get(self.store.keys.question(job_id)))
        return None if kept is None else self.known(request_from_json(zlib.decompress(kept)))

    def with_position(self, view: JobView) -> JobView:
        """Returns the state of a job with its position in the queue, if it waits there."""
        return self.records.with_position(view)

    def readiness(self) -> Readiness:
        """Returns whether a job would be done now.

        Raises:
            RedisError: Redis cannot be reached, or accepts no data.
        """
        return readiness(self.redis, self.settings)

    def workers(self) -> int:
        """Returns the number of live workers."""
        return self.chunks.workers("small")[0]

    # -- jobs --------------------------------------------------------------------------------------

    def submit(
        self,
        request: JobRequest,
        deadline_seconds: float | None = None,
        *,
        is_unknown: bool = False,
        by: Client | None = None,
    ) -> JobView:
        """Submit a request for a table or another document; returns its job.

        The job fails if it is not done in `deadline_seconds` seconds. If several clients submit it, the
        latest of their deadlines counts; None is no deadline.

        Joins a job that is queued or running, or has succeeded and still has its results. A job that failed,
        was canceled, or whose results have expired is started anew. `is_unknown`: the answer was looked up a
        moment ago, so that one in a single part need not be looked up again. `by`: the client.

        Raises:
            QueueFullError: the lane of a new job holds too much work.
        """
        seen: JobView | None = None
        while True:
            is_missing = is_unknown and len(request.parts) == 1 and (seen is None or not seen.is_terminal)
            todo: Sequence[str] = request.parts if is_missing else missing_parts(request, self.store)
            if seen is not None and seen.status == "succeeded" and not todo:
                return seen
            made = self._make(request, todo, seen.run if seen else "", deadline_seconds, by)
            if made is not None:
                return made
            seen = self.records.view(request.job_id)  # most often there is none, so it comes last
            if seen is not None and not seen.is_terminal:
                joined = self.records.join(seen.id, by, deadline_seconds)
                if joined is not None and not joined.is_terminal:
                    return joined
                seen = joined

    def _make(
        self,
        request: JobRequest,
        todo: Sequence[str],
        seen_run: str,
        deadline_seconds: float | None,
        by: Client | None,
    ) -> JobView | None:
        """Make a job in place of the run that was seen; None if another client was faster."""
        positions, known = _positions(request, todo)
        job = self.plan(request, positions)
        return self.records.create(NewJob(request, job, known, seen_run, deadline_seconds, by))

    def plan(self, request: JobRequest, positions: Sequence[int]) -> Plan:
        """Returns the lane and the chunks of a job that computes the parts at these positions."""
        cost = request.cost
        is_long = request.kind.by_slices and cost.once > CHUNK_SECONDS
        if is_long and self.store.has_eliminant(request):
            cost = replace(cost, once=0.0)
        return plan(cost, positions)

    def withdraw(self, job_id: str, by: Client) -> JobView | None:
        """Withdraw a client from a job; returns the job. See `JobRecords.withdraw`."""
        self.records.withdraw(job_id, by)
        if by.is_known:
            self.quotas.forget(by.id, job_id)
        return self.get(job_id)

    def cancel(self, job_id: str) -> JobView | None:
        """Cancel a queued or running job for all clients; a job that has ended is unchanged.

        A search that has found something first ends with that as its answer; if canceled again, at once.
        """
        self.records.cancel(job_id)
        return self.get(job_id)


def _positions(request: JobRequest, todo: Sequence[str]) -> tuple[list[int], list[int]]:
    """Returns the positions of the parts that are to be done, and of the others."""
    if len(todo) == len(request.parts) or not request.kind.by_slices:
        everything = list(range(len(request.parts)))
        return (everything, []) if todo else ([], everything)
    missing = {*todo}
    places: tuple[list[int], list[int]] = [], []
    for position, part in enumerate(request.parts):
        places[part not in missing].append(position)
    return places
