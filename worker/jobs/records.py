"""The record of a job in Redis: made, looked up and ended."""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, cast

from redis import Redis
from redis.client import Pipeline
from redis.exceptions import WatchError

from rpr_solver.errors import clipped
from worker import tracing
from worker.answers import JobRequest
from worker.answers.kinds import as_kept, is_batch, request_from_json
from worker.answers.layout import dump, unpack
from worker.jobs.chunks import ChunkEntry, ChunkQueue, ChunkRef, entry_from_json
from worker.jobs.keys import FAILURE_TTL, InRedis, seconds_of
from worker.jobs.plan import Plan, QueueFullError
from worker.jobs.view import ACTIVE, JobView, QueuePosition, job_view, view_of
from worker.logs import subject
from worker.lua.scripts import VIEW_FIELDS
from worker.settings import WorkerSettings

_OVERDUE = "The job was not done by the deadline of its request (deadline_seconds)."
_ABOUT = 300  # characters of a question that are shown with its RQ jobs

_LISTED, _LISTED_OF_CLIENT = 20_000, 2_000
_LISTED_SECONDS = 30 * 86400
"""A list of jobs has so many entries, for so long; a job that is kept longer can be asked for by its id."""


@dataclass(frozen=True)
class Client:
    """A client that asks for a job.

    Attributes:
        id: its key, or its network address.
        is_known: whether that distinguishes it from all others, as a key does: then the job goes on as long
            as it has not withdrawn. Without a key, anybody may cancel the job.
    """

    id: str
    is_known: bool


@dataclass(frozen=True)
class NewJob:
    """A job that is to be made.

    Attributes:
        request: the question.
        plan: of what is to be computed.
        known: the positions of the parts that are known already.
        seen_run: the run in whose place it comes, which is not active; empty if none was seen.
        deadline_seconds: the seconds in which it must be done.
        by: who asks for it.
        failed: the positions of the items of a batch that cannot be asked.
    """

    request: JobRequest
    plan: Plan
    known: Sequence[int] = ()
    seen_run: str = ""
    deadline_seconds: float | None = None
    by: Client | None = None
    failed: Sequence[int] = ()

    def fields(self, run: str, now: float, ahead: int) -> dict[str, str]:
        """Returns the fields of its record; `ahead`: the milliseconds of work that its lane was given."""
        request, kept, work = self.request, as_kept(self.request), _milliseconds(self.plan.seconds)
        fields = {
            "request": request.to_json(),
            "asked": request.of_slices(()).to_json() if request.kind.by_slices else None,
            "kept": None if kept is request else kept.to_json(),
            "origin": dump(_origin()),
            **{"run": run, "status": "queued", "total": str(len(request.parts)), "created": f"{now:.6f}"},
            **{"lane": self.plan.lane, "work": str(work), "left": str(work), "ahead": str(ahead)},
            "done": str(len(self.known) + len(self.failed)),
            "failed": str(len(self.failed)) if self.failed else None,
            "maker": None if self.by is None else self.by.id,
            "deadline": None if self.deadline_seconds is None else f"{now + self.deadline_seconds:.6f}",
        }
        return {name: value for name, value in fields.items() if value is not None}


