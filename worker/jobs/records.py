"""The record of a job in Redis, and the atomic steps that change it."""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

from redis import Redis
from redis.commands.core import Script
from rq.job import Job

from worker import tracing
from worker.answers.kinds import as_kept, kind_of_job, request_from_json
from worker.answers.layout import ResultKeys, unpack
from worker.answers.requests import JobRequest
from worker.answers.store import dump, told
from worker.answers.stored_tables import in_groups
from worker.answers.tables import slice_error
from worker.jobs import scripts
from worker.jobs.announcements import VIEW_FIELDS
from worker.jobs.attempts import Chunk, ChunkEntry, ChunkRef, Estimate, Lost, chunk_of, entry_of
from worker.jobs.kept import Bytes
from worker.jobs.keys import Keys
from worker.jobs.lanes import Lane, Plan, QueueFullError, heavy_twin
from worker.jobs.slices import SLICES
from worker.jobs.subscriptions import Subscription
from worker.jobs.views import ACTIVE, JobView, view_of
from worker.logs import subject
from worker.settings import WorkerSettings

INCOMPLETE = (
    "The server lost a part of this job's record. Posting the request again computes what is missing."
)

_OVERDUE = "The job was not done by the deadline of its request (deadline_s)."


@dataclass(frozen=True)
class Created:
    """The chunks of a new job, and the event that told of it."""

    refs: Sequence[ChunkRef]
    event: str


