"""The events of a job: waiting for its end, and following it as server-sent events."""

from __future__ import annotations

import asyncio
import time
from collections import OrderedDict
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, aclosing, asynccontextmanager, suppress
from typing import Any, NamedTuple, cast

from redis.asyncio import Redis
from redis.asyncio.retry import Retry
from redis.backoff import ExponentialBackoff
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import RedisError

from service.api.job_views import earlier_state, state_json
from service.api.settings import STREAM_CONNECTIONS, Settings
from service.api.threads import RedisAccess, Refusals
from service.schemas.answers import json_bytes
from worker.answers.layout import dump
from worker.connection import password
from worker.jobs.queue import JobQueue
from worker.jobs.view import JobView, Status, shown_state

_AT_ONCE = 8  # events, which are at most some 300 kB
_KEPT = 8 << 20  # bytes of events that are kept for other followers
_MARGIN = 2.0


_BLOCK = 2.0  # seconds for which one command waits; a server that hangs is noticed soon after
_COUNT = 4  # events that are read; if there are more, the newest one suffices

EventId = tuple[int, int]

EVENT_ID = r"\d{1,18}(-\d{1,18})?"
"""The pattern of an event's id; its numbers are less than 2^64, as Redis demands."""


def event_id(text: str) -> EventId:
    """Returns an event's id as numbers, which compare in the order of the events."""
    first, _, second = text.partition("-")
    return int(first), int(second or 0)


class Tail:
    """The end of a job's event stream: knows the newest event, and wakes those who wait for it.

    Attributes:
        newest: the id of the newest event.
        is_over: no more events follow, because the job or the reader ended.
        has_ended: the job ended.
        clients: how many use it.
        ready: done once `newest` is known.
        reader: the task that reads the stream.
    """

    reader: asyncio.Task[None]

    def __init__(self) -> None:
        self.newest: EventId = (0, 0)
        self.is_over = self.has_ended = False
        self.clients = 0
        self.ready: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._news = asyncio.Event()

    async def wait_beyond(self, last: EventId, seconds: float) -> bool:
        """Wait until there are events after `last`, the stream is over, or the time is."""
        await self._until(lambda: self.newest > last or self.is_over, seconds)
        return self.newest > last

    async def end(self, seconds: float) -> None:
        """Wait until the stream is over, or the time is."""
        await self._until(lambda: self.is_over, seconds)

    async def _until(self, holds: Callable[[], bool], seconds: float) -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while not holds():
                    await self._news.wait()

    def advance(self, newest: EventId, is_over: bool, *, has_ended: bool = False) -> None:
        """Wake those who wait."""
        self.newest, self.is_over = max(newest, self.newest), is_over
        self.has_ended = self.has_ended or has_ended
        self._news.set()
        self._news = asyncio.Event()


class Tails:
    """The tails of all jobs that have clients, at most `limit`; one reader for all clients of a job."""

    def __init__(self, redis: Redis, limit: int, on_error: Callable[[Exception], None]) -> None:
        self._redis = redis
        self._limit = limit
        self._on_error = on_error
        self._tails: dict[str, Tail] = {}

    @property
    def is_full(self) -> bool:
        """Whether no other job can be followed."""
        return len(self._tails) >= self._limit

    @asynccontextmanager
    async def of(self, key: str, since: str = "") -> AsyncIterator[Tail]:
        """The end of a stream, from now on, or from the event `since`.

        Raises:
            RedisError: Redis cannot be reached.
        """
        tail = self._tails.get(key)
        if tail is None:
            tail = self._tails[key] = Tail()
            tail.reader = asyncio.create_task(self._run(key, tail, since))
        tail.clients += 1
        try:
            await asyncio.shield(tail.ready)
            yield tail
        finally:
            tail.clients -= 1
            if not tail.clients:
                self._forget(key, tail)
                tail.reader.cancel()

    def stop(self) -> None:
        """End all tails."""
        for key, tail in list(self._tails.items()):
            self._forget(key, tail)
            tail.advance((0, 0), is_over=True)

    async def _run(self, key: str, tail: Tail, since: str) -> None:
        try:
            if not since:
                newest: Any = await self._redis.xrevrange(key, count=1)
                since = newest[0][0] if newest else "0"
            tail.newest = event_id(since)
            tail.ready.set_result(None)
            while tail.clients and not tail.is_over:  # redis-py may swallow a cancellation
                await self._step(key, tail)
        except RedisError as error:
            self._on_error(error)
            if not tail.ready.done():
                tail.ready.set_exception(error)
        finally:
            self._forget(key, tail)
            tail.advance((0, 0), is_over=True)
            if not tail.ready.done():
                tail.ready.cancel()

    async def _step(self, key: str, tail: Tail) -> None:
        last = f"{tail.newest[0]}-{tail.newest[1]}"
        reply: Any = await self._redis.xread({key: last}, count=_COUNT, block=int(1000 * _BLOCK))
        if reply:
            entries = reply[0][1]
            if len(entries) == _COUNT:
                entries = await self._redis.xrevrange(key, count=1) or entries
            has_ended = any(is_terminal(fields) for _, fields in entries)
            tail.advance(event_id(entries[-1][0]), is_over=has_ended, has_ended=has_ended)

    def _forget(self, key: str, tail: Tail) -> None:
        if self._tails.get(key) is tail:
            del self._tails[key]


