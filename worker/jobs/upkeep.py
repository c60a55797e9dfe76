"""What keeps an installation in order: interrupted or lost chunks run again until their retry budget is
spent, and the oldest keys are removed.

The age of a key is the time since it was written or its lifetime renewed, by what is left of its lifetime.
A key without a lifetime, such as the record of an active job or an API key, has no age and is never removed.
Nor is a result that is younger than the oldest active job: that job may have found it when it was submitted
(which renews it), or computed it."""

from __future__ import annotations

import logging
import threading
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import cast

from redis import Redis
from redis.exceptions import OutOfMemoryError, RedisError

from worker.answers.kinds import is_batch, kind_of_job
from worker.answers.layout import UNNAMED
from worker.jobs.attempts import Attempts
from worker.jobs.batches import Batches
from worker.jobs.chunks import ChunkEntry, ChunkQueue, ChunkRef, Lost
from worker.jobs.clients import JobView
from worker.jobs.plan import InRedis, Keys
from worker.jobs.records import JobRecords
from worker.logs import about
from worker.settings import WorkerSettings

_WITHIN = frozenset({"slice", "digits", "eliminant"})  # kinds whose names have the version behind the kind
KINDS = ("slice", "digits", "eliminant", "document", "census-digits", "question", "job")
"""The kinds of keys that may be removed; all others are counted as `other`."""

OTHER = "other"

_PAGE = 1000
_MARGIN = 60.0  # seconds before an active job was recorded, in which it may have found its results
_FULL_SHARE, _ENOUGH_SHARE = 0.8, 0.9
_PAUSE, _LONGEST = 1.0, 0.1


@dataclass(frozen=True)
class StoredKey:
    """One key; `age` in seconds, None if it has no lifetime; `size` in bytes."""

    key: bytes
    kind: str
    version: str
    left: int
    age: float | None
    size: int


@dataclass
class Stock:
    """All keys of one kind."""

    keys: int = 0
    size: int = 0
    oldest: float | None = None

    def add(self, item: StoredKey) -> None:
        """Count one key."""
        self.keys += 1
        self.size += item.size
        if item.age is not None:
            self.oldest = max(item.age, self.oldest or 0.0)


@dataclass(frozen=True)
class Pruned:
    """What was removed, and the number of keys that were not, since an active job may need them."""

    keys: int
    size: int
    needed: int


