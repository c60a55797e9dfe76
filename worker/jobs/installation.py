"""An installation as a whole: what waits, who works, how jobs ended, whether a new one would be done."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import cast

from redis import Redis

from worker.answers.kinds import kind_of_job
from worker.answers.layout import ResultKeys
from worker.connection import eviction_warning
from worker.jobs.chunks import ChunkQueue, ref_of
from worker.jobs.keys import Keys, seconds_of
from worker.lua.scripts import DURATION_BOUNDS
from worker.settings import WorkerSettings


@dataclass
class Durations:
    """How many jobs took how long: a count for each interval, and the sum of all seconds."""

    counts: list[int] = field(default_factory=lambda: [0] * (len(DURATION_BOUNDS) + 1))
    seconds: float = 0.0


@dataclass
class Ends:
    """The jobs that ended and the losses so far, by the name of the kind."""

    by_status: Counter[tuple[str, ...]] = field(default_factory=Counter)
    failures: Counter[tuple[str, ...]] = field(default_factory=Counter)
    waits: defaultdict[str, Durations] = field(default_factory=lambda: defaultdict(Durations))
    runs: defaultdict[str, Durations] = field(default_factory=lambda: defaultdict(Durations))
    lost: Counter[str] = field(default_factory=Counter)
    demoted: Counter[tuple[str, ...]] = field(default_factory=Counter)


def read_ends(fields: Mapping[bytes, bytes]) -> Ends:
    """Returns what the fields of the hash say."""
    ends = Ends()
    for raw, value in fields.items():
        what, kind, *rest = raw.decode().split(":")
        if what == "lost":
            ends.lost[kind] += int(value)
            continue
        known = kind_of_job(f"{kind}-")
        kind = kind if known is None else known.name
        if what == "demoted":
            ends.demoted[(kind,)] += int(value)
        elif what == "wait":
            ends.waits[kind].seconds = float(value)
        elif what == "run":
            ends.runs[kind].seconds = float(value)
        elif what == "n":
            status, reason, wait, run = rest
            count = int(value)
            ends.by_status[kind, status] += count
            ends.waits[kind].counts[int(wait)] += count
            if run:
                ends.runs[kind].counts[int(run)] += count
            if reason:
                ends.failures[kind, reason] += count
    return ends


@dataclass(frozen=True)
class WaitingChunks:
    """The chunks that wait in one lane; `age` is the time since the job of the first one was submitted."""

    name: str
    depth: int
    age: float


@dataclass(frozen=True)
class Load:
    """The work that waits, those who do it, and what they have done."""

    lanes: tuple[WaitingChunks, ...] = ()
    active_jobs: int = 0
    suspected_chunks: int = 0
    workers: int = 0
    ends: Ends = field(default_factory=Ends)
    deliveries: Mapping[str, int] = field(default_factory=dict)
    archive: Mapping[str, int] = field(default_factory=dict)
    memory: int = 0
    memory_limit: int = 0


def read_load(redis: Redis, settings: WorkerSettings) -> Load:
    """Returns the load; the ages are in seconds."""
    keys, chunks = Keys.of(settings), ChunkQueue(redis, settings)
    with redis.pipeline(transaction=False) as pipe:
        for queue in chunks.queues.values():
            pipe.llen(queue.key)
            pipe.lindex(queue.key, 0)
        pipe.time()
        pipe.zcard(keys.active)
        pipe.hlen(keys.suspects)
        pipe.hgetall(keys.ends)
        pipe.info("memory")
        pipe.hgetall(keys.delivery_counts)
        pipe.hgetall(ResultKeys.of(settings).archive)
        *waiting, time, active, suspected, ends, memory, attempts, moved = pipe.execute()
        heads = [_job_of(head) for head in waiting[1::2]]
        for job_id in filter(None, heads):
            pipe.hget(keys.job(job_id).record, "created")
        created = iter(pipe.execute())
    now = seconds_of(time)
    ages = [max(0.0, now - float(next(created) or now)) if head else 0.0 for head in heads]
    return Load(
        lanes=tuple(map(WaitingChunks, chunks.queues, waiting[::2], ages)),
        active_jobs=active,
        suspected_chunks=suspected,
        workers=chunks.workers("small")[0],
        ends=read_ends(ends),
        deliveries={state.decode(): int(count) for state, count in attempts.items()},
        archive={what.decode(): int(count) for what, count in moved.items()},
        memory=int(memory["used_memory"]),
        memory_limit=int(memory["maxmemory"]),
    )


def _job_of(rq_id: bytes | None) -> str:
    """Returns the job of a chunk in a queue; empty if there is none, or it is no chunk of ours."""
    try:
        return "" if rq_id is None else ref_of(rq_id.decode()).job_id
    except ValueError:
        return ""


_TRIAL_TTL = 1000  # milliseconds

STILL = 60.0
"""Seconds after which a small job should have started, however much other work there is."""


@dataclass(frozen=True)
class Readiness:
    """The workers that are alive, and what endangers jobs: settings of Redis, lanes that stand still."""

    workers: int
    warnings: tuple[str, ...]


def readiness(redis: Redis, settings: WorkerSettings) -> Readiness:
    """Returns whether jobs would be done, after writing to Redis.

    Raises:
        RedisError: Redis cannot be reached, or accepts no data.
    """
    redis.set(Keys.of(settings).trial, 1, px=_TRIAL_TTL)
    workers, strong = ChunkQueue(redis, settings).workers("small", "heavy")
    warning = eviction_warning(redis)
    stalled = _stalled(redis, settings, strong) if workers else ()
    return Readiness(workers, (*(() if warning is None else (warning,)), *stalled))


def _stalled(redis: Redis, settings: WorkerSettings, strong: int) -> Iterator[str]:
    """Yields a warning for each lane that stands still although workers are alive."""
    queues = ChunkQueue(redis, settings).queues
    with redis.pipeline(transaction=False) as pipe:
        pipe.lindex(queues["small"].key, 0)
        pipe.llen(queues["heavy"].key)
        pipe.llen(queues["batch"].key)
        pipe.time()
        head, heavy, batch, time = pipe.execute()
    if job_id := _job_of(head):
        created = redis.hget(Keys.of(settings).job(job_id).record, "created")
        now = seconds_of(time)
        age = now - float(cast("bytes | None", created) or now)
        if age > STILL:
            yield f"no job in lane small has started for {age:.0f} s"
    for lane, depth in (("heavy", heavy), ("batch", batch)):
        if depth and not strong:
            yield f"no worker takes the {depth} chunks in lane {lane}: all have light duty"
