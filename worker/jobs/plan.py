"""The names of the Redis keys of jobs; the lanes of the queue, and the cutting of a job into chunks, both by
estimated cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, cast, get_args

from redis import Redis

from rpr_solver import SOLVER_VERSION
from rpr_solver.errors import InputError
from worker.answers.cost import Cost
from worker.answers.layout import kind_of
from worker.lua import Scripts
from worker.settings import Duty, WorkerSettings


class JobKeys(NamedTuple):
    """The keys of one job."""

    record: str
    chunks: str
    bits: str
    errors: str
    events: str
    items: str
    """The items of a batch; the scripts derive this and the next ones from the name of the record."""
    questions: str
    """The long questions of an active batch."""
    todo: str
    """What the chunks are to do."""


class Keys:
    """Key names with one prefix.

    All that is of jobs carries the solver's version, as job ids do: nothing of one version touches a job of
    another. They share the counts of ends, the deliveries (also those of a version that no API is left of),
    what has the id of a chunk in it, API keys and Idempotency-Keys.

    Attributes:
        ends: the counts of how jobs ended; see `worker.jobs.installation.Ends`.
        deliveries: the sorted set of deliveries that are not over, by the time at which they are due.
        delivery_counts: the number of attempts by their outcome.
        versions: the set of the versions of the solver that have had jobs here.
        trial: written to find out whether Redis accepts data.
        active: the sorted set of queued and running jobs; the scripts derive the next three names from it.
        queued: the sorted set of queued jobs, by lane and age.
        work: the estimated work that each lane was given, and has done.
        deadlines: the sorted set of the active jobs with a deadline.
        suspects: the chunks that no worker seems to run, with the time of the first suspicion.
        walk: the position of the search for active jobs among all keys.
        sweep_lock: limits the search for lost chunks to one at a time in the whole installation.
        workers: the sorted set of live workers.
    """

    def __init__(self, prefix: str, version: str = SOLVER_VERSION) -> None:
        self.prefix, self.version = prefix, version
        self.ends = f"{prefix}:ends"
        self.deliveries = f"{prefix}:deliveries"
        self.delivery_counts = f"{prefix}:delivery-counts"
        self.versions = f"{prefix}:versions"
        self.trial = f"{prefix}:trial"
        self.active = f"{prefix}:active:{version}"
        self.queued = f"{self.active}:queued"
        self.work = f"{self.active}:work"
        self.deadlines = f"{self.active}:deadlines"
        self.suspects = f"{prefix}:suspects:{version}"
        self.walk = f"{prefix}:walk:{version}"
        self.sweep_lock = f"{prefix}:sweep-lock:{version}"
        self.workers = f"{prefix}:workers:{version}"

    @classmethod
    def of(cls, settings: WorkerSettings) -> Keys:
        """Returns those of an installation and the version of the solver that is meant."""
        return cls(settings.key_prefix, settings.solver_version)

    def delivery(self, delivery_id: str) -> str:
        """Returns the key of a delivery; the scripts derive it in the same way."""
        return f"{self.deliveries}:{delivery_id}"

    def deliveries_of(self, job_id: str) -> str:
        """Returns the key of the list of a job's deliveries; the scripts derive it in the same way."""
        return f"{self.deliveries}-of:{job_id}"

    def beat(self, chunk_id: str) -> str:
        """Returns the key of a running chunk's heartbeat."""
        return f"{self.prefix}:beat:{chunk_id}"

    def job(self, job_id: str) -> JobKeys:
        """Returns the keys of the job `job_id`."""
        base = f"{self.prefix}:{kind_of('job', self.version)}:{job_id}"
        return JobKeys(base, *(f"{base}:{name}" for name in JobKeys._fields[1:]))

    def names(self, job_id: str) -> dict[str, str]:
        """Returns the keys that the scripts of a job may take, by their names there."""
        job = dict(zip(JobKeys._fields[:5], self.job(job_id), strict=False))  # the others are derived
        return job | {"active": self.active, "ends": self.ends, "workers": self.workers}

    def client(self, client: str) -> str:
        """Returns the key of what a client holds."""
        return f"{self.prefix}:{kind_of('client', self.version)}:{client}"

    def kept(self, client: str) -> str:
        """Returns the key of the ledger of a client's bytes."""
        return f"{self.prefix}:{kind_of('kept', self.version)}:{client}"