class Inventory(InRedis):
    """The keys of one installation."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self._prefix = settings.key_prefix.encode() + b":"
        self._next = 0.0
        self._cursor = 0

    def stock(self) -> dict[str, Stock]:
        """Returns the keys by kind; it looks at every key."""
        found: defaultdict[str, Stock] = defaultdict(Stock)
        for page in self._pages():
            for item in self._items(page):
                found[item.kind].add(item)
        return {kind: found[kind] for kind in (*KINDS, OTHER) if kind in found}

    def prune(self, older_than: float | None = None, max_bytes: int | None = None) -> Pruned:
        """Remove the keys of a greater age, and the oldest while all keys take more bytes."""
        items = [item for page in self._pages() for item in self._items(page)]
        excess = sum(item.size for item in items) - (max_bytes if max_bytes is not None else float("inf"))
        chosen: list[StoredKey] = []
        for item in sorted(items, key=lambda item: -(item.age or 0.0)):
            if item.age is None or item.kind == OTHER:
                continue
            if (older_than is not None and item.age > older_than) or excess > 0:
                chosen.append(item)
                excess -= item.size
        free = self._not_needed(chosen)
        removed = sum(self._take(free[i : i + _PAGE]) for i in range(0, len(free), _PAGE))
        return Pruned(removed, sum(item.size for item in free), len(chosen) - len(free))

    def relieve(self, *, is_last_resort: bool = False) -> int:
        """Remove old keys while Redis uses more than its bound; for the sweeper.

        Where there is an archive, this is left to the process that moves answers, once it can move no more.
        It takes the older half of each thousand of keys, for a tenth of a second at most.
        Returns the number of removed keys.
        """
        if time.monotonic() < self._next or (self.settings.archive_url and not is_last_resort):
            return 0
        used, bound = self.memory()
        if not bound or used <= bound:
            self._next = time.monotonic() + _PAUSE
            return 0
        end, removed = time.monotonic() + _LONGEST, 0
        while used > _ENOUGH_SHARE * bound and time.monotonic() < end:
            self._cursor, page = self.scan(self._cursor, _PAGE)
            items = [item for item in self._items(page, sizes=False) if item.kind != OTHER]
            aged = sorted((i for i in items if i.age is not None), key=lambda item: -(item.age or 0.0))
            removed += self._take(self._not_needed(aged[: -(-len(aged) // 2)]))
            used, bound = self.memory()
        return removed

    def memory(self) -> tuple[int, float]:
        """Returns what Redis uses, and from where on it is too much; 0: never."""
        memory = self.redis.info("memory")
        bounds = [int(memory["maxmemory"]), (self.settings.store_max_mb or 0) << 20]
        return int(memory["used_memory"]), _FULL_SHARE * min(filter(None, bounds), default=0)

    def _pages(self) -> Iterator[list[bytes]]:
        cursor, started = 0, False
        while cursor or not started:
            started = True
            cursor, page = self.scan(cursor, _PAGE)
            yield page

    def _items(self, keys: Sequence[bytes], *, sizes: bool = True) -> Iterator[StoredKey]:
        with self.redis.pipeline(transaction=False) as pipe:
            for key in keys:
                pipe.pttl(key)
            for key in keys if sizes else ():
                pipe.memory_usage(key)
            replies = pipe.execute()
        measured = replies[len(keys) :] or [0] * len(keys)
        for key, left, size in zip(keys, replies, measured, strict=False):
            if left == -2:  # it is gone meanwhile
                continue
            kind, version = self._kind(key)
            yield StoredKey(key, kind, version, left, self.age(kind, left), size or 0)

    def is_result(self, key: bytes) -> bool:
        """Whether a key is that of a slice or a document."""
        return self._kind(key)[0] in ("slice", "document")

    def age(self, kind: str, left: int) -> float | None:
        """The age of a key of this kind, in seconds, by what is left of its lifetime in milliseconds."""
        return None if left < 0 else max(0.0, self._lifetime(kind, left / 1000) - left / 1000)

    def _kind(self, key: bytes) -> tuple[str, str]:
        """Returns the kind of a key, and the version of the solver to which it belongs."""
        name, _, rest = key.removeprefix(self._prefix).decode(errors="replace").partition(":")
        if name in _WITHIN:
            return name, rest.partition(":")[0]
        if name in KINDS:
            return name, UNNAMED
        kind, _, version = name.rpartition("-")
        return (kind, version) if kind in KINDS and kind not in _WITHIN else (OTHER, UNNAMED)

    def _lifetime(self, kind: str, left: float) -> float:
        """The lifetime of a kind; where there are several, the shortest that can have this much left.

        So no key seems older than it is, and one that an active job has made is not taken for an old one.
        """
        settings = self.settings
        if kind in ("job", "question"):
            return settings.job_ttl
        if kind == "eliminant":
            return settings.eliminant_ttl
        lifetimes = settings.lifetimes
        return next((ttl for ttl in lifetimes if ttl >= left), lifetimes[-1])

    def _not_needed(self, items: Iterable[StoredKey]) -> list[StoredKey]:
        """Returns those that no active job of their version can need."""
        items = list(items)
        versions = sorted({item.version for item in items})
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.time()
            for version in versions:
                pipe.zrange(Keys(self.settings.key_prefix, version).active, 0, 0, withscores=True)
            (seconds, _), *oldest = pipe.execute()
        ages = {
            version: seconds - first[0][1] + _MARGIN if first else 0.0
            for version, first in zip(versions, oldest, strict=True)
        }
        return [item for item in items if item.kind == "job" or (item.age or 0.0) >= ages[item.version]]

    def _take(self, items: Sequence[StoredKey]) -> int:
        if not items:
            return 0
        chosen, lifetimes = [item.key for item in items], [item.left for item in items]
        return int(self._run("remove_keys", chosen=chosen, lifetimes=lifetimes))


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


class Sweeper(InRedis):
    """Finds chunks that no worker runs any more, and enqueues them again.

    A chunk that is not done must be in a queue or have a heartbeat. A chunk with neither (its worker was
    killed, or a process died between two steps) is suspected and, if it stays so, put back in the queue. A
    job that lost one of its keys in Redis is repaired, or fails. A job whose deadline is over fails, queued
    or running. Any number of sweepers may run, but only one at a time searches.
    """

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        super().__init__(redis, settings)
        self.records = JobRecords(redis, settings)
        self.chunks = ChunkQueue(redis, settings)
        self.inventory = Inventory(redis, settings)
        self.interruptions = Interruptions(redis, settings)

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
        now = self.now()
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
