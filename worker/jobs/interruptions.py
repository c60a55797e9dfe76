"""What becomes of a chunk whose process ended before its time."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

from redis import Redis
from redis.client import Pipeline

from worker.answers import JobRequest
from worker.answers.kinds import Outcome, kind_of_job, request_from_json
from worker.answers.tables import slice_error
from worker.jobs.attempts import Attempts, Chunk, is_done
from worker.jobs.chunks import ChunkEntry, ChunkRef, entry_from_json
from worker.jobs.keys import InRedis
from worker.jobs.plan import Lane
from worker.jobs.records import JobRecords, about_of
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

MAX_LOSSES = 2
"""How often a slice, an item or a document is tried again after the death of its process, for which it is
most likely to blame."""

MAX_WORKER_LOSSES = 10
"""The same after it was lost with its worker: most likely the machine is to blame, and three restarts must
not fail a job. But what makes the kernel kill its worker must end, too."""

Why = Literal["stopped", "lost", "crashed", "memory", "timeout"]


@dataclass(frozen=True)
class Cause:
    """Why a process ended.

    Attributes:
        why: its worker `stopped`, or was `lost` with it; or it `crashed`, ran out of `memory`, or reached its
            time limit (`timeout`).
        detail: the same in words.
    """

    why: Why
    detail: str = ""

    @property
    def kind(self) -> str:
        """The kind of error of a part that is given up for it."""
        kinds = {"lost": "worker-lost", "memory": "resource-exhausted", "timeout": "timeout"}
        return kinds.get(self.why, "worker-crashed")


@dataclass(frozen=True)
class _Seen:
    """An interrupted attempt, and how its job stands."""

    request: JobRequest
    entry: ChunkEntry
    bits: bytes
    about: str

    @property
    def at(self) -> int | None:
        """The position of the first part that is not done: to blame if they are stored one by one."""
        places = range(self.entry.first, self.entry.last + 1)
        return next((i for i in places if not is_done(self.bits, i)), None)

    def may_be_single(self, cause: Cause) -> bool:
        """Whether one of its parts is to blame and can be given up, so that it must be found out which."""
        return self.request.kind.by_items or (self.request.kind.by_slices and cause.why != "timeout")


def following_of(seen: _Seen, cause: Cause) -> ChunkEntry | None:
    """Returns the entry of the next attempt; None if what was being processed is to be given up.

    Losses are counted for the first part that is not done. They are not while it is unknown which one is to
    blame, since parts are stored in groups; the next attempt finds out.
    """
    entry, at = seen.entry, seen.at
    if cause.why == "stopped" or at is None:  # if all is stored, the next attempt says so
        return entry.following()
    if cause.why == "timeout" and entry.lane == "small":
        return entry.following(lane="heavy")
    if not entry.is_single and seen.may_be_single(cause):
        losses = entry.worker_losses + (cause.why == "lost")
        return entry.following(is_single=True, worker_losses=losses)
    if cause.why in ("memory", "timeout"):  # it would happen again
        return None
    return _with_one_more_loss(entry, at if entry.is_begun or not seen.request.kind.by_slices else -2, cause)


def _with_one_more_loss(entry: ChunkEntry, at: int, cause: Cause) -> ChunkEntry | None:
    """Returns the entry of the next attempt after a loss at a part; None if there were too many.

    `at` is -2 for what is computed once for all parts.
    """
    is_same = entry.at == at
    losses = (entry.losses if is_same else 0) + (cause.why == "crashed")
    lost = (entry.worker_losses if is_same or entry.at == -1 else 0) + (cause.why == "lost")
    if losses > MAX_LOSSES or lost > MAX_WORKER_LOSSES:
        return None
    return entry.following(is_single=True, at=at, losses=losses, worker_losses=lost)


class Interruptions(InRedis):
    """Decides what becomes of interrupted chunks."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.records = JobRecords(redis, settings)
        self.attempts = Attempts(redis, settings)
        self.chunks = self.records.chunks

    def happened(self, ref: ChunkRef, cause: Cause) -> str:
        """Open the next attempt at a chunk, or give up what was being processed.

        Returns what was given up, and why; empty if nothing was, or the attempt was out of date.
        """
        seen = self._look(ref)
        if seen is None:
            return ""
        if what := {"lost": "workers", "crashed": "horses"}.get(cause.why):
            self.redis.hincrby(self.keys.ends, f"lost:{what}", 1)
        following = following_of(seen, cause)
        if following is None:
            return self._give_up(ref, seen, cause)
        if following.lane != seen.entry.lane:
            self._demote(ref, seen.about)
        else:
            self._again(ref, seen, following)
        return ""

    def _give_up(self, ref: ChunkRef, seen: _Seen, cause: Cause) -> str:
        """Give up the part that is being processed, and have the others done; or fail the job."""
        at, request, entry = seen.at, seen.request, seen.entry
        assert at is not None, "something is left to be given up"
        what = request.kind.name
        if request.kind.by_items:
            what = f"item {at}"
            failure = {"type": cause.kind, "detail": cause.detail}
            self.attempts.put_items(ref, entry.last, {at: Outcome(failure)}, {})
        elif request.kind.by_slices and entry.is_begun and cause.why != "timeout":
            what = f"slice {request.parts[at]}"
            error = slice_error(request, request.parts[at], cause.kind, cause.detail)
            chunk = Chunk(request, (at,), entry.last, True, entry)
            self.attempts.put_slices(ref, chunk, [at], [error])
        else:
            self.records.fail(ref.job_id, ref.run, cause.kind, cause.detail)
            return f"{what}: {cause.kind}: {cause.detail}"
        if at < entry.last:
            self._again(ref, seen, entry.following(is_single=True, at=-1, losses=0, worker_losses=0))
        return f"{what}: {cause.kind}: {cause.detail}"

    def _look(self, ref: ChunkRef) -> _Seen | None:
        keys = self.keys.job(ref.job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.hmget(keys.record, ["run", "status", "request"])
            pipe.hget(keys.chunks, str(ref.index))
            pipe.get(keys.bits)
            (run, status, request), raw, bits = pipe.execute()
        is_active = (status or b"").decode() in ("queued", "running") and (run or b"").decode() == ref.run
        entry = entry_from_json(raw) if raw else None
        if not is_active or entry is None or entry.attempt != ref.attempt or request is None:
            return None
        asked = request_from_json(request)
        return _Seen(asked, entry, bits or b"", about=about_of(asked))

    def _again(self, ref: ChunkRef, seen: _Seen, following: ChunkEntry) -> None:
        """Put the next attempt before all others, unless somebody else has."""
        self._replace(ref, {ref.index: following}, seen.about)

    def _replace(
        self,
        ref: ChunkRef,
        entries: Mapping[int, ChunkEntry],
        about: str,
        *,
        lane: Lane | None = None,
        at_front: bool = True,
    ) -> bool:
        """Replace attempts at chunks of a job by the next ones, in one transaction.

        Returns False if this attempt has been replaced meanwhile.
        """
        keys = self.keys.job(ref.job_id)

        def step(pipe: Pipeline) -> bool:
            run, status, left, old = cast(
                "list[bytes | None]", pipe.hmget(keys.record, ["run", "status", "left", "lane"])
            )
            raw = cast("bytes | None", pipe.hget(keys.chunks, str(ref.index)))
            is_active = status in (b"queued", b"running") and run == ref.run.encode()
            pipe.multi()
            if not is_active or raw is None or entry_from_json(raw).attempt != ref.attempt:
                return False
            self.chunks.enqueue(pipe, ref.job_id, ref.run, entries, about, at_front=at_front)
            if lane is not None and old != lane.encode():
                pipe.hset(keys.record, "lane", lane)
                pipe.hincrby(self.keys.work, f"{(old or b'').decode()}:done", int(left or 0))
                pipe.hincrby(self.keys.work, f"{lane}:added", int(left or 0))
            return True

        watched = (keys.record, keys.chunks)
        is_done = bool(self.redis.transaction(cast(Any, step), *watched, value_from_callable=True))
        if is_done:
            self.chunks.discard(
                replace(ref, index=index, attempt=entry.attempt - 1).rq_id for index, entry in entries.items()
            )
        return is_done

    def _demote(self, ref: ChunkRef, about: str) -> None:
        """Move a chunk that takes too long to the heavy lane, with all small ones of its job that wait."""
        small = self.records.open_chunks([ref.job_id])[ref.job_id]
        others = {o: e for o, e in small.items() if e.lane == "small" and o.run == ref.run and o != ref}
        with self.redis.pipeline(transaction=False) as pipe:
            for other in others:
                pipe.exists(self.keys.beat(other.rq_id))
            beats = pipe.execute()
        waiting = {o: e for (o, e), beat in zip(others.items(), beats, strict=True) if not beat}
        moved = {
            o.index: replace(e.following(), lane="heavy") for o, e in {ref: small[ref], **waiting}.items()
        }
        if self._replace(ref, moved, about, lane="heavy", at_front=False):
            kind = kind_of_job(ref.job_id)
            self.redis.hincrby(self.keys.ends, f"demoted:{kind.prefix[:-1] if kind else ''}", 1)
            log.warning("the job %s takes longer than estimated; it is heavy now", ref.job_id)