def is_terminal(fields: dict[str, str]) -> bool:
    """Whether an event is the last one of its job."""
    return fields["type"] == "status" and fields["status"] not in ("queued", "running")


class Event(NamedTuple):
    """An event as it is sent."""

    id: str
    text: bytes
    is_last: bool


class _Slices(NamedTuple):
    """Slices of a job by the length of the fixed leg, as JSON."""

    leg: int
    texts: Mapping[str, bytes]


_NO_SLICES = _Slices(1, {})


class JobEvents:
    """Reads the event streams of jobs.

    All followers of a job share one reader, and the events that it finds. A follower holds nothing but its
    position, so one that is slow costs no memory: what is not kept any more is read again.
    """

    def __init__(self, settings: Settings, queue: JobQueue, access: RedisAccess, refusals: Refusals) -> None:
        """It has a pool of connections of its own: one for each job that is followed."""
        self.queue = queue
        self.access = access
        self.refusals = refusals
        self.keepalive = settings.keepalive_seconds
        self.redis = Redis.from_url(
            settings.redis_url,
            max_connections=STREAM_CONNECTIONS + 1,
            socket_timeout=_BLOCK + _MARGIN,
            socket_connect_timeout=_MARGIN,
            decode_responses=True,
            protocol=2,
            driver_info=None,
            **password(settings.redis_url),
            retry=Retry(ExponentialBackoff(cap=0.5, base=0.05), 4, supported_errors=(RedisConnectionError,)),
        )
        self._tails = Tails(self.redis, STREAM_CONNECTIONS, refusals.log)
        self._cache = _EventCache(access, self._read)
        self._is_stopping = False

    def stop(self) -> None:
        """End all streams and waits at shutdown; call it in the event loop."""
        self._is_stopping = True
        self._tails.stop()

    async def close(self) -> None:
        """Close the connections."""
        self.stop()
        await self.redis.aclose()

    async def wait(self, view: JobView, seconds: float) -> bool:
        """Wait until a job has ended, or the time is over; returns whether it has certainly ended.

        It does not wait if too many jobs are waited for already.

        Raises:
            RedisError: Redis cannot be reached.
        """
        end, since = time.monotonic() + seconds, view.event
        while not self._tails.is_full:
            async with self._tails.of(self._key(view.id), since) as tail:
                if not since:  # it may have ended before
                    now = await self.access(self.queue.get, view.id)
                    if now is None or now.is_terminal:
                        return now is not None
                left = end - time.monotonic()
                if left <= 0 or self._is_stopping:
                    return False
                await tail.end(left)
                if tail.has_ended:
                    return True
            since = ""
        return False

    def tail(self, job_id: str) -> AbstractAsyncContextManager[Tail]:
        """The end of a job's events, from now on.

        Raises:
            RedisError: Redis cannot be reached.
        """
        return self._tails.of(self._key(job_id))

    async def after(self, view: JobView, last_id: str) -> Sequence[Event]:
        """Returns the next events after `last_id` that exist already."""
        return await self._cache.get(_Position(view.run, view.id, last_id))

    async def follow(self, view: JobView, last_id: str) -> AsyncGenerator[bytes]:
        """Yields the stream as text/event-stream, from after `last_id` to the end of the job.

        It ends early if Redis fails; a client that reconnects resumes it.
        """
        try:
            async with aclosing(self._follow(view, last_id)) as parts:
                async for part in parts:
                    yield part
                    await asyncio.sleep(0)  # so that the end of a connection is noticed
        except RedisError as error:
            self.refusals.log(error)

    async def _follow(self, view: JobView, last_id: str) -> AsyncGenerator[bytes]:
        yield b"retry: 1000\n\n"
        async with self.tail(view.id) as tail:
            while not self._is_stopping:
                if await tail.wait_beyond(event_id(last_id), self.keepalive):
                    events = await self.after(view, last_id)
                    if not events:
                        return  # the stream expired, or the job began again
                    for event in events:
                        if self._is_stopping:
                            return
                        last_id = event.id
                        yield event.text
                        if event.is_last:
                            return
                    continue
                now = await self.access(self.queue.get, view.id)
                if now is None or now.is_terminal or tail.is_over:
                    return
                yield b": waiting\n\n"

    def _read(self, job_id: str, last_id: str) -> Sequence[Event]:
        start = f"({last_id}" if last_id != "0" else "-"
        found = self.queue.redis.xrange(self._key(job_id), min=start, count=_AT_ONCE)
        entries = cast("list[tuple[bytes, dict[bytes, bytes]]]", found)
        events = [
            (name.decode(), {key.decode(): value.decode() for key, value in fields.items()})
            for name, fields in entries
        ]
        lengths = [fields["l1"] for _, fields in events if fields["type"] == "slice"]
        slices = self._slices(job_id, lengths) if lengths else _NO_SLICES
        return [Event(name, self._text(job_id, name, f, slices), is_terminal(f)) for name, f in events]

    def _text(self, job_id: str, name: str, fields: Mapping[str, str], slices: _Slices) -> bytes:
        if fields["type"] == "slice":
            length = fields["l1"]
            start = json_bytes({f"l{slices.leg}": length, **_progress(fields)})[:-1]
            return sse(name, "slice", start + b',"slice":' + slices.texts.get(length, b"null") + b"}")
        if fields["type"] == "progress":
            return sse(name, "progress", json_bytes(_progress(fields)))
        if fields["type"] == "improvement":
            return sse(name, "improvement", fields["improvement"].encode())
        if fields["type"] == "item":
            item = {"index": int(fields["item"]), "status": fields["status"]}
            return sse(name, "item", json_bytes({**item, **_progress(fields)}))
        return sse(name, "status", json_bytes(self._status(job_id, fields["status"])))

    def _status(self, job_id: str, status: str) -> dict[str, object]:
        """Returns the job when it came to a state; of one that it has left, without what came later."""
        view = self.queue.get(job_id)
        if view is None:
            return {"id": job_id, "status": shown_state(job_id, cast(Status, status))}
        is_now = view.status == status
        return state_json(view, self.queue.settings) if is_now else earlier_state(view, status)

    def _slices(self, job_id: str, lengths: Sequence[str]) -> _Slices:
        queue = self.queue
        asked = queue.records.asked(job_id, lengths)
        if asked is None:
            return _NO_SLICES
        request, errors = asked
        texts = queue.store.get_texts(request, lengths, request.digits)
        others = queue.store.get_slices(request, [x for x in lengths if x not in texts])
        known = texts | {x: dump(value).encode() for x, value in {**others, **errors}.items()}
        return _Slices(request.fixed_leg, known)

    def _key(self, job_id: str) -> str:
        return self.queue.keys.job(job_id).events


