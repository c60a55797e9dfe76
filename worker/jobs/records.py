"""The record of a job in Redis, and the atomic steps that change it."""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from redis import Redis

from worker import tracing
from worker.answers import JobRequest, in_groups
from worker.answers.kinds import as_kept, request_from_json
from worker.answers.layout import dump, unpack
from worker.jobs.chunks import ChunkEntry, ChunkRef, entry_of
from worker.jobs.clients import ACTIVE, Bytes, JobView, Subscription, view_of
from worker.jobs.plan import InRedis, Plan, QueueFullError
from worker.logs import subject
from worker.lua.scripts import VIEW_FIELDS
from worker.settings import WorkerSettings

INCOMPLETE = (
    "The server lost a part of this job's record. Posting the request again computes what is missing."
)

_NOBODY = {"name": "", "token": "", "seconds": 0}

_NOTED_SECONDS = 10.0  # for which the version of the solver is not noted again
_OVERDUE = "The job was not done by the deadline of its request (deadline_s)."


@dataclass(frozen=True)
class Created:
    """The chunks of a new job, its first event, and the fields of its record that are shown.

    If it has ended at once, there is neither event nor field.
    """

    refs: Sequence[ChunkRef]
    event: str
    fields: Mapping[str, str]


class JobRecords(InRedis):
    """Reads and changes job records. Every change is one atomic script; see `worker/lua`."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self._noted = -_NOTED_SECONDS  # when the version was

    def view(self, job_id: str) -> JobView | None:
        """Returns the current state of a job, or None if there is none."""
        fields = self.redis.hmget(self.keys.job(job_id).record, VIEW_FIELDS)
        return view_of(job_id, cast("list[bytes | None]", fields))

    def request(self, job_id: str) -> tuple[JobView, JobRequest, dict[str, Any]] | None:
        """Returns a job, its request and the errors of single slices by L1, or None if there is none."""
        keys = self.keys.job(job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.hmget(keys.record, [*VIEW_FIELDS, "request"])
            pipe.hgetall(keys.errors)
            fields, errors = pipe.execute()
        view = view_of(job_id, fields)
        if view is None or fields[-1] is None:
            return None
        by_l1 = {raw.decode(): json.loads(unpack(error)) for raw, error in errors.items()}
        return view, request_from_json(fields[-1], self.settings.solver_version), by_l1

    def asked(self, job_id: str, l1: Sequence[str]) -> tuple[JobRequest, dict[str, Any]] | None:
        """Returns a job's request for some of its slices, and the errors of these by L1, or None."""
        keys = self.keys.job(job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.hget(keys.record, "asked")
            pipe.hmget(keys.errors, l1)
            asked, errors = pipe.execute()
        if not asked:
            return None
        by_l1 = {x: json.loads(unpack(error)) for x, error in zip(l1, errors, strict=True) if error}
        return request_from_json(asked, self.settings.solver_version).of_slices(l1), by_l1

    def known_before(self, job_id: str) -> list[str]:
        """Returns the parts of a job that were known when it was made, in their order."""
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.hget(self.keys.job(job_id).record, "request")
            pipe.lrange(self.keys.job(job_id).todo, 0, -1)
            request, todo = pipe.execute()
        if request is None or not todo:
            return []
        to_do = {part for parts in todo for part in json.loads(parts)}
        return [part for part in request_from_json(request).parts if part not in to_do]

    def create(
        self,
        request: JobRequest,
        todo: Sequence[str],
        seen_run: str,
        plan: Plan,
        deadline_s: float | None = None,
        by: Subscription | None = None,
        size: Bytes | None = None,
    ) -> Created | None:
        """Create a job, or restart it in place of the run `seen_run` ("" for none); `todo`: the open parts.

        `size`: what is to be counted for whom; without it, the question for `by`.

        Returns None if another client was faster.

        Raises:
            QueueFullError: its lane holds too much work.
        """
        run, texts = secrets.token_hex(4), _texts_of(request)
        text, cut = texts["request"], texts["kept"]
        size = size or Bytes(len(text) + len(cut), len(cut or text), by.who.client if by else "")
        outcome, *more = self._run(
            "create",
            self.keys.names(request.job_id),
            by.arguments if by else _NOBODY,
            texts,
            size.arguments(self.keys),
            work_arguments(plan, todo, deadline_s, self.settings),
            job_id=request.job_id,
            run=run,
            seen_run=seen_run,
            total=len(request.parts),
            chunk_size=plan.chunk_size,
            origin=dump(_origin()),
            versions=self.keys.versions,
            version=self._version_to_note(),
        )
        if outcome == -1:
            raise QueueFullError(plan.lane, more[0] / 1000)
        if not outcome:
            return None
        refs = [ChunkRef(request.job_id, run, i, 0) for i in range(plan.chunk_count)]
        event, *shown = [raw.decode() for raw in more]
        return Created(refs, event, dict(zip(shown[::2], shown[1::2], strict=True)))

    def _version_to_note(self) -> str:
        """Returns the version of the solver, or nothing if it was noted a moment ago."""
        if time.monotonic() - self._noted < _NOTED_SECONDS:
            return ""
        self._noted = time.monotonic()
        return self.settings.solver_version

    def fail(self, ref: ChunkRef, kind: str, detail: str) -> list[ChunkEntry] | None:
        """End the job because of this chunk; returns the open chunks, or None if the chunk is out of date."""
        problem = dump({"type": kind, "detail": detail})
        return self._end(vars(ref), "failed", problem)

    def cancel(self, job_id: str, *, if_unwanted: bool = False) -> list[ChunkEntry] | None:
        """Cancel the job; returns its open chunks, or None if it was not active, or a client wants it."""
        return self._end(_of_any_run(job_id), "unwanted" if if_unwanted else "canceled")

    def expire(self, job_id: str) -> list[ChunkEntry] | None:
        """Fail a job whose deadline is over; returns its open chunks, or None if it is not."""
        problem = dump({"type": "timeout", "detail": _OVERDUE})
        return self._end(_of_any_run(job_id), "overdue", problem)

    def open_chunks(self) -> list[ChunkEntry]:
        """Returns the chunks of all active jobs that are not done."""
        job_ids = [raw.decode() for raw in cast("list[bytes]", self.redis.zrange(self.keys.active, 0, -1))]
        with self.redis.pipeline(transaction=False) as pipe:
            for job_id in job_ids:
                keys = self.keys.job(job_id)
                pipe.hget(keys.record, "run")
                pipe.hgetall(keys.chunks)
            replies = pipe.execute()
        entries: list[ChunkEntry] = []
        for job_id, run, chunks in zip(job_ids, replies[::2], replies[1::2], strict=True):
            if run is None or not chunks:
                self.reconcile(job_id)
            else:
                entries += [entry_of(job_id, run, index, entry) for index, entry in chunks.items()]
        return entries

    def reconcile(self, job_id: str) -> bool:
        """Repair an active job that lost keys in Redis; returns False if it is not active (any more).

        A job without its chunks fails, since no worker could ever end it.
        """
        problem = dump({"type": "worker-lost", "detail": INCOMPLETE})
        keys, ttl = self.keys.names(job_id), self.settings.failure_ttl
        return bool(self._run("reconcile", keys, job_id=job_id, problem=problem, ttl=ttl))

    def overdue(self) -> list[str]:
        """Returns the active jobs whose deadline is over."""
        late = self.redis.zrangebyscore(self.keys.deadlines, "-inf", self.now())
        return [raw.decode() for raw in cast("list[bytes]", late)]

    def adopt(self, count: int) -> None:
        """Search about `count` of all keys for active jobs that are missing in the set of active jobs.

        Each call continues where the previous one stopped, in any process. Jobs of other versions of the
        solver have other names, so none of them is found.
        """
        before = cast("bytes | None", self.redis.get(self.keys.walk))
        cursor, names = self.redis.scan(
            int(before or 0), match=self.keys.job("*").record, count=count, _type="hash"
        )
        self.redis.set(self.keys.walk, cursor)
        start = self.keys.job("").record
        job_ids = [name.decode().removeprefix(start) for name in cast("list[bytes]", names)]
        with self.redis.pipeline(transaction=False) as pipe:
            for job_id in job_ids:
                pipe.hget(self.keys.job(job_id).record, "status")
            pairs = zip(job_ids, pipe.execute(), strict=True)
        active = [job_id for job_id, status in pairs if (status or b"").decode() in ACTIVE]
        listed = self.redis.zmscore(self.keys.active, active) if active else []
        for job_id, score in zip(active, listed, strict=True):
            if score is None:
                self.reconcile(job_id)

    def _end(self, attempt: Mapping[str, Any], status: str, problem: str = "") -> list[ChunkEntry] | None:
        job_id = attempt["job_id"]
        reply = self._run(
            "end",
            self.keys.names(job_id),
            attempt,
            status=status,
            problem=problem,
            ttl=self.settings.failure_ttl,
        )
        if not reply:
            return None
        return [entry_of(job_id, reply[0], *pair) for pair in zip(reply[1::2], reply[2::2], strict=True)]


def _texts_of(request: JobRequest) -> dict[str, str]:
    """Returns a question whole, without its slices, and what stays of it at the end, if not all."""
    kept = as_kept(request)
    return {
        "request": request.to_json(),
        "asked": request.of_slices(()).to_json() if request.kind.by_slices else "",
        "kept": "" if kept is request else kept.to_json(),
    }


def _of_any_run(job_id: str) -> dict[str, str]:
    return {"job_id": job_id, "run": "", "index": "", "attempt": ""}


def _origin() -> dict[str, str]:
    """Returns the id of the current HTTP request, and the context of its trace."""
    known = {"request_id": subject("request_id")} if subject("request_id") else {}
    if trace := tracing.carrier():
        known |= {**trace, "submitted": str(time.time_ns())}
    return known


def work_arguments(
    plan: Plan, todo: Sequence[str], deadline_s: float | None, settings: WorkerSettings
) -> dict[str, Any]:
    """Returns what the scripts take of the work of a job: the parts to do, in chunks, and what they cost."""
    return {
        "todo": [dump(list(part)) for part in in_groups(todo, plan.chunk_size)],
        "todo_count": len(todo),
        "chunk_count": plan.chunk_count,
        "lane": plan.lane,
        "work": _milliseconds(plan.seconds),
        "each": _milliseconds(plan.each),
        "max_backlog": _milliseconds(settings.max_backlog),
        "deadline_s": "" if deadline_s is None else deadline_s,
        "ttl": settings.job_ttl,
    }


def _milliseconds(seconds: float) -> int:
    """Returns estimated seconds as the records keep them."""
    return max(1, round(1000 * seconds))
