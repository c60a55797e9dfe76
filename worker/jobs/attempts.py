"""The steps of one attempt at a chunk, each an atomic script.

A worker starts the attempt, keeps what it computes and sends heartbeats. If the attempt is interrupted, the
next one is opened; from then on, steps of the older one have no effect.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Literal, cast

from redis import Redis
from rq.job import Job

from worker.answers import JobRequest
from worker.answers.kinds import is_batch, kind_of_job
from worker.answers.layout import ResultKeys, dump
from worker.answers.store import slice_arguments
from worker.answers.tables import slice_error
from worker.jobs.chunks import Chunk, ChunkEntry, ChunkRef, Estimate, Lost, chunk_of, entry_of
from worker.jobs.plan import InRedis, Lane, heavy_twin
from worker.settings import WorkerSettings


class ChunkReader(InRedis):
    """Reads what the records of jobs say of their chunks."""

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

    def current(self, ref: ChunkRef) -> tuple[ChunkEntry, Chunk] | None:
        """Returns the entry of this attempt and its chunk, or None if the record has moved on."""
        keys = self.keys.job(ref.job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.hget(keys.chunks, str(ref.index))
            pipe.lindex(self.keys.job(ref.job_id).todo, ref.index)
            pipe.hmget(keys.record, [_asking(ref.job_id), "chunk_size"])
            raw, todo, fields = pipe.execute()
        entry = raw and _entry(ref, raw)
        if not entry or entry.ref != ref or None in (todo, *fields):
            return None
        return entry, chunk_of(entry, todo, *fields)

    def is_ahead(self, ref: ChunkRef) -> bool:
        """Whether the chunk solves slices of which it has not kept the one before."""
        current = self.current(ref)
        return current is not None and current[0].state == "ahead"

    def items_done(self, ref: ChunkRef) -> int:
        """Returns how many items of a chunk are done; 0 if it has none, or its record has moved on."""
        current = self.current(ref) if is_batch(ref.job_id) else None
        return 0 if current is None else current[0].offset

    def reason_to_stop(self, ref: ChunkRef, reserve: float) -> str | None:
        """Returns why a search is to end with what it has found: it was canceled, or its deadline is near.

        `reserve`: the seconds that its proof may take; a third of the time is enough for a short one.
        """
        fields = self.redis.hmget(self.keys.job(ref.job_id).record, ["stopping", "deadline", "created"])
        stopping, deadline, created = cast("list[bytes | None]", fields)
        if stopping is not None:
            return "canceled"
        if deadline is None or created is None:
            return None
        reserve = min(reserve, (float(deadline) - float(created)) / 3)
        return "deadline" if self.now() > float(deadline) - reserve else None


class Attempts(ChunkReader):
    """The attempts at the chunks of an installation."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.result_keys = ResultKeys.of(settings)

    def start(self, ref: ChunkRef, worker: str = "") -> Chunk | None:
        """Start a chunk, with the first heartbeat of its worker; returns None if it is out of date."""
        reply = self._step(
            "start",
            ref,
            beat=self.keys.beat(ref.rq_id),
            rq_job=Job.key_for(ref.rq_id),
            worker=worker,
            ttl=self._beat_ms,
            asking=_asking(ref.job_id),
        )
        return chunk_of(_entry(ref, reply[0]), *reply[1:]) if reply else None

    def begin_slices(self, ref: ChunkRef, *, one_by_one: bool) -> bool:
        """Record that the chunk solves slices, or answers items; returns False if this attempt is over.

        `one_by_one`: each is kept before the next is solved, so that a loss is due to one of them.
        """
        return bool(self._step("begin_slices", ref, state="solving" if one_by_one else "ahead"))

    def put_slices(
        self, ref: ChunkRef, chunk: Chunk, offset: int, values: Sequence[Mapping[str, Any]]
    ) -> bool:
        """Keep and count results of the chunk, from its slice `offset` on; False if this attempt is over."""
        settings, request = self.settings, chunk.request
        parts = chunk.parts[offset : offset + len(values)]
        geometry = request.geometry_hash, request.fixed_leg
        reply = self._step(
            "put_slices",
            ref,
            known_digits=self.result_keys.digits(*geometry),
            slice_keys=[self.result_keys.slice(*geometry, request.digits, l1) for l1 in parts],
            offset=offset,
            is_last=offset + len(values) == len(chunk.parts),
            position=chunk.first_position + offset,
            digits=request.digits,
            ttl=settings.lifetime(request.kind.name),
            error_ttl=settings.error_ttl,
            digits_ttl=settings.longest_lifetime,
            job_ttl=settings.job_ttl,
            stored=slice_arguments(zip(parts, values, strict=True)),
        )
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

    def put_progress(self, ref: ChunkRef, done: int, total: int) -> bool:
        """Record the progress of the job of a document; returns False if this attempt is over."""
        return bool(self._step("put_progress", ref, done=done, total=total))

    def put_improvement(self, ref: ChunkRef, number: int, improvement: Mapping[str, Any]) -> None:
        """Tell of an improvement of a search, by its number among the candidates, once for all chunks."""
        self._step("put_improvement", ref, number=number, json=dump(improvement))

    def put_document(
        self, ref: ChunkRef, request: JobRequest, document: Mapping[str, Any], *, is_whole: bool = True
    ) -> None:
        """Keep a document, and end its job if this attempt is still open.

        `is_whole`: whether it answers the question of the job; else it is the answer of this job alone.
        """
        self._step(
            "put_document",
            ref,
            document=self.result_keys.document(request.content_hash),
            json=dump(document),
            own_hash="" if is_whole else request.content_hash,
            document_ttl=self.settings.lifetime(request.kind.name),
            job_ttl=self.settings.job_ttl,
        )

    def reopen(self, ref: ChunkRef, lost: Lost = "") -> ChunkRef | Literal["stale", "too-often"]:
        """Open the next attempt at a chunk that was interrupted, or lost its work horse or worker."""
        settings = self.settings
        bound = settings.max_worker_losses if lost == "workers" else settings.max_losses
        reply = self._step("reopen", ref, lost=lost, max_losses=bound)
        if reply == -1:
            return "stale"
        return "too-often" if reply == -2 else ChunkRef(ref.job_id, ref.run, ref.index, int(reply))

    def note_overrun(self, ref: ChunkRef, *, is_new: bool, gives_back: bool) -> tuple[ChunkRef, Lane] | None:
        """Note that an attempt takes a few times its estimate, the first time if it `is_new`.

        A worker that is kept for short work gives such a chunk back, once, to a lane from which it takes
        nothing. The next attempt continues where this one stopped, and no loss is counted.

        Returns the next attempt and its lane if this one is to be given back, which its worker then ends.
        """
        reply = self._step("note_overrun", ref, is_new=is_new, gives_back=gives_back)
        if not reply[0]:
            return None
        return ChunkRef(ref.job_id, ref.run, ref.index, int(reply[1])), cast(Lane, reply[2].decode())

    def beat(self, ref: ChunkRef, worker: str) -> bool:
        """Record that `worker` runs this attempt, and renew the locks that it holds.

        Returns whether the attempt is still the current one of a chunk that is not done, in an active job.
        """
        return bool(self._step("beat", ref, **self._beat_keys(ref), worker=worker, ttl=self._beat_ms))

    def end_beat(self, ref: ChunkRef) -> bool:
        """Record that this attempt no longer runs: release its locks, and delete its RQ job.

        Returns whether it is still open, as for `beat`.
        """
        return bool(self._step("end_beat", ref, **self._beat_keys(ref), rq_job=Job.key_for(ref.rq_id)))

    @property
    def _beat_ms(self) -> int:
        return max(1, round(1000 * self.settings.beat_ttl))

    def _beat_keys(self, ref: ChunkRef) -> dict[str, str]:
        return {"beat": self.keys.beat(ref.rq_id), "locks": self.result_keys.locks(ref.rq_id)}

    def _step(self, script: str, ref: ChunkRef, **values: Any) -> Any:
        return self._run(script, self.keys.names(ref.job_id), vars(ref), **values)


def _asking(job_id: str) -> str:
    """Returns the field with the request of a job as its chunks need it."""
    kind = kind_of_job(job_id)
    return "asked" if kind is not None and kind.by_slices else "request"


def _entry(ref: ChunkRef, raw: bytes) -> ChunkEntry:
    return entry_of(ref.job_id, ref.run.encode(), b"%d" % ref.index, raw)
