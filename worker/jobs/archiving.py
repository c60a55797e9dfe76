"""The move of answers to the archive, and the removal of objects there that are no longer needed.

An answer is whole as soon as it is in the store. Once it is old or large, or Redis is rather full, it is
packed with others into an object. Only when that was read back do addresses take the place of the values in
Redis, each only if the value is still the same. So nothing is lost if this ends at any point: at worst the
archive has an object to which no address leads, which is removed later.
"""

from __future__ import annotations

import hashlib
import logging
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple, cast

from redis import Redis
from redis.exceptions import OutOfMemoryError

from worker.answers.archive import Archive, ArchiveAwayError, archive_of
from worker.answers.layout import (
    ADDRESS_BYTES,
    ARCHIVE_TTL,
    AWAY,
    HEAD_BYTES,
    Address,
    ResultKeys,
    address_in,
    measured_by,
    pack,
)
from worker.jobs.inventory import Inventory
from worker.jobs.keys import InRedis
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.archive")

_PAGE = 1000
_SMALLEST = 256  # bytes from which on an address is much shorter
_OBJECT_BYTES, _OBJECT_RESULTS = 4 << 20, 4000
_FEW_BYTES = 1 << 20  # of which no object is made yet
_TOGETHER_BYTES = 32 << 20  # that are sorted before they are packed
_LARGE = 1 << 16  # bytes from which on an answer moves once it is settled: few of them fill the memory
_SETTLED = 60.0  # seconds after which a large answer moves
_SHARE = 0.75  # of the size from which on old results are removed: from here on young ones move, too
_AT_ONCE = 500


class _Candidate(NamedTuple):
    key: bytes
    size: int
    age: float


class _Whole(NamedTuple):
    key: bytes
    value: bytes
    packed: bytes


