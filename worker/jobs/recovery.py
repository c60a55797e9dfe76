"""Chunks that were interrupted or lost: each is run again until its retry budget is spent."""

from __future__ import annotations

import logging
import threading
from typing import cast

from redis import Redis
from redis.exceptions import OutOfMemoryError, RedisError

from worker.answers.kinds import is_batch, kind_of_job
from worker.jobs.attempts import Attempts
from worker.jobs.batches import Batches
from worker.jobs.chunks import ChunkEntry, ChunkQueue, ChunkRef, Lost
from worker.jobs.inventory import Inventory
from worker.jobs.records import JobRecords
from worker.jobs.views import JobView
from worker.logs import about
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_WALK = 4000  # keys per sweep, about a millisecond of the server's time

_LOST = "The worker crashed or was killed repeatedly ({} times). Post the request again to retry it."


def _overdue(view: JobView) -> str:
    kind = kind_of_job(view.id)
    name = "job" if kind is None else kind.name
    estimate = "unknown" if view.estimate_s is None else f"{view.estimate_s:.2f} s"
    ran = "it had not begun" if view.run_seconds is None else f"it has run for {view.run_seconds:.1f} s"
    return f"{name}: timeout at the deadline of its request; {ran}, the estimate was {estimate}"


class Interruptions:
    """What becomes of a chunk that was interrupted."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.records = JobRecords(redis, settings)
        self.attempts = Attempts(redis, settings)
        self.batches = Batches(redis, settings)
        self.chunks = ChunkQueue(redis, settings)

    def run_again(self, ref: ChunkRef, lost: Lost, kind: str, detail: str) -> bool:
        """Put the next attempt at the front of its lane; returns False if there is none.

        If it was lost too often, what was being processed is given up. `kind` and `detail` say why.
        """
        following = self.attempts.reopen(ref, lost)
        if following == "too-often":
            return self.give_up(ref, kind, detail)
        return self._enqueue(following)

    def give_up(self, ref: ChunkRef, kind: str, detail: str) -> bool:
        """Give up the slice or item being processed, and have the others computed; False if none is left.

        A chunk without slices or items, such as a document, fails its job. One that was ahead of what it had
        kept runs again, slice by slice, until it is known which one to give up. `kind` and `detail` say why.
        """
        if self.attempts.is_ahead(ref):
            return self._enqueue(self.attempts.reopen(ref, "horses"))
        put = self.batches.give_up_item if is_batch(ref.job_id) else self.attempts.put_slice_error
        if put(ref, kind, detail):
            return self._enqueue(self.attempts.reopen(ref))
        self.fail(ref, kind, detail)
        return False

    def fail(self, ref: ChunkRef, kind: str, detail: str) -> None:
        """End the job because of this chunk, and the work on the others."""
        entries = self.records.fail(ref, kind, detail) or []
        self.chunks.withdraw([entry for entry in entries if entry.ref != ref])

    def _enqueue(self, following: ChunkRef | str) -> bool:
        if isinstance(following, ChunkRef):
            self.chunks.put_back(following, self.attempts.lane(following))
            return True
        return False


class Sweeper:
    """Finds chunks that no worker runs any more, and enqueues them again.

    A chunk that is not done must be in a queue or have a heartbeat. A chunk with neither (its worker was
    killed, or a process died between two steps) is suspected and, if it stays so, put back in the queue. A
    job that lost one of its keys in Redis is repaired, or fails. A job whose deadline is over fails, queued
    or running. Any number of sweepers may run, but only one at a time searches.
    """

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self.records = JobRecords(redis, settings)
        self.chunks = ChunkQueue(redis, settings)
        self.inventory = Inventory(redis, settings)
        self.interruptions = Interruptions(redis, settings)
        self.keys = self.records.keys

    def sweep(self) -> int:
        """Search once, unless another search is recent; returns the number of chunks put back."""
        pause = int(self.settings.sweep_interval * 1000)
        try:
            if not self.redis.set(self.keys.sweep_lock, 1, nx=True, px=pause):
                return 0
        except OutOfMemoryError:  # it is so full that there is no place for the lock
            self._relieve()
            raise
        # The order matters: a chunk that leaves the queue after this look has a heartbeat soon, and a chunk
        # opened after the look at the records is not among them.
        self.records.adopt(_WALK)
        self._end_overdue_jobs()
        self._relieve()
        entries = self.records.open_chunks()
        waiting = self.chunks.waiting()
        missing = self._without_beat([e for e in entries if e.ref.rq_id not in waiting])
        return sum(self._put_back(entry) for entry in self._overdue(missing))

    def run(self, stop: threading.Event) -> None:
        """Search periodically until `stop` is set; for a thread of an API process."""
        while not stop.wait(self.settings.sweep_interval):
            try:
                self.sweep()
            except RedisError:
                continue
            except Exception:
                log.exception("a search for lost chunks failed")

    def _relieve(self) -> None:
        if removed := self.inventory.relieve():
            log.warning("the store is nearly full: removed the oldest results (%d keys)", removed)

    def _end_overdue_jobs(self) -> None:
        for job_id in self.records.overdue():
            entries = self.records.expire(job_id)
            if entries is not None and (view := self.records.view(job_id)) is not None:
                with about(job=job_id):
                    log.warning("%s", _overdue(view))
            self.chunks.withdraw(entries or [])

    def _without_beat(self, entries: list[ChunkEntry]) -> list[ChunkEntry]:
        with self.redis.pipeline(transaction=False) as pipe:
            for entry in entries:
                pipe.exists(self.keys.beat(entry.ref.rq_id))
            return [entry for entry, beats in zip(entries, pipe.execute(), strict=True) if not beats]

    def _overdue(self, missing: list[ChunkEntry]) -> list[ChunkEntry]:
        suspects = cast("dict[bytes, bytes]", self.redis.hgetall(self.keys.suspects))
        if not suspects and not missing:
            return []
        seconds, micros = self.redis.time()
        now = seconds + micros / 1e6
        since = {raw.decode(): float(first) for raw, first in suspects.items()}
        ids = {entry.ref.rq_id for entry in missing}
        with self.redis.pipeline(transaction=False) as pipe:
            for rq_id in since.keys() - ids:
                pipe.hdel(self.keys.suspects, rq_id)
            for rq_id in ids - since.keys():
                pipe.hset(self.keys.suspects, rq_id, repr(now))
            pipe.execute()
        return [e for e in missing if now - since.get(e.ref.rq_id, now) >= self.settings.lost_grace]

    def _put_back(self, entry: ChunkEntry) -> bool:
        self.chunks.discard(entry.ref)
        detail = _LOST.format(entry.workers_lost + 1)
        return self.interruptions.run_again(entry.ref, "workers", "worker-lost", detail)
