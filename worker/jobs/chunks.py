"""Chunks of jobs: what is computed in one attempt, what is recorded of it, and the RQ jobs that carry it."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Literal, cast

from redis import Redis
from redis.client import Pipeline
from redis.exceptions import RedisError
from rq import Queue
from rq.command import send_command
from rq.exceptions import DequeueTimeout, DuplicateJobError, NoSuchJobError
from rq.job import Job
from rq.serializers import JSONSerializer

from worker.answers import JobRequest
from worker.answers.kinds import request_from_json
from worker.jobs.plan import LANES, InRedis, Lane, queue_name
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

Lost = Literal["", "horses", "workers"]
"""What a chunk has lost: its work horse while its worker lived, its worker too, or nothing."""

STOP_PATIENCE = 1.0
"""Seconds for which a stop command is repeated; after that, the worker itself notices from the record."""

_LEFTOVER_TTL = 600


@dataclass(frozen=True)
class ChunkRef:
    """One attempt at one chunk of one run of a job."""

    job_id: str
    run: str
    index: int
    attempt: int

    @property
    def rq_id(self) -> str:
        """The id of the RQ job that carries this attempt."""
        return f"{self.job_id}-{self.run}-{self.index}-{self.attempt}"


@dataclass(frozen=True)
class Estimate:
    """What a chunk was estimated to take, in seconds of one core, and the HTTP request that made its job."""

    seconds: float
    request_id: str = ""


@dataclass(frozen=True)
class ChunkEntry:
    """A chunk that is not done yet, as in the record of its job.

    `moved` is its work in milliseconds if it was given back to the heavy lane, else 0.
    """

    ref: ChunkRef
    state: str
    horses_lost: int = 0
    workers_lost: int = 0
    offset: int = 0
    moved: int = 0


@dataclass(frozen=True)
class Chunk:
    """Some parts of a request, the position of the first one in the job, and how many of them are done.

    Attributes:
        request: the question; of a table only for these slices.
        has_losses: whether a work horse, or its worker, was lost since the last part was done.
        origin: the id of the HTTP request that made the job, if one did, and its trace.
    """

    request: JobRequest
    parts: tuple[str, ...]
    first_position: int
    offset: int = 0
    has_losses: bool = False
    origin: Mapping[str, str] = field(default_factory=dict)


def entry_of(job_id: str, run: bytes, index: bytes, entry: bytes) -> ChunkEntry:
    """Reads the entry of a chunk in the record of its job."""
    state, attempt, *counts = entry.decode().split(":")
    return ChunkEntry(ChunkRef(job_id, run.decode(), int(index), int(attempt)), state, *map(int, counts))


def chunk_of(
    entry: ChunkEntry, todo: bytes | None, request: bytes, size: bytes, origin: bytes | None = None
) -> Chunk:
    """Reads a chunk from its entry, its parts (which Redis may have lost) and fields of its job's record."""
    first = entry.ref.index * int(size)
    parts = tuple(json.loads(todo or "[]"))
    has_losses = entry.horses_lost + entry.workers_lost > 0
    question = request_from_json(request)
    if question.kind.by_slices:
        question = question.of_slices(parts)
    return Chunk(question, parts, first, entry.offset, has_losses, json.loads(origin or "{}"))