class Mover(InRedis):
    """Moves answers of one installation; several at once do no harm."""

    def __init__(self, redis: Redis, settings: WorkerSettings, archive: Archive) -> None:
        super().__init__(redis, settings)
        self.archive = archive
        self.inventory = Inventory(redis, settings)
        self._key = ResultKeys.of(settings).archive
        self._cursor = f"{self._key}:cursor"

    def move(self, seconds: float, *, everything: bool = False) -> int:
        """Move what is due for this number of seconds, or until all keys were looked at; returns how many.

        The next call continues where this one stopped. `everything`: whatever its age and size.

        Raises:
            ArchiveAwayError: the archive does not take it.
        """
        end, moved = time.monotonic() + seconds, 0
        waiting: list[_Candidate] = []
        position = 0 if everything else int(cast("bytes | None", self.redis.get(self._cursor)) or 0)
        is_hurried, is_over = everything or self.is_rather_full(), False
        while not is_over:
            position, page = self.scan(position, _PAGE)
            waiting += [x for x in self._candidates(page) if is_hurried or self._is_due(x)]
            is_over = not position or time.monotonic() >= end
            if is_over or _size(waiting) >= _TOGETHER_BYTES:
                moved += self._pack_most(waiting, is_last=is_over and (is_hurried or self._is_late(waiting)))
        with suppress(OutOfMemoryError):
            self.redis.set(self._cursor, position)
        if is_hurried and not moved:
            self.inventory.relieve(is_last_resort=True)
        return moved

    def _pack_most(self, waiting: list[_Candidate], *, is_last: bool) -> int:
        """Move those that fill objects, or all; returns how many.

        In the order of their keys: slices that are read together are then in few objects.
        """
        waiting.sort()
        moved = 0
        while waiting and (is_last or _size(waiting) >= _FEW_BYTES):
            moved += self._pack(_taken(waiting))
        return moved

    def collect(self, older_than: float) -> int:
        """Remove objects older than this number of seconds to which no address leads; returns how many.

        Raises:
            ArchiveAwayError: the archive does not answer.
        """
        removed = 0
        for name in self.archive.names(older_than):
            if not any(name == address.object for address in self._addresses(self.archive.keys(name))):
                self.archive.remove(name)
                removed += 1
        return removed

    def _addresses(self, keys: Sequence[bytes]) -> Iterator[Address]:
        for first in range(0, len(keys), _AT_ONCE):
            with self.redis.pipeline(transaction=False) as pipe:
                for key in keys[first : first + _AT_ONCE]:
                    pipe.getrange(key, 0, ADDRESS_BYTES - 1)
                values = pipe.execute()
            yield from (address_in(value) for value in values if value[:1] == AWAY)

    def is_to_collect(self) -> bool:
        """Whether objects that are no longer needed are to be removed: once a day."""
        with suppress(OutOfMemoryError):
            return bool(self.redis.set(f"{self._key}:collected", 1, nx=True, ex=86400))
        return False

    def is_rather_full(self) -> bool:
        """Whether young answers move, too."""
        used, bound = self.inventory.memory()
        return bool(bound) and used > _SHARE * bound

    def _candidates(self, keys: Sequence[bytes]) -> Iterator[_Candidate]:
        """Yields those that are results: no errors, not short, and not in the archive."""
        results = [key for key in keys if self.inventory.is_result(key)]
        with self.redis.pipeline(transaction=False) as pipe:
            for key in results:
                pipe.getrange(key, 0, HEAD_BYTES - 1)
                pipe.strlen(key)
                pipe.pttl(key)
            replies = iter(pipe.execute())
        for key, head, size, left in zip(results, replies, replies, replies, strict=True):
            is_slice = head[:1] != b"{"
            if size < _SMALLEST or head[:1] == AWAY or (is_slice and measured_by(head).is_error):
                continue
            age = self.inventory.age("slice" if is_slice else "document", left)
            yield _Candidate(key, size, float("inf") if age is None else age)

    def _is_due(self, one: _Candidate) -> bool:
        settings = self.settings
        is_large = one.size >= _LARGE and one.age >= min(_SETTLED, settings.archive_after)
        return is_large or one.age >= settings.archive_after

    def _is_late(self, waiting: Sequence[_Candidate]) -> bool:
        """Whether some have waited long enough for others to share an object with."""
        settings = self.settings
        return any(one.age >= 2 * settings.archive_after or one.size >= _LARGE for one in waiting)

    def _pack(self, chosen: Sequence[_Candidate]) -> int:
        """Move some answers into one object; returns how many."""
        values = cast("list[bytes | None]", self.redis.mget([one.key for one in chosen]))
        known = [(one.key, value) for one, value in zip(chosen, values, strict=True) if value is not None]
        whole = [_Whole(key, value, _packed(value)) for key, value in known]
        kept = [one for one in whole if one.packed[:1] == b"\0"]  # no error, and not moved by another
        if not kept:
            return 0
        addresses = self.archive.put([(one.key, one.packed) for one in kept])
        moved = 0
        for first in range(0, len(kept), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            moved += self._replace(kept[part], addresses[part])
        size = sum(len(one.packed) for one in kept)
        with suppress(OutOfMemoryError), self.redis.pipeline(transaction=False) as pipe:
            for field, count in (("moved", moved), ("bytes", size), ("objects", 1)):
                pipe.hincrby(self._key, field, count)
            pipe.execute()
        return moved

    def _replace(self, moved: Sequence[_Whole], addresses: Sequence[Address]) -> int:
        pairs = zip(moved, addresses, strict=True)
        values = [(hashlib.sha1(one.value).hexdigest(), address.to_bytes()) for one, address in pairs]
        return int(
            self._run(
                "replace",
                results=[one.key for one in moved],
                ttl=ARCHIVE_TTL,
                values=[part for pair in values for part in pair],
            )
        )


def _packed(value: bytes) -> bytes:
    return pack(value) if value[:1] == b"{" else value


def _size(waiting: Sequence[_Candidate]) -> int:
    return sum(one.size for one in waiting)


def _taken(waiting: list[_Candidate]) -> list[_Candidate]:
    """Returns the first of them that fit into one object, and takes them away."""
    size, count = 0, 0
    while count < min(len(waiting), _OBJECT_RESULTS) and size < _OBJECT_BYTES:
        size += waiting[count].size
        count += 1
    taken, waiting[:] = waiting[:count], waiting[count:]
    return taken


def keep_moving(redis: Redis, settings: WorkerSettings, seconds: float) -> bool:
    """Move answers for this number of seconds, and once a day remove objects that are no longer needed; log
    what fails.

    Returns whether there is probably more to move.
    """
    begin = time.monotonic()
    try:
        mover = Mover(redis, settings, archive_of(settings))
        moved = mover.move(seconds)
        if mover.is_to_collect():
            mover.collect(ARCHIVE_TTL + 86400)
    except ArchiveAwayError as error:
        log.warning("answers stay in Redis: %s", error)
        Inventory(redis, settings).relieve(is_last_resort=True)  # as without an archive
        with suppress(OutOfMemoryError):
            redis.hincrby(ResultKeys.of(settings).archive, "refused", 1)
        return False
    return bool(moved) and (mover.is_rather_full() or time.monotonic() - begin >= seconds)
