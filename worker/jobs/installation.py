"""An installation as a whole: its workers, what waits, how jobs ended, whether a new one would be done."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from redis import Redis

from worker.answers.kinds import kind_of_job
from worker.answers.layout import UNNAMED, ResultKeys
from worker.connection import eviction_warning
from worker.jobs.chunks import ChunkQueue
from worker.jobs.plan import InRedis, Keys, Lane
from worker.lua.scripts import DURATION_BOUNDS
from worker.settings import WorkerSettings

_IDLE_WAIT = 1.0  # seconds that an idle worker lets pass between two beats, at most


class Roster(InRedis):
    """The workers of this version of the solver."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.key = self.keys.workers
        self._ttl = int((settings.beat_ttl + _IDLE_WAIT) * 1000)

    def beat(self, name: str, *, is_light: bool = False) -> None:
        """Say that the worker `name` is alive, and whether it takes short chunks only."""
        self._run("worker_beat", workers=self.key, name=name, ttl=self._ttl, is_light=is_light)

    def age(self, score: float, now: float) -> float:
        """The seconds since the last beat of a worker with this score."""
        return max(0.0, now - (score - self._ttl) / 1000)

    def leave(self, name: str) -> None:
        """Say that the worker `name` ends."""
        for key in (self.key, f"{self.key}:light"):
            self.redis.zrem(key, name)

    def names(self) -> set[str]:
        """The workers that are alive."""
        return self._alive(self.key)

    def light(self) -> set[str]:
        """Those of them that take short chunks only."""
        return self._alive(f"{self.key}:light")

    def _alive(self, key: str) -> set[str]:
        names = self.redis.zrangebyscore(key, f"({int(1000 * self.now())}", "+inf")
        return {name.decode() for name in cast("list[bytes]", names)}

    def silences(self) -> dict[str, float]:
        """The seconds since each worker's last beat. Raises an error if beats are not possible."""
        probe = f"{self.key}:probe"
        entries: list[Any] = self._run("silences", workers=self.key, probe=probe, ttl=self._ttl)
        return {
            name.decode(): max(0, age) / 1000 for name, age in zip(entries[::2], entries[1::2], strict=True)
        }


class Versions(InRedis):
    """The versions beside this one, and whose job is whose."""

    def others(self) -> list[str]:
        """Returns the others that had jobs here; the first ones did not note it."""
        noted = {raw.decode() for raw in cast("set[bytes]", self.redis.smembers(self.keys.versions))}
        return sorted({*noted, UNNAMED} - {self.settings.solver_version})

    def other_of(self, job_id: str) -> str | None:
        """Returns the other version that has a job, or a question with this id; None if none has."""
        prefix = self.settings.key_prefix
        for version in self.others():
            job, question = Keys(prefix, version).job(job_id), ResultKeys(prefix, version).question(job_id)
            if self.redis.exists(job.record, question):
                return version
        return None


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
    overruns: Counter[tuple[str, ...]] = field(default_factory=Counter)


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
        if what == "overruns":
            ends.overruns[kind, rest[0]] += int(value)
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

    lanes: tuple[WaitingChunks, ...]
    active_jobs: int
    suspected_chunks: int
    workers: int
    oldest_beat: float
    ends: Ends
    deliveries: dict[str, int]
    archive: dict[str, int]
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
        pipe.hgetall(ResultKeys.of(settings).archive)
        *waiting, (seconds, micros), active, suspected, beats, ends, memory, attempts, moved = pipe.execute()
        now = seconds + micros / 1e6
        heads = [head and head.decode().rsplit("-", 3)[0] for head in waiting[1::2]]
        for job_id in filter(None, heads):
            pipe.hget(keys.job(job_id).record, "created")
        created = iter(pipe.execute())
    ages = [max(0.0, now - float(next(created) or now)) if head else 0.0 for head in heads]
    live = [roster.age(score, now) for _, score in beats if score > 1000 * now]
    return Load(
        lanes=tuple(map(WaitingChunks, lanes, waiting[::2], ages)),
        active_jobs=active,
        suspected_chunks=suspected,
        workers=len(live),
        oldest_beat=max(live, default=0.0),
        ends=read_ends(ends),
        deliveries={state.decode(): int(count) for state, count in attempts.items()},
        archive={what.decode(): int(count) for what, count in moved.items()},
        memory=int(memory["used_memory"]),
        memory_limit=int(memory["maxmemory"]),
    )


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
    workers = len(Roster(redis, settings).names())
    warning = eviction_warning(redis)
    stalled = _stalled(redis, settings) if workers else ()
    return Readiness(workers, (*(() if warning is None else (warning,)), *stalled))


def _stalled(redis: Redis, settings: WorkerSettings) -> Iterator[str]:
    """Yields a warning for each lane that stands still although workers are alive."""
    roster, queues = Roster(redis, settings), ChunkQueue(redis, settings).queues
    heavy: tuple[Lane, ...] = ("heavy", "heavy-batch")
    with redis.pipeline(transaction=False) as pipe:
        pipe.lindex(queues["small"].key, 0)
        for lane in heavy:
            pipe.llen(queues[lane].key)
        pipe.time()
        head, *depths, (seconds, _) = pipe.execute()
    if head is not None:
        job = Keys.of(settings).job(head.decode().rsplit("-", 3)[0])
        created = redis.hget(job.record, "created")
        age = seconds - float(cast("bytes | None", created) or seconds)
        if age > STILL:
            yield f"the lane small stands still: its first job was submitted {age:.0f} s ago"
    if any(depths) and not roster.names() - roster.light():
        for lane, depth in zip(heavy, depths, strict=True):
            if depth:
                yield f"the lane {lane} stands still: all workers have light duty, and {depth} chunks wait"
