"""Jobs as the API sees them: submit, look, cancel.

Nothing is remembered in the process, so any number of API processes can serve the same jobs.
"""

from __future__ import annotations

from typing import cast

from redis import Redis
from rq.worker_registration import REDIS_WORKER_KEYS

from worker.answers.kinds import Document, known_document, missing_parts
from worker.answers.requests import JobRequest
from worker.answers.store import ResultStore
from worker.jobs.chunks import ChunkQueue
from worker.jobs.records import JobRecords, JobView
from worker.settings import WorkerSettings


class JobQueue:
    """The jobs of one installation. Instances are cheap and may be shared between threads."""

    def __init__(self, redis: Redis, settings: WorkerSettings | None = None) -> None:
        self.redis = redis
        self.settings = settings or WorkerSettings()
        self.store = ResultStore(redis, self.settings)
        self.records = JobRecords(redis, self.settings)
        self.chunks = ChunkQueue(redis, self.settings)

    def submit(self, request: JobRequest) -> JobView:
        """Have a table or another document computed.

        Joins the job if it is queued or running, or has succeeded and its results are still there. A job
        that failed, was canceled, or lost its results to time is replaced.
        """
        seen = self.records.view(request.job_id)
        if seen is not None and not seen.is_terminal:
            return seen
        todo = missing_parts(request, self.store)
        if seen is not None and seen.status == "succeeded" and not todo:
            return seen
        refs = self.records.create(request, todo, seen.run if seen else "")
        if refs:
            self.chunks.enqueue(refs, bulk=len(refs) > 1)
        view = self.records.view(request.job_id)
        return view if view is not None else self.submit(request)

    def known(self, request: JobRequest) -> Document | None:
        """The complete answer if it is known or follows from what is, else None."""
        return known_document(request, self.store)

    def get(self, job_id: str) -> JobView | None:
        """The job as it is now, or None when there is none (any more)."""
        return self.records.view(job_id)

    def result(self, job_id: str) -> Document | None:
        """The answer of a job that succeeded; None for any other, and when results have expired."""
        record = self.records.request(job_id)
        if record is None or record[0].status != "succeeded":
            return None
        _, request, errors = record
        return known_document(request, self.store, errors)

    def cancel(self, job_id: str) -> JobView | None:
        """Cancel a job that is queued or running; a job that has ended stays as it is."""
        entries = self.records.cancel(job_id)
        if entries:
            self.chunks.withdraw(entries)
        return self.records.view(job_id)

    def depth(self) -> int:
        """How many chunks wait for a worker."""
        return self.chunks.depth()

    def workers(self) -> int:
        """How many workers are alive, by RQ's register."""
        keys = cast("set[bytes]", self.redis.smembers(REDIS_WORKER_KEYS))
        return self.redis.exists(*keys) if keys else 0