class ChunkQueue(InRedis):
    """The RQ queues that carry chunks, one for each lane."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.queues: Mapping[Lane, Queue] = {
            lane: Queue(queue_name(lane, settings), connection=redis, serializer=JSONSerializer)
            for lane in LANES
        }

    def enqueue(self, refs: Iterable[ChunkRef], lane: Lane) -> None:
        """Enqueue the chunks of a new job; if only a part of them is, the sweeper finds the others."""
        with self.redis.pipeline(transaction=False) as pipe:
            for ref in refs:
                self._enqueue(ref, lane, pipe)
            pipe.explicit_transaction = False  # RQ has asked for one
            pipe.execute()

    def put_back(self, ref: ChunkRef, lane: Lane, *, is_first: bool = True) -> None:
        """Enqueue the next attempt at a chunk before others, or behind them, unless it is in the queue."""
        with self.redis.pipeline(transaction=False) as pipe, suppress(DuplicateJobError):
            self._enqueue(ref, lane, pipe, is_again=True, is_first=is_first)
            pipe.execute()

    def _enqueue(
        self, ref: ChunkRef, lane: Lane, pipe: Pipeline, *, is_again: bool = False, is_first: bool = False
    ) -> None:
        self.queues[lane].enqueue_call(
            self.settings.task,
            kwargs=asdict(ref),
            job_id=ref.rq_id,
            unique=is_again,  # at once; the pipeline then notes the queue's name only
            timeout=-1,  # RQ's own timeout cannot end a C call
            result_ttl=0,
            failure_ttl=600,
            description=ref.rq_id,
            at_front=is_first,
            pipeline=pipe,
        )

    def pop(self, lanes: Sequence[Lane], seconds: int | None = None) -> str | None:
        """Take the first RQ job that waits in one of the lanes; returns its id, or None.

        `seconds`: how long to wait for one; None not at all.
        """
        keys = [self.queues[lane].key for lane in lanes]
        with suppress(DequeueTimeout):
            taken = Queue.lpop(keys, seconds, connection=self.redis)
            return None if taken is None else cast(bytes, taken[1]).decode()
        return None

    def read(self, rq_id: str) -> tuple[ChunkRef, str] | None:
        """Returns the chunk of an RQ job, and the name of the function that runs it.

        None if the job is gone, or does not carry a chunk.
        """
        try:
            job = Job.fetch(rq_id, connection=self.redis, serializer=JSONSerializer)
            ref = ChunkRef(**job.kwargs)
            if ref.rq_id == rq_id:
                return ref, str(job.func_name)
        except NoSuchJobError:
            return None
        except RedisError:
            raise
        except Exception as error:
            log.debug("the RQ job %r cannot be read: %s", rq_id, error)
        log.warning("skipped the RQ job %r, which is not a chunk", rq_id)
        return None

    def waiting(self) -> set[str]:
        """Returns the RQ ids of all chunks in the queues."""
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

    def withdraw(self, entries: Iterable[ChunkEntry]) -> None:
        """Remove chunks from the queue, and stop the workers of those that are running."""
        running = [entry.ref for entry in entries if entry.state != "queued" or not self._take_out(entry.ref)]
        deadline = time.monotonic() + STOP_PATIENCE
        while running:
            running = [ref for ref in running if not self._stop(ref)]
            if time.monotonic() > deadline:
                return
            if running:
                time.sleep(0.02)

    def discard(self, ref: ChunkRef) -> None:
        """Delete the RQ job of a chunk that no worker runs."""
        if not self._take_out(ref):
            self.delete(ref)

    def _take_out(self, ref: ChunkRef) -> bool:
        """Remove a chunk from the queue; returns False if it is not in the queue."""
        with self.redis.pipeline(transaction=False) as pipe:
            for queue in self.queues.values():
                pipe.lrem(queue.key, 1, ref.rq_id)
            pipe.hdel(self.keys.suspects, ref.rq_id)
            *removed, _ = pipe.execute()
        if any(removed):
            self.delete(ref)
        else:
            # A worker has just taken it. RQ needs the job until that worker finds nothing to do and deletes
            # it; should the worker die first, the job expires.
            self.redis.expire(Job.key_for(ref.rq_id), _LEFTOVER_TTL)
        return any(removed)

    def delete(self, ref: ChunkRef) -> None:
        """Delete the RQ job of a chunk that is in no queue; RQ has no other record of it."""
        self.redis.delete(Job.key_for(ref.rq_id))

    def _stop(self, ref: ChunkRef) -> bool:
        """Ask the worker to stop; returns True once no worker runs the chunk."""
        worker = cast("bytes | None", self.redis.get(self.keys.beat(ref.rq_id)))
        if worker is None:
            return True
        send_command(self.redis, worker.decode(), "stop-job", job_id=ref.rq_id)
        return False