class JobRecords(InRedis):
    """The records of an installation."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.chunks = ChunkQueue(redis, settings)

    # -- reading -----------------------------------------------------------------------------------

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
        by_l1 = {} if is_batch(job_id) else {l1.decode(): json.loads(unpack(x)) for l1, x in errors.items()}
        return view, request_from_json(fields[-1]), by_l1

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
        return request_from_json(asked).of_slices(l1), by_l1

    def stopped(self, job_id: str) -> str | None:
        """Returns the hash of the answer that a job has alone, if it was stopped."""
        stopped = cast("bytes | None", self.redis.hget(self.keys.job(job_id).record, "stopped"))
        return None if stopped is None else stopped.decode()

    def active(self) -> list[str]:
        """Returns the ids of the queued and running jobs."""
        return [raw.decode() for raw in cast("list[bytes]", self.redis.zrange(self.keys.active, 0, -1))]

    def open_chunks(self, job_ids: Sequence[str]) -> dict[str, dict[ChunkRef, ChunkEntry]]:
        """Returns the chunks of jobs that are not done."""
        with self.redis.pipeline(transaction=False) as pipe:
            for job_id in job_ids:
                pipe.hget(self.keys.job(job_id).record, "run")
                pipe.hgetall(self.keys.job(job_id).chunks)
            replies = pipe.execute()
        found = {}
        for job_id, run, chunks in zip(job_ids, replies[::2], replies[1::2], strict=True):
            entries = {int(index): entry_from_json(text) for index, text in chunks.items()}
            found[job_id] = {
                ChunkRef(job_id, (run or b"").decode(), index, entry.attempt): entry
                for index, entry in entries.items()
            }
        return found

    def with_position(self, view: JobView) -> JobView:
        """Returns the state of a job with its position in the queue, if it waits there."""
        if view.status != "queued":
            return view
        lane, ahead = cast(
            "list[bytes | None]", self.redis.hmget(self.keys.job(view.id).record, ["lane", "ahead"])
        )
        if lane is None or ahead is None:
            return view
        name = lane.decode()
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.zrank(self.keys.queued(name), view.id)
            pipe.hget(self.keys.work, f"{name}:done")
            rank, done = pipe.execute()
        if rank is None:
            return view
        workers = self.chunks.workers(cast(Any, name))[0]
        seconds = max(0, int(ahead) - int(done or 0)) / 1000 / max(1, workers)
        return replace(view, place=QueuePosition(rank, seconds))

    # -- making ------------------------------------------------------------------------------------

    def create(self, new: NewJob) -> JobView | None:
        """Make a job with all its chunks in one transaction; returns None if another client was faster.

        Raises:
            QueueFullError: its lane holds too much work.
        """
        with self.redis.pipeline() as pipe:
            while True:
                try:
                    return self._create(pipe, new)
                except WatchError:
                    continue

    def _create(self, pipe: Pipeline, new: NewJob) -> JobView | None:
        job_id = new.request.job_id
        keys, plan, by = self.keys.job(job_id), new.plan, new.by
        pipe.watch(keys.record)  # type: ignore[no-untyped-call]
        old_run, status = cast("list[bytes | None]", pipe.hmget(keys.record, ["run", "status"]))
        if old_run and ((status or b"").decode() in ACTIVE or old_run.decode() != new.seen_run):
            return None
        ahead = self._room(pipe, plan)
        now, run = seconds_of(pipe.time()), secrets.token_hex(4)
        fields = new.fields(run, now, ahead)
        pipe.multi()
        pipe.delete(*(key for key in keys if key != keys.items))
        pipe.xadd(keys.events, {"type": "status", "status": "queued"})
        pipe.hset(keys.record, mapping=cast(Any, fields))
        for position in (*new.known, *new.failed):
            pipe.setbit(keys.bits, position, 1)
        if plan.chunks:
            self.chunks.enqueue(pipe, job_id, run, _entries(plan), about_of(new.request))
        if is_batch(job_id):
            pipe.persist(keys.items)
        self._account(pipe, job_id, plan, now, new.deadline_seconds)
        self._list(pipe, job_id, now, None)
        if by is not None:
            self._list(pipe, job_id, now, by)
        event = pipe.execute()[1].decode()
        if not plan.chunks:
            self.end(job_id, run, "succeeded", ttl=self.settings.result_ttl_seconds)
            return self.view(job_id)
        return job_view(job_id, fields, event)

    def _room(self, pipe: Pipeline, plan: Plan) -> int:
        """Returns the milliseconds of work that a lane was given so far.

        Raises:
            QueueFullError: it holds too much for more. One in which nothing waits takes any job.
        """
        names = [f"{plan.lane}:added", f"{plan.lane}:done"]
        added, done = (
            int(value or 0) for value in cast("list[bytes | None]", pipe.hmget(self.keys.work, names))
        )
        waiting = max(0, added - done) / 1000
        if waiting + plan.seconds > self.settings.max_backlog_seconds and plan.chunks:
            workers = max(1, self.chunks.workers(plan.lane)[0])
            is_too_much = waiting + plan.seconds > self.settings.max_backlog_seconds * workers
            if is_too_much and pipe.zcard(self.keys.queued(plan.lane)):
                raise QueueFullError(plan.lane, waiting / workers)
        return added

    def _account(
        self, pipe: Pipeline, job_id: str, plan: Plan, now: float, deadline_seconds: float | None
    ) -> None:
        pipe.zadd(self.keys.active, {job_id: now})
        pipe.zadd(self.keys.queued(plan.lane), {job_id: now})
        pipe.hincrby(self.keys.work, f"{plan.lane}:added", _milliseconds(plan.seconds))
        if deadline_seconds is not None:
            pipe.zadd(self.keys.deadlines, {job_id: now + deadline_seconds})

    def _list(self, pipe: Pipeline, job_id: str, now: float, by: Client | None) -> None:
        """List a job that is made, or for one more client that asks for it."""
        key = self.keys.listed("batches" if is_batch(job_id) else "jobs", None if by is None else by.id)
        pipe.zadd(key, {job_id: now})
        pipe.expire(key, _LISTED_SECONDS)
        if job_id.endswith("0"):  # now and then
            pipe.zremrangebyrank(key, 0, -1 - (_LISTED if by is None else _LISTED_OF_CLIENT))
        if by is not None and by.is_known:
            pipe.sadd(self.keys.job(job_id).wanted, by.id)

    def join(self, job_id: str, by: Client | None, deadline_seconds: float | None) -> JobView | None:
        """Have one more client want an active job, until the latest of all deadlines; returns the job."""
        record = self.keys.job(job_id).record

        def step(pipe: Pipeline) -> None:
            status, deadline = cast("list[bytes | None]", pipe.hmget(record, ["status", "deadline"]))
            now = seconds_of(pipe.time())
            pipe.multi()
            if by is not None:
                self._list(pipe, job_id, now, by)
            if (status or b"").decode() not in ACTIVE:
                pipe.delete(self.keys.job(job_id).wanted)
            elif deadline is not None and deadline_seconds is None:
                pipe.hdel(record, "deadline")
                pipe.zrem(self.keys.deadlines, job_id)
            elif (
                deadline is not None
                and deadline_seconds is not None
                and now + deadline_seconds > float(deadline)
            ):
                pipe.hset(record, "deadline", f"{now + deadline_seconds:.6f}")
                pipe.zadd(self.keys.deadlines, {job_id: now + deadline_seconds})

        self.redis.transaction(step, record)
        return self.view(job_id)

    # -- ending ------------------------------------------------------------------------------------

    def end(self, job_id: str, run: str, status: str, problem: str = "", *, ttl: int = 0) -> bool:
        """End a job, once, if this run of it is active; see `end.lua`. Returns whether this has ended it.

        Its chunks that wait are then taken from the queues; those that run are ended by their workers.
        """
        chunks = self.open_chunks([job_id])[job_id] if status != "succeeded" else {}
        has_ended = self._run(
            "end",
            self.keys.names(job_id),
            job_id=job_id,
            run=run,
            status=status,
            problem=problem,
            ttl=ttl or FAILURE_TTL,
        )
        if has_ended:
            self._withdraw(chunks)
        return bool(has_ended)

    def _withdraw(self, chunks: Mapping[ChunkRef, ChunkEntry]) -> None:
        with self.redis.pipeline(transaction=False) as pipe:
            for ref in chunks:
                pipe.exists(self.keys.beat(ref.rq_id))
            beats = pipe.execute()
        self.chunks.discard(ref.rq_id for ref, beat in zip(chunks, beats, strict=True) if not beat)

    def fail(self, job_id: str, run: str, kind: str, detail: str) -> bool:
        """End a job because it has no answer."""
        return self.end(job_id, run, "failed", dump({"type": kind, "detail": detail}))

    def cancel(self, job_id: str, *, if_unwanted: bool = False) -> None:
        """Cancel a job; if it is so said, only if no key wants it.

        A search that has found something first ends with that as its answer; if canceled again, at once.
        """
        self.end(job_id, "", "unwanted" if if_unwanted else "canceled")

    def withdraw(self, job_id: str, by: Client) -> None:
        """Withdraw a client from a job, which is canceled if it was the last; one without a key cancels it.

        The job of other keys, or that nobody with a key asked for, is no business of a key.
        """
        if not by.is_known:
            self.cancel(job_id)
        elif self.redis.srem(self.keys.job(job_id).wanted, by.id):
            self.cancel(job_id, if_unwanted=True)

    def overdue(self) -> list[str]:
        """Fail the jobs whose deadline is over; returns their ids."""
        late = self.redis.zrangebyscore(self.keys.deadlines, "-inf", self.now())
        problem = dump({"type": "timeout", "detail": _OVERDUE})
        ids = [raw.decode() for raw in cast("list[bytes]", late)]
        return [job_id for job_id in ids if self.end(job_id, "", "overdue", problem)]


def _entries(plan: Plan) -> dict[int, ChunkEntry]:
    is_in_order = all(before[1] < after[0] for before, after in pairwise(plan.chunks))
    assert is_in_order, "chunks have no part in common"
    return {i: ChunkEntry(first, last, plan.lane) for i, (first, last) in enumerate(plan.chunks)}


def about_of(request: JobRequest) -> str:
    """Returns the beginning of a question, for those who look at its RQ jobs."""
    return clipped(f"{request.kind.name} {dump(request.content)}", _ABOUT)


def _origin() -> dict[str, str]:
    """Returns the id of the current HTTP request, and the context of its trace."""
    known = {"request_id": subject("request_id")} if subject("request_id") else {}
    if trace := tracing.carrier():
        known |= {**trace, "submitted": str(time.time_ns())}
    return known


def _milliseconds(seconds: float) -> int:
    """Returns estimated seconds as the records keep them."""
    return max(1, round(1000 * seconds))
