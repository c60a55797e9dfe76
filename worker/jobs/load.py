"""What an installation is doing now, in two round trips to Redis however much it is."""

from __future__ import annotations

from dataclasses import dataclass

from redis import Redis

from worker.jobs.chunks import ChunkQueue
from worker.jobs.ends import Ends, read_ends
from worker.jobs.keys import Keys
from worker.jobs.roster import Roster
from worker.settings import WorkerSettings


@dataclass(frozen=True)
class Lane:
    """The chunks that wait in one queue; `age` is the time since the job of the first one was submitted."""

    name: str
    depth: int
    age: float


@dataclass(frozen=True)
class Load:
    """The work that waits, those who do it, and what they have done."""

    lanes: tuple[Lane, ...]
    active_jobs: int
    suspected_chunks: int
    workers: int
    oldest_beat: float
    ends: Ends
    deliveries: dict[str, int]
    memory: int
    memory_limit: int


def read_load(redis: Redis, settings: WorkerSettings) -> Load:
    """Returns the load; the ages are in seconds."""
    keys, roster = Keys.of(settings), Roster(redis, settings)
    lanes = {lane: queue.key for lane, queue in ChunkQueue(redis, settings).queues.items()}
    with redis.pipeline(transaction=False) as pipe:
        for key in lanes.values():
            pipe.llen(key)
            pipe.lindex(key, 0)
        pipe.time()
        pipe.zcard(keys.active)
        pipe.hlen(keys.suspects)
        pipe.zrange(roster.key, 0, -1, withscores=True)
        pipe.hgetall(keys.ends)
        pipe.info("memory")
        pipe.hgetall(keys.delivery_counts)
        *waiting, (seconds, micros), active, suspected, beats, ends, memory, attempts = pipe.execute()
        now = seconds + micros / 1e6
        heads = [head and head.decode().rsplit("-", 3)[0] for head in waiting[1::2]]
        for job_id in filter(None, heads):
            pipe.hget(keys.job(job_id).record, "created")
        created = iter(pipe.execute())
    ages = [max(0.0, now - float(next(created) or now)) if head else 0.0 for head in heads]
    live = [roster.age(score, now) for _, score in beats if score > 1000 * now]
    return Load(
        lanes=tuple(map(Lane, lanes, waiting[::2], ages)),
        active_jobs=active,
        suspected_chunks=suspected,
        workers=len(live),
        oldest_beat=max(live, default=0.0),
        ends=read_ends(ends),
        deliveries={state.decode(): int(count) for state, count in attempts.items()},
        memory=int(memory["used_memory"]),
        memory_limit=int(memory["maxmemory"]),
    )
