"""Chunks of jobs, and the RQ jobs that carry the attempts at them.

An attempt is an RQ job with an id of its own, which is run at most once and tried again by nobody but a new
attempt. RQ's own `Retry` is not used: RQ 2.12 loses count of an execution that was abandoned and retried, and
ends the job as failed (`tests/worker/process/test_rq.py` says when this is over).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, astuple, dataclass, replace
from typing import Any, cast

from redis import Redis
from redis.client import Pipeline
from rq import Queue
from rq.exceptions import InvalidJobOperation, NoSuchJobError
from rq.job import Job
from rq.queue import EnqueueData
from rq.serializers import JSONSerializer

from worker.jobs.keys import FAILURE_TTL, InRedis
from worker.jobs.plan import LANES, SMALL_LIMIT, Lane, queue_name
from worker.settings import WorkerSettings

KEPT_SECONDS = 60
"""Lifetime of an RQ job that is done, in seconds: `rq info` counts the last ones. The answer is not in it."""


@dataclass(frozen=True)
class ChunkRef:
    """One attempt at one chunk of one run of a job, as the RQ job of this id has it."""

    job_id: str
    run: str
    index: int
    attempt: int

    @property
    def rq_id(self) -> str:
        """The id of the RQ job."""
        return f"{self.job_id}-{self.run}-{self.index}-{self.attempt}"


@dataclass(frozen=True)
class ChunkEntry:
    """A chunk that is not done yet, as the record of its job has it.

    Attributes:
        first: the position of its first part in the job.
        last: that of its last one.
        lane: where the attempt waits, or was taken from.
        attempt: the number of the attempt; the earlier ones are out of date.
        is_single: whether each part is stored before the next one is begun: the first one that is not stored
            is then to blame for the end of the process. At first they are stored in groups.
        is_begun: whether what is computed once for all its parts is known. Only of a chunk that `is_single`.
        at: the position of the part at which it lost its work horses.
        losses: how many.
        worker_losses: how often it was lost together with its worker.
    """

    first: int
    last: int
    lane: Lane
    attempt: int = 0
    is_single: bool = False
    is_begun: bool = False
    at: int = -1
    losses: int = 0
    worker_losses: int = 0

    def to_json(self) -> str:
        """Returns the entry as kept."""
        return json.dumps(asdict(self), separators=(",", ":"))

    def following(self, **changes: Any) -> ChunkEntry:
        """Returns the entry for the next attempt."""
        return replace(self, attempt=self.attempt + 1, is_begun=False, **changes)


def entry_from_json(text: bytes) -> ChunkEntry:
    """The inverse of :meth:`ChunkEntry.to_json`."""
    return ChunkEntry(**json.loads(text))


def ref_of(rq_id: str) -> ChunkRef:
    """Returns the attempt that an RQ job carries.

    Raises:
        ValueError: this is no id of one.
    """
    job_id, run, index, attempt = rq_id.rsplit("-", 3)
    return ChunkRef(job_id, run, int(index), int(attempt))


class ChunkQueue(InRedis):
    """The RQ queues that carry chunks, one for each lane."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.queues: Mapping[Lane, Queue] = {
            lane: Queue(queue_name(lane, settings), connection=redis, serializer=JSONSerializer)
            for lane in LANES
        }

    def enqueue(
        self, pipe: Pipeline, job_id: str, run: str, chunks: Mapping[int, ChunkEntry], about: str, **how: bool
    ) -> None:
        """Enqueue attempts in a transaction that also keeps their entries, by the index of the chunk.

        Args:
            pipe: the transaction.
            job_id: the id of the job.
            run: its run.
            chunks: the entries; all in one lane.
            about: the question, for those who look at the RQ jobs.
            how: `at_front`: whether they go before those that wait.
        """
        lane = next(iter(chunks.values())).lane
        attempts = [
            self._prepared(ChunkRef(job_id, run, index, entry.attempt), entry, about, **how)
            for index, entry in chunks.items()
        ]
        self.queues[lane].enqueue_many(attempts, pipeline=pipe)
        entries = {str(index): entry.to_json() for index, entry in chunks.items()}
        pipe.hset(self.keys.job(job_id).chunks, mapping=cast(Any, entries))

    def _prepared(
        self, ref: ChunkRef, entry: ChunkEntry, about: str, *, at_front: bool = False
    ) -> EnqueueData:
        return Queue.prepare_data(
            self.settings.task,
            (*astuple(ref), entry.first, entry.last),
            job_id=ref.rq_id,
            timeout=self.limit(entry.lane),
            result_ttl=KEPT_SECONDS,
            failure_ttl=FAILURE_TTL,
            description=about,
            at_front=at_front,
        )

    def limit(self, lane: Lane) -> int:
        """Returns the seconds that a chunk of a lane may take."""
        return SMALL_LIMIT if lane == "small" else math.ceil(self.settings.deadline_seconds)

    def discard(self, rq_ids: Iterable[str]) -> None:
        """Delete attempts that are out of date, wherever RQ has them; one that runs its worker ends."""
        for rq_id in rq_ids:
            with suppress(InvalidJobOperation):  # it has just gone
                try:
                    job = Job.fetch(rq_id, connection=self.redis, serializer=JSONSerializer)
                except NoSuchJobError:
                    self.redis.delete(Job.key_for(rq_id))  # a worker may have shown it as started since
                    continue
                with self.redis.pipeline() as pipe:
                    job.delete(pipeline=pipe)
                    pipe.execute()

    def waiting(self) -> set[str]:
        """Returns the ids of all RQ jobs in the queues."""
        with self.redis.pipeline(transaction=False) as pipe:
            for queue in self.queues.values():
                pipe.lrange(queue.key, 0, -1)
            return {raw.decode() for ids in pipe.execute() for raw in ids}

    def depths(self) -> dict[Lane, int]:
        """Returns the number of chunks in each lane that wait for a worker."""
        with self.redis.pipeline(transaction=False) as pipe:
            for queue in self.queues.values():
                pipe.llen(queue.key)
            return dict(zip(self.queues, pipe.execute(), strict=True))

    def workers(self, *lanes: Lane) -> list[int]:
        """Returns for each lane how many workers take chunks from it, as RQ's register has them."""
        with self.redis.pipeline(transaction=False) as pipe:
            for lane in lanes:
                pipe.smembers(f"rq:workers:{self.queues[lane].name}")
            members = pipe.execute()
            for keys in members:
                pipe.exists("rq:workers:none", *sorted(keys))
            return cast("list[int]", pipe.execute())
