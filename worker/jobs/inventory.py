"""The keys of an installation by kind, and what of them may go when the store is full."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from redis import Redis

from worker.answers.layout import eliminant_ttl, lifetimes
from worker.jobs.keys import InRedis, Keys
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
        kind, _, version = name.rpartition("-")
        return (kind, version) if kind in KINDS and kind not in _WITHIN else (OTHER, "")

    def _lifetime(self, kind: str, left: float) -> float:
        """The lifetime of a kind; where there are several, the shortest that can have this much left.

        So no key seems older than it is, and one that an active job has made is not taken for an old one.
        """
        settings = self.settings
        if kind in ("job", "question"):
            return settings.result_ttl_seconds
        if kind == "eliminant":
            return eliminant_ttl(settings)
        found = lifetimes(settings)
        return next((ttl for ttl in found if ttl >= left), found[-1])

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