class _Position(NamedTuple):
    """An event of a run of a job."""

    run: str
    job_id: str
    last_id: str


class _EventCache:
    """The events after a position, each read once for all readers at about the same position."""

    def __init__(self, access: RedisAccess, read: Callable[[str, str], Sequence[Event]]) -> None:
        self._access, self._read = access, read
        self._kept: OrderedDict[_Position, Sequence[Event]] = OrderedDict()
        self._size = 0
        self._reads: dict[_Position, asyncio.Task[Sequence[Event]]] = {}

    async def get(self, position: _Position) -> Sequence[Event]:
        kept = self._kept.get(position)
        if kept is not None:
            self._kept.move_to_end(position)
            return kept
        task = self._reads.get(position)
        if task is None:
            reading = self._access(self._read, position.job_id, position.last_id)
            task = self._reads[position] = asyncio.create_task(reading)
            task.add_done_callback(lambda done: self._keep(position, done))
        return await asyncio.shield(task)

    def _keep(self, position: _Position, done: asyncio.Task[Sequence[Event]]) -> None:
        del self._reads[position]
        if done.cancelled() or done.exception() is not None or not done.result():
            return
        self._kept[position] = done.result()
        self._size += sum(len(event.text) for event in done.result())
        while self._size > _KEPT and len(self._kept) > 1:
            self._size -= sum(len(event.text) for event in self._kept.popitem(last=False)[1])


def sse(event_id: str, name: str, data: bytes) -> bytes:
    """Returns one server-sent event. The id comes first; `fastapi.sse` would write it last."""
    return f"id: {event_id}\nevent: {name}\ndata: ".encode() + data + b"\n\n"


def _progress(fields: Mapping[str, str]) -> dict[str, object]:
    return {"progress": {"done": int(fields["done"]), "total": int(fields["total"])}}