class InRedis:
    """A part of an installation, by what it has in Redis; cheap, and may be shared by threads."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self.keys = Keys.of(settings)
        self._run = Scripts(redis)

    def now(self) -> float:
        """The time by the clock of Redis, in seconds since 1970."""
        seconds, micros = self.redis.time()
        return float(seconds + micros / 1e6)

    def scan(self, cursor: int, count: int) -> tuple[int, list[bytes]]:
        """Returns about `count` of all keys, and where to go on; 0 is the beginning and the end."""
        found = self.redis.scan(cursor, match=f"{self.settings.key_prefix}:*", count=count)
        return cast("tuple[int, list[bytes]]", found)


Lane = Literal["small", "bulk", "heavy", "shared", "batch", "heavy-batch"]
"""`small`: jobs of one short chunk; `bulk`: jobs of several short chunks; `heavy`: jobs with long chunks;
`shared`: jobs with long chunks that all compute the same, together;
`batch` and `heavy-batch`: batches with short and with long chunks, however many they are."""


LANES: tuple[Lane, ...] = get_args(Lane)


def check_lifetimes(settings: WorkerSettings) -> None:
    """Check that each lifetime is that of a kind or a lane that there is.

    Raises:
        InputError: one is not.
    """
    from worker.answers.kinds import KINDS  # a start is to be quick

    known = sorted({*(kind.name for kind in KINDS), *LANES})
    if bad := [name for name, _ in settings.result_ttls if name not in known]:
        message = f"{', '.join(map(repr, bad))}: no such kind or lane; known are {', '.join(known)}"
        raise InputError.of("RPR_CUSPS_RESULT_TTLS", message)


_MAX_CHUNKS = 1000  # of a batch, unless its items take so long that a chunk would come near the deadline


_WORTH = 0.05  # seconds of work for which one more worker begins a chunk


_SAFE_SHARE = 0.25  # of the deadline, for all items of a chunk


@dataclass(frozen=True)
class Plan:
    """How a job is computed.

    Attributes:
        lane: the lane of its chunks.
        chunk_size: the number of parts in a chunk; the last one may have fewer.
        chunk_count: the number of chunks.
        seconds: the estimated work, in seconds of one core.
        each: that of a chunk, as its lane was chosen by.
    """

    lane: Lane
    chunk_size: int
    chunk_count: int
    seconds: float
    each: float = 0.0


@dataclass(frozen=True)
class QueuePosition:
    """The number of jobs before a queued job in its lane, and the estimated seconds that they take."""

    position: int
    seconds: float


class QueueFullError(Exception):
    """The lane of a new job holds too much work.

    Attributes:
        lane: the lane.
        seconds: the estimated time that its workers need for that work.
    """

    def __init__(self, lane: Lane, seconds: float) -> None:
        self.lane, self.seconds = lane, seconds
        super().__init__(f"the lane {lane} of the queue is full")


def plan(cost: Cost, parts: int, settings: WorkerSettings, *, is_shared: bool = False) -> Plan:
    """Returns the plan of a job with this number of parts, which share one computation if it `is_shared`.

    A chunk is about `chunk_seconds` of work, without what is computed once for all chunks. A chunk that may
    take much longer, since a single part or what is computed once does, is heavy.
    """
    if not parts:
        return Plan("small", 1, 0, 0.0)
    most = max(1, min(settings.chunk_size, int(settings.chunk_seconds / max(cost.each, 1e-9))))
    count = -(-parts // most)
    size = -(-parts // count)
    if cost.of(size) > settings.heavy_seconds:
        lane: Lane = "shared" if is_shared else "heavy"
    else:
        lane = "small" if count == 1 else "bulk"
    return Plan(lane, size, -(-parts // size), cost.of(parts), cost.of(size))


def plan_batch(costs: Sequence[float], settings: WorkerSettings, workers: int = 1) -> Plan:
    """Returns the plan of a batch, or a part of it, from the estimated seconds of each item.

    A chunk is at most about `chunk_seconds` of work, and stays far below the deadline if all its items are as
    long as the longest one. All are about as large, and each of the workers gets one if that is worth while.
    """
    if not costs:
        return Plan("batch", 1, 0, 0.0)
    total, longest = sum(costs), max(costs)
    mean = total / len(costs)
    size = max(1, min(settings.chunk_size, int(settings.chunk_seconds / max(mean, 1e-9))))
    size = max(size, -(-len(costs) // _MAX_CHUNKS))
    size = max(1, min(size, int(_SAFE_SHARE * settings.deadline / max(longest, 1e-9))))
    count = max(-(-len(costs) // size), min(workers, int(total / _WORTH), len(costs)))
    size = -(-len(costs) // count)
    is_heavy = max(longest, mean * size) > settings.heavy_seconds
    lane: Lane = "heavy-batch" if is_heavy else "batch"
    each = max(longest, mean * min(size, len(costs)))
    return Plan(lane, size, -(-len(costs) // size), total, each)


def heavy_twin(lane: Lane) -> Lane:
    """Returns the lane of chunks that were given back from this one; the scripts find it in the same way."""
    return "heavy-batch" if lane in ("batch", "heavy-batch") else "heavy"


def queue_name(lane: Lane, settings: WorkerSettings) -> str:
    """Returns the name of a lane's RQ queue.

    Each version of the solver has its own, so a worker never takes a chunk of another version.
    """
    return f"{settings.queue_name}-{settings.solver_version}{'' if lane == 'small' else f'-{lane}'}"


def lanes_of(duty: Duty) -> tuple[tuple[Lane, ...], ...]:
    """Returns the orders in which a worker looks into the lanes, one after the other.

    Small jobs always come first. The others take turns, so that none waits for ever: any two lanes that hold
    work have equal shares, so a batch of hours delays other jobs only by its chunk in hand. With light duty,
    a share of a computation is taken when there is nothing else; short chunks then run beside it.
    """
    if duty == "light":
        return (("small", "bulk", "batch", "shared"), ("small", "batch", "bulk", "shared"))
    turns: tuple[tuple[Lane, ...], ...] = (
        ("heavy", "bulk", "batch", "heavy-batch", "shared"),
        ("bulk", "shared", "heavy", "heavy-batch", "batch"),
        ("heavy-batch", "shared", "batch", "heavy", "bulk"),
    )
    return tuple(("small", *turn) for one in turns for turn in (one, one[::-1]))
