"""The search for what no worker works on any more."""

from __future__ import annotations

import logging
import threading
from collections.abc import Collection, Iterable
from contextlib import suppress
from typing import cast

from redis import Redis
from redis.exceptions import OutOfMemoryError, RedisError

from worker.answers.kinds import kind_of_job
from worker.jobs.chunks import ChunkEntry, ChunkRef
from worker.jobs.interruptions import Cause, Interruptions
from worker.jobs.inventory import Inventory
from worker.jobs.keys import InRedis
from worker.jobs.records import JobRecords
from worker.logs import about
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

SWEEP_SECONDS = 2.0
"""Seconds between two searches: so a chunk is back 5 to 9 s after the death of its worker (`BEAT_TTL`)."""

GRACE = 1.5
"""Seconds for which a chunk must be missing, as seen by two searches: from the moment at which a worker takes
it from the queue to its first heartbeat it is nowhere."""

_LOST = "The worker crashed or was killed repeatedly ({} times). Post the request again to retry it."
_VANISHED = "The server lost a part of this job's record. Posting the request again computes what is missing."


class Sweeper(InRedis):
    """Finds chunks that no worker runs any more, and opens the next attempt at them.

    A chunk that is not done waits in a queue, or has a heartbeat. One with neither was lost with its worker,
    or by Redis. A job whose deadline is over fails, queued or running. Every worker and every API process
    sweeps, but only one of them at a time.
    """

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.records = JobRecords(redis, settings)
        self.inventory = Inventory(redis, settings)
        self.interruptions = Interruptions(redis, settings)

    def sweep(self) -> int:
        """Search once, unless another search is recent; returns the number of chunks that were missing."""
        try:
            if not self.redis.set(self.keys.sweep_lock, 1, nx=True, px=int(1000 * SWEEP_SECONDS)):
                return 0
        except OutOfMemoryError:  # it is so full that there is no place for the lock
            self._relieve()
            raise
        self._relieve()
        for job_id in self.records.overdue():
            with about(job=job_id):
                kind = kind_of_job(job_id)
                log.warning("%s: timeout at the deadline of its request", kind.name if kind else "job")
        return self._find_lost()

    def run(self, stop: threading.Event) -> None:
        """Search periodically until `stop` is set; for a thread of an API process."""
        while not stop.wait(SWEEP_SECONDS):
            with suppress(RedisError):
                try:
                    self.sweep()
                except RedisError:
                    raise
                except Exception:
                    log.exception("a search for lost chunks failed")

    def _relieve(self) -> None:
        if removed := self.inventory.relieve():
            log.warning("the store is nearly full: removed the oldest results (%d keys)", removed)

    def _find_lost(self) -> int:
        """Open the next attempt at each chunk that is missing for long enough."""
        active = self.records.active()
        if not active:
            return 0
        # The order matters: what leaves the queue after this look has a heartbeat soon, and a chunk that is
        # made after the look at the records is not among them.
        by_job = self.records.open_chunks(active)
        waiting = self.records.chunks.waiting()
        chunks = {ref: entry for of_job in by_job.values() for ref, entry in of_job.items()}
        self._end_vanished(job_id for job_id, of_job in by_job.items() if not of_job)
        missing = self._without_beat([ref for ref in chunks if ref.rq_id not in waiting])
        lost = self._suspected(missing)
        for ref in lost:
            self._put_back(ref, chunks[ref])
        return len(lost)

    def _without_beat(self, refs: Collection[ChunkRef]) -> list[ChunkRef]:
        with self.redis.pipeline(transaction=False) as pipe:
            for ref in refs:
                pipe.exists(self.keys.beat(ref.rq_id))
            return [ref for ref, beats in zip(refs, pipe.execute(), strict=True) if not beats]

    def _suspected(self, missing: Collection[ChunkRef]) -> list[ChunkRef]:
        """Returns those of the chunks that were missing before; notes the others."""
        suspects = cast("dict[bytes, bytes]", self.redis.hgetall(self.keys.suspects))
        if not suspects and not missing:
            return []
        now, ids = self.now(), {ref.rq_id for ref in missing}
        since = {raw.decode(): float(first) for raw, first in suspects.items()}
        with self.redis.pipeline(transaction=False) as pipe:
            for rq_id in since.keys() - ids:
                pipe.hdel(self.keys.suspects, rq_id)
            for rq_id in ids - since.keys():
                pipe.hset(self.keys.suspects, rq_id, repr(now))
            pipe.execute()
        return [ref for ref in missing if now - since.get(ref.rq_id, now) >= GRACE]

    def _put_back(self, ref: ChunkRef, entry: ChunkEntry) -> None:
        log.info("the chunk %s was lost; it is tried again", ref.rq_id)
        self.interruptions.happened(ref, Cause("lost", _LOST.format(entry.worker_losses + 1)))

    def _end_vanished(self, job_ids: Iterable[str]) -> None:
        """Fail active jobs without a chunk, which no worker could ever end, unless they have just ended."""
        for job_id in job_ids:
            view = self.records.view(job_id)
            if view is None:
                self.redis.zrem(self.keys.active, job_id)
            elif not view.is_terminal and not self.redis.exists(self.keys.job(job_id).chunks):
                self.records.fail(job_id, view.run, "worker-lost", _VANISHED)
