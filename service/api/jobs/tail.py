"""The end of a job's event stream: one reader for all clients of the job in this process."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

from redis.asyncio import Redis
from redis.exceptions import RedisError

BLOCK = 2.0
"""Seconds for which one command waits; a server that hangs is noticed soon after."""

_COUNT = 200

EventId = tuple[int, int]

EVENT_ID = r"\d{1,18}(-\d{1,18})?"
"""The pattern of an event's id; its numbers are less than 2^64, as Redis demands."""


def event_id(text: str) -> EventId:
    """Returns an event's id as numbers, which compare in the order of the events."""
    first, _, second = text.partition("-")
    return int(first), int(second or 0)


class Tail:
    """Knows the newest event of a job, and wakes those who wait for it.

    Attributes:
        newest: the id of the newest event.
        is_over: no more events follow, because the job or the reader ended.
        has_ended: the job ended.
    """

    def __init__(self) -> None:
        self.newest: EventId = (0, 0)
        self.is_over = self.has_ended = False
        self._news = asyncio.Event()

    async def wait_beyond(self, last: EventId, seconds: float) -> bool:
        """Wait until there are events after `last`, the stream is over, or the time is."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while self.newest <= last and not self.is_over:
                    await self._news.wait()
        return self.newest > last

    async def end(self, seconds: float) -> None:
        """Wait until the stream is over, or the time is."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while not self.is_over:
                    await self._news.wait()

    def advance(self, newest: EventId, is_over: bool, *, has_ended: bool = False) -> None:
        """Wake those who wait."""
        self.newest, self.is_over = max(newest, self.newest), is_over
        self.has_ended = self.has_ended or has_ended
        self._news.set()
        self._news = asyncio.Event()


class _Reader:
    """A reader, and the number of its clients."""

    def __init__(self, tail: Tail) -> None:
        self.tail = tail
        self.clients = 0
        self.ready: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.task: asyncio.Task[None] | None = None


class Tails:
    """The readers of all jobs that have clients, at most `limit`."""

    def __init__(self, redis: Redis, limit: int, on_error: Callable[[Exception], None]) -> None:
        self._redis = redis
        self._limit = limit
        self._on_error = on_error
        self._readers: dict[str, _Reader] = {}

    @property
    def is_full(self) -> bool:
        """Whether no other job can be followed."""
        return len(self._readers) >= self._limit

    @asynccontextmanager
    async def of(self, key: str, since: str = "") -> AsyncIterator[Tail]:
        """The end of a stream, from now on, or from the event `since`.

        Raises:
            RedisError: Redis cannot be reached.
        """
        reader = self._readers.get(key)
        if reader is None:
            reader = self._readers[key] = _Reader(Tail())
            reader.task = asyncio.create_task(self._run(key, reader, since))
        reader.clients += 1
        try:
            await asyncio.shield(reader.ready)
            yield reader.tail
        finally:
            reader.clients -= 1
            if not reader.clients:
                self._forget(key, reader)
                assert reader.task is not None
                reader.task.cancel()

    def stop(self) -> None:
        """End all readers."""
        for key, reader in list(self._readers.items()):
            self._forget(key, reader)
            reader.tail.advance((0, 0), is_over=True)

    async def _run(self, key: str, reader: _Reader, since: str) -> None:
        try:
            if not since:
                newest: Any = await self._redis.xrevrange(key, count=1)
                since = newest[0][0] if newest else "0"
            reader.tail.newest = event_id(since)
            reader.ready.set_result(None)
            while reader.clients and not reader.tail.is_over:  # redis-py may swallow a cancellation
                await self._step(key, reader.tail)
        except RedisError as error:
            self._on_error(error)
            if not reader.ready.done():
                reader.ready.set_exception(error)
        finally:
            self._forget(key, reader)
            reader.tail.advance((0, 0), is_over=True)
            if not reader.ready.done():
                reader.ready.cancel()

    async def _step(self, key: str, tail: Tail) -> None:
        last = f"{tail.newest[0]}-{tail.newest[1]}"
        reply: Any = await self._redis.xread({key: last}, count=_COUNT, block=int(1000 * BLOCK))
        if reply:
            entries = reply[0][1]
            has_ended = any(is_terminal(fields) for _, fields in entries)
            tail.advance(event_id(entries[-1][0]), is_over=has_ended, has_ended=has_ended)

    def _forget(self, key: str, reader: _Reader) -> None:
        if self._readers.get(key) is reader:
            del self._readers[key]


def is_terminal(fields: dict[str, str]) -> bool:
    """Whether an event is the last one of its job."""
    return fields["type"] == "status" and fields["status"] not in ("queued", "running")
