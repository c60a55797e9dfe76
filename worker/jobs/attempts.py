"""The steps of one attempt at a chunk, as the process that computes takes them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

from redis import Redis
from redis.client import Pipeline

from worker.answers import JobRequest, SliceJson
from worker.answers.designs import answered
from worker.answers.kinds import Item, Outcome, as_kept, item_from_json, request_from_json
from worker.answers.layout import dump
from worker.answers.store import LOCK_SECONDS, ResultStore, packed
from worker.jobs.chunks import ChunkEntry, ChunkRef, entry_from_json
from worker.jobs.keys import InRedis
from worker.settings import WorkerSettings

BEAT_TTL = 5.0
"""Seconds after which a chunk without a heartbeat is taken for lost: several, also on a busy machine."""


class ItemsLostError(Exception):
    """Redis no longer has the items of a batch."""


@dataclass(frozen=True)
class Chunk:
    """What an attempt is to do.

    Attributes:
        request: the question of the job; of a batch without its items.
        positions: those of the parts that are to be done, in ascending order.
        last: the position of the last part of the chunk.
        counts: whether the job waits for it. One that has ended, or was started anew, does not.
        entry: how it stands in the record.
        origin: the id of the HTTP request that made the job, if one did, and its trace.
    """

    request: JobRequest
    positions: tuple[int, ...]
    last: int
    counts: bool
    entry: ChunkEntry
    origin: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def parts(self) -> list[str]:
        """The parts that are to be done."""
        parts = self.request.parts
        return [parts[position] for position in self.positions]


class Attempts(InRedis):
    """The attempts at the chunks of an installation."""

    def __init__(self, redis: Redis, settings: WorkerSettings, store: ResultStore | None = None) -> None:
        super().__init__(redis, settings)
        self.store = store or ResultStore(redis, settings)

    def start(self, ref: ChunkRef, first: int, last: int) -> Chunk | None:
        """Begin an attempt at the parts from `first` to `last`.

        Returns None if Redis has lost the job, the job was canceled, or another attempt has begun. What
        somebody requeues after the end of a job is computed.
        """
        reply = self._run(
            "start", self.keys.names(ref.job_id), job_id=ref.job_id, run=ref.run, index=ref.index
        )
        if not reply:
            return None
        counts, status, request, origin, bits, raw = reply
        entry = _entry_of(ref, raw) if counts else None
        if status == b"canceled" or (counts and entry is None):
            return None
        done = bits if counts else b""
        return Chunk(
            request_from_json(request),
            tuple(i for i in range(first, last + 1) if not is_done(done, i)),
            last,
            bool(counts),
            entry or ChunkEntry(first, last, "heavy", is_single=True),
            json.loads(origin or "{}"),
        )

    def beat(self, ref: ChunkRef, worker: str) -> bool:
        """Say that a worker runs an attempt, and renew the locks that it holds.

        Returns whether the job still waits for this attempt.
        """
        keys, locks = self.keys.job(ref.job_id), self.store.keys.locks(ref.rq_id)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.set(self.keys.beat(ref.rq_id), worker, px=int(1000 * BEAT_TTL))
            pipe.hmget(keys.record, ["run", "status"])
            pipe.hget(keys.chunks, str(ref.index))
            pipe.smembers(locks)
            _, (run, status), raw, held = pipe.execute()
            if held:
                for key in (locks, *held):
                    pipe.pexpire(key, int(1000 * LOCK_SECONDS))
                pipe.execute()
        is_active = status in (b"queued", b"running") and run == ref.run.encode()
        return is_active and (raw is None or entry_from_json(raw).attempt == ref.attempt)

    def begin_parts(self, ref: ChunkRef) -> None:
        """Note that what the parts have in common is known, so that each may be to blame for a loss."""
        chunks = self.keys.job(ref.job_id).chunks

        def step(pipe: Pipeline) -> None:
            raw = cast("bytes | None", pipe.hget(chunks, str(ref.index)))
            entry = None if raw is None else entry_from_json(raw)
            pipe.multi()
            if entry is not None and entry.attempt == ref.attempt:
                pipe.hset(chunks, str(ref.index), replace(entry, is_begun=True).to_json())

        self.redis.transaction(step, chunks)

    def put_slices(
        self, ref: ChunkRef, chunk: Chunk, positions: Sequence[int], values: Sequence[SliceJson]
    ) -> bool:
        """Keep slices, or the errors in their place, and count them; returns whether more are wanted."""
        names = [chunk.request.parts[position] for position in positions]
        self.store.put_slices(chunk.request, dict(zip(names, values, strict=True)))
        if not chunk.counts:
            return True
        parts: list[Any] = []
        for position, name, value in zip(positions, names, values, strict=True):
            parts += [position, name, packed(value) if "error" in value else "", 0, ""]
        return self._put(ref, "slice", parts, is_last=chunk.last in positions)

    def put_items(
        self, ref: ChunkRef, last: int, outcomes: Mapping[int, Outcome], items: Mapping[int, Item]
    ) -> bool:
        """Count items of a batch, whose answers are kept; returns whether more are wanted.

        Of a long one in `items` only the hash is kept from now on.
        """
        parts: list[Any] = []
        for position, outcome in outcomes.items():
            kept = _shortened(items.get(position))
            parts += [position, position, outcome.to_json(), int(outcome.failure is not None), kept]
        return self._put(ref, "item", parts, is_last=last in outcomes)

    def close(self, ref: ChunkRef) -> None:
        """Note that a chunk is done, whose last part was done by an earlier attempt."""
        self._put(ref, "slice", [], is_last=True)

    def _put(self, ref: ChunkRef, of: str, parts: Sequence[Any], *, is_last: bool) -> bool:
        reply = self._run(
            "put",
            self.keys.names(ref.job_id),
            job_id=ref.job_id,
            run=ref.run,
            index=ref.index,
            is_last=is_last,
            of=of,
            ttl=self.settings.result_ttl_seconds,
            parts=parts,
        )
        return bool(reply == 1)

    def put_document(self, ref: ChunkRef, request: JobRequest, document: Mapping[str, Any]) -> None:
        """Keep a document, which ends its job; that of a search that was stopped is the answer of this job
        alone."""
        own = answered(request, dict(document))
        self.store.put_document(own, document)
        self._run(
            "end",
            self.keys.names(ref.job_id),
            job_id=ref.job_id,
            run=ref.run,
            status="succeeded" if own is request else "stopped",
            problem="" if own is request else own.content_hash,
            ttl=self.settings.result_ttl_seconds,
        )

    def put_progress(self, ref: ChunkRef, done: int, total: int) -> bool:
        """Record the progress of the job of a document; returns whether it is still wanted."""
        return self._tell(ref, done, total, 0, "")

    def put_improvement(self, ref: ChunkRef, number: int, improvement: Mapping[str, Any]) -> None:
        """Tell of an improvement of a search, by its number among the candidates, once for all chunks."""
        self._tell(ref, 0, 0, number, dump(improvement))

    def _tell(self, ref: ChunkRef, done: int, total: int, improved: int, improvement: str) -> bool:
        of = {"done": done, "total": total, "improved": improved, "improvement": improvement}
        return bool(self._run("put_progress", self.keys.names(ref.job_id), of, run=ref.run))

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

    def items(self, ref: ChunkRef, chunk: Chunk) -> dict[int, Item]:
        """Returns the items of a chunk that are to be answered, by position.

        Raises:
            ItemsLostError: Redis no longer has them.
        """
        if not chunk.positions:
            return {}
        first = chunk.positions[0]
        texts = self.redis.lrange(self.keys.job(ref.job_id).items, first, chunk.last)
        found: dict[int, Item] = {}
        with suppress(IndexError):
            for position in chunk.positions:
                found[position] = item_from_json(cast("list[bytes]", texts)[position - first])
        if len(found) < len(chunk.positions):
            raise ItemsLostError(ref.job_id)
        return found


def _entry_of(ref: ChunkRef, raw: bytes | None) -> ChunkEntry | None:
    """Returns how the chunk of an attempt stands; None if it is done, or another attempt has begun."""
    entry = entry_from_json(raw) if raw else None
    return entry if entry is not None and entry.attempt == ref.attempt else None


def _shortened(item: Item | None) -> str:
    """Returns what is kept of a long item; empty if it is kept as it is."""
    if item is None or item.request is None or (kept := as_kept(item.request)) is item.request:
        return ""
    return replace(item, request=kept).to_json()


def is_done(bits: bytes, position: int) -> bool:
    """Whether the bit of a part is set."""
    return position // 8 < len(bits) and bool(bits[position // 8] & (0x80 >> position % 8))