class JobRecords:
    """Reads and changes job records. Every change is one atomic script; see `worker.jobs.scripts`."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self.keys = Keys.of(settings)
        self.result_keys = ResultKeys(settings.key_prefix, settings.solver_version)
        self._create = self._script(scripts.CREATE)
        self._beat = self._script(scripts.BEAT)
        self._end_beat = self._script(scripts.END_BEAT)
        self._start = self._script(scripts.START)
        self._solve = self._script(scripts.SOLVE)
        self._slices = self._script(SLICES)
        self._progress = self._script(scripts.PROGRESS)
        self._document = self._script(scripts.DOCUMENT)
        self._end = self._script(scripts.END)
        self._reopen = self._script(scripts.REOPEN)
        self._reconcile = self._script(scripts.RECONCILE)

    def view(self, job_id: str) -> JobView | None:
        """Returns the current state of a job, or None if there is none."""
        fields = self.redis.hmget(self.keys.job(job_id).record, VIEW_FIELDS)
        return view_of(job_id, cast("list[bytes | None]", fields))

    def lane(self, ref: ChunkRef) -> Lane:
        """Returns the lane of a chunk: its job's, unless it was given back to the heavy one."""
        keys = self.keys.job(ref.job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.hget(keys.record, "lane")
            pipe.hget(keys.chunks, str(ref.index))
            raw, entry = pipe.execute()
        lane = cast(Lane, raw.decode()) if raw else "small"
        return heavy_twin(lane) if entry and _entry(ref, entry).moved else lane

    def estimate(self, ref: ChunkRef) -> Estimate | None:
        """Returns what a chunk was estimated to take, or None if that is not known."""
        fields = self.redis.hmget(self.keys.job(ref.job_id).record, ["run", "each", "origin"])
        run, each, origin = cast("list[bytes | None]", fields)
        if run is None or run.decode() != ref.run or each is None:
            return None
        return Estimate(int(each) / 1000, json.loads(origin or b"{}").get("request_id", ""))

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
            pipe.lrange(self.keys.todo(job_id), 0, -1)
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
        settings, run = self.settings, secrets.token_hex(4)
        asked = request.of_slices(()).to_json() if request.kind.by_slices else ""
        text, kept = request.to_json(), as_kept(request)
        cut = "" if kept is request else kept.to_json()
        size = size or Bytes(len(text) + len(cut), len(cut or text), by.who.client if by else "")
        outcome, *more = self._create(
            keys=[*self.keys.job(request.job_id), self.keys.active, self.keys.ends, self.keys.workers],
            args=[
                request.job_id, run, seen_run, len(request.parts), len(todo),
                text, asked, cut, self.keys.kept(size.client) if size.client else "", size.whole, size.kept,
                plan.chunk_size, plan.chunk_count, settings.job_ttl,
                dump(_origin()), plan.lane, _ms(plan.seconds), _ms(plan.each), _ms(settings.max_backlog),
                "" if deadline_s is None else deadline_s, *(by.arguments if by else ("", "", 0)),
                *(dump(list(part)) for part in in_groups(todo, plan.chunk_size)),
            ],
        )  # fmt: skip
        if outcome == -1:
            raise QueueFullError(plan.lane, more[0] / 1000)
        refs = [ChunkRef(request.job_id, run, i, 0) for i in range(plan.chunk_count)]
        return Created(refs, more[0].decode()) if outcome else None

    def origin(self, job_id: str) -> dict[str, str]:
        """Returns what the job was made for: the id of an HTTP request, and its trace."""
        raw = cast("bytes | None", self.redis.hget(self.keys.job(job_id).record, "origin"))
        return json.loads(raw) if raw else {}

    def start(self, ref: ChunkRef, worker: str = "") -> Chunk | None:
        """Start a chunk, with the first heartbeat of its worker; returns None if it is out of date."""
        keys = self.keys.job(ref.job_id)
        reply = self._start(
            keys=[keys.record, keys.chunks, keys.events, self.keys.active, self.keys.beat(ref.rq_id)],
            args=[
                ref.run, ref.index, ref.attempt, ref.job_id,
                worker, _ms(self.settings.beat_ttl), _asking(ref.job_id),
            ],
        )  # fmt: skip
        if not reply:
            return None
        return chunk_of(_entry(ref, reply[0]), *reply[1:])

    def begin_slices(self, ref: ChunkRef, *, one_by_one: bool) -> bool:
        """Record that the chunk solves slices from now on; returns False if this attempt is over.

        `one_by_one`: each is kept before the next is solved, so that a loss is due to the one at hand.
        """
        keys = self.keys.job(ref.job_id)
        args = (ref.run, ref.index, ref.attempt, "solving" if one_by_one else "ahead")
        return bool(self._solve(keys=[keys.record, keys.chunks], args=args))

    def put_slices(
        self, ref: ChunkRef, chunk: Chunk, offset: int, values: Sequence[Mapping[str, Any]]
    ) -> bool:
        """Keep and count results of the chunk, from its slice `offset` on; False if this attempt is over."""
        settings, request = self.settings, chunk.request
        parts = chunk.parts[offset : offset + len(values)]
        keys = self.keys.job(ref.job_id)
        geometry = request.geometry_hash, request.fixed_leg
        slices = [self.result_keys.slice(*geometry, request.digits, l1) for l1 in parts]
        reply = self._slices(
            keys=[self.result_keys.digits(*geometry), *keys, self.keys.active, self.keys.ends, *slices],
            args=[
                ref.job_id, ref.run, ref.index, ref.attempt,
                offset, int(offset + len(values) == len(chunk.parts)), chunk.first_position + offset,
                request.digits,
                settings.result_ttl, settings.error_ttl, settings.job_ttl,
                *told(zip(parts, values, strict=True)),
            ],
        )  # fmt: skip
        return bool(reply == 1)

    def put_slice_error(self, ref: ChunkRef, kind: str, detail: str) -> bool:
        """Put an error for the slice that is being solved; returns False if there is none."""
        current = self.current(ref)
        if current is None or current[0].state != "solving":
            return False
        entry, chunk = current
        error = slice_error(chunk.request, chunk.parts[entry.offset], kind, detail)
        self.put_slices(ref, chunk, entry.offset, [error])
        return True

    def current(self, ref: ChunkRef) -> tuple[ChunkEntry, Chunk] | None:
        """Returns the entry of this attempt and its chunk, or None if the record has moved on."""
        keys = self.keys.job(ref.job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.hget(keys.chunks, str(ref.index))
            pipe.lindex(self.keys.todo(ref.job_id), ref.index)
            pipe.hmget(keys.record, [_asking(ref.job_id), "chunk_size"])
            raw, todo, fields = pipe.execute()
        entry = raw and _entry(ref, raw)
        if not entry or entry.ref != ref or None in (todo, *fields):
            return None
        return entry, chunk_of(entry, todo, *fields)

    def put_progress(self, ref: ChunkRef, done: int, total: int) -> bool:
        """Record the progress of the job of a document; returns False if this attempt is over."""
        keys = self.keys.job(ref.job_id)
        return bool(
            self._progress(
                keys=[keys.record, keys.chunks, keys.events],
                args=[ref.run, ref.index, ref.attempt, done, total],
            )
        )

    def put_document(self, ref: ChunkRef, request: JobRequest, document: Mapping[str, Any]) -> None:
        """Keep a document, and end its job if this attempt is still open."""
        self._document(
            keys=[
                self.result_keys.document(request.content_hash),
                *self.keys.job(ref.job_id), self.keys.active, self.keys.ends,
            ],
            args=[
                ref.job_id, ref.run, ref.index, ref.attempt, dump(document),
                self.settings.result_ttl, self.settings.job_ttl,
            ],
        )  # fmt: skip

    def fail(self, ref: ChunkRef, kind: str, detail: str) -> list[ChunkEntry] | None:
        """End the job because of this chunk; returns the open chunks, or None if the chunk is out of date."""
        problem = dump({"type": kind, "detail": detail})
        return self._finish(ref.job_id, "failed", problem, ref.run, ref.index, ref.attempt)

    def cancel(self, job_id: str, *, if_unwanted: bool = False) -> list[ChunkEntry] | None:
        """Cancel the job; returns its open chunks, or None if it was not active, or a client wants it."""
        return self._finish(job_id, "unwanted" if if_unwanted else "canceled", "", "", "", "")

    def expire(self, job_id: str) -> list[ChunkEntry] | None:
        """Fail a job whose deadline is over; returns its open chunks, or None if it is not."""
        return self._finish(job_id, "overdue", dump({"type": "timeout", "detail": _OVERDUE}), "", "", "")

    def reopen(self, ref: ChunkRef, lost: Lost = "") -> ChunkRef | Literal["stale", "too-often"]:
        """Open the next attempt at a chunk that was interrupted, or lost its work horse or worker."""
        keys = self.keys.job(ref.job_id)
        settings = self.settings
        bound = settings.max_worker_losses if lost == "workers" else settings.max_losses
        reply = self._reopen(
            keys=[keys.record, keys.chunks, self.keys.ends],
            args=[ref.run, ref.index, ref.attempt, lost, bound],
        )
        if reply == -1:
            return "stale"
        return "too-often" if reply == -2 else ChunkRef(ref.job_id, ref.run, ref.index, int(reply))

    def beat(self, ref: ChunkRef, worker: str) -> bool:
        """Record that `worker` runs this attempt, and renew the locks that it holds.

        Returns whether the attempt is still the current one of a chunk that is not done, in an active job.
        """
        keys = self.keys.job(ref.job_id)
        names = [keys.record, keys.chunks, self.keys.beat(ref.rq_id), self.result_keys.locks(ref.rq_id)]
        ttl = int(self.settings.beat_ttl * 1000)
        return bool(self._beat(keys=names, args=[ref.run, ref.index, ref.attempt, worker, ttl]))

    def end_beat(self, ref: ChunkRef) -> bool:
        """Record that nobody runs this attempt any more: free its locks, and delete its RQ job.

        Returns whether it is still open, as for `beat`.
        """
        keys = self.keys.job(ref.job_id)
        names = [keys.record, keys.chunks, self.keys.beat(ref.rq_id), self.result_keys.locks(ref.rq_id)]
        names.append(Job.key_for(ref.rq_id))
        return bool(self._end_beat(keys=names, args=[ref.run, ref.index, ref.attempt]))

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
        return bool(
            self._reconcile(
                keys=[*self.keys.job(job_id), self.keys.active, self.keys.ends],
                args=[job_id, problem, self.settings.failure_ttl],
            )
        )

    def adopt(self, count: int) -> None:
        """Search about `count` of all keys for active jobs that are missing in the set of active jobs.

        Each call continues where the previous one stopped, in whatever process. Jobs of other versions of the
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
                pipe.zscore(self.keys.active, job_id)
            replies = pipe.execute()
        for job_id, status, listed in zip(job_ids, replies[::2], replies[1::2], strict=True):
            if listed is None and (status or b"").decode() in ACTIVE:
                self.reconcile(job_id)

    def _script(self, text: str) -> Script:
        return self.redis.register_script(scripts.PRELUDE + text)

    def _finish(
        self, job_id: str, status: str, problem: str, run: str, index: int | str, attempt: int | str
    ) -> list[ChunkEntry] | None:
        reply = self._end(
            keys=[*self.keys.job(job_id), self.keys.active, self.keys.ends],
            args=[job_id, status, problem, self.settings.failure_ttl, run, index, attempt],
        )
        if not reply:
            return None
        return [entry_of(job_id, reply[0], *pair) for pair in zip(reply[1::2], reply[2::2], strict=True)]


def _asking(job_id: str) -> str:
    """Returns the field with the request of a job as its chunks need it."""
    kind = kind_of_job(job_id)
    return "asked" if kind is not None and kind.by_slices else "request"


def _entry(ref: ChunkRef, raw: bytes) -> ChunkEntry:
    return entry_of(ref.job_id, ref.run.encode(), b"%d" % ref.index, raw)


def _origin() -> dict[str, str]:
    """Returns the id of the HTTP request that is being answered, and where its trace goes on."""
    known = {"request_id": subject("request_id")} if subject("request_id") else {}
    if trace := tracing.carrier():
        known |= {**trace, "submitted": str(time.time_ns())}
    return known


def _ms(seconds: float) -> int:
    return max(1, round(1000 * seconds))
