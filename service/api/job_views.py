"""Jobs, batches and deliveries as the contract shows them; and the end of a job's event stream: one reader
for all clients of the job in this process."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from datetime import datetime, timedelta
from math import ceil
from typing import Any
from urllib.parse import urlsplit

from redis.asyncio import Redis
from redis.exceptions import RedisError

from service.api import Settings, here, prefixed
from service.schemas.resources import address
from service.webhooks.callbacks import Delivery
from service.webhooks.deliverer import DocumentOf, event_type
from worker.answers.kinds import is_batch, kind_of_job
from worker.jobs.clients import JobView, Subscriber
from worker.settings import WorkerSettings

BLOCK = 2.0
"""Seconds for which one command waits; a server that hangs is noticed soon after."""

_COUNT = 4  # events that are read; if there are more, the newest one suffices

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
            if len(entries) == _COUNT:
                entries = await self._redis.xrevrange(key, count=1) or entries
            has_ended = any(is_terminal(fields) for _, fields in entries)
            tail.advance(event_id(entries[-1][0]), is_over=has_ended, has_ended=has_ended)

    def _forget(self, key: str, reader: _Reader) -> None:
        if self._readers.get(key) is reader:
            del self._readers[key]


def is_terminal(fields: dict[str, str]) -> bool:
    """Whether an event is the last one of its job."""
    return fields["type"] == "status" and fields["status"] not in ("queued", "running")


def state_json(view: JobView, settings: WorkerSettings, who: Subscriber | None = None) -> dict[str, object]:
    """Returns the state of a job or a batch; for the client that asks for it, with the way to withdraw it."""
    own = here(address(view.id))
    cancel = {} if who is None else {"cancel": own if who.is_known else f"{own}?subscription={who.token}"}
    return (_batch_json if is_batch(view.id) else _job_json)(view, settings, own, cancel)


def _job_json(view: JobView, settings: WorkerSettings, own: str, cancel: dict[str, str]) -> dict[str, object]:
    kind = kind_of_job(view.id)
    return {
        "id": view.id,
        "kind": None if kind is None else kind.name,
        "status": view.status,
        "run": view.run,
        "done": view.is_terminal,
        "progress": {"done": view.done, "total": view.total},
        "created_at": view.created_at,
        "started_at": view.started_at,
        "finished_at": view.finished_at,
        "expires_at": _expires_at(view, settings),
        "timings": {
            "queued_seconds": _seconds(view.created_at, view.started_at or view.finished_at),
            "running_seconds": _seconds(view.started_at, view.finished_at),
        },
        "error": view.error,
        "position": None if view.place is None else view.place.position,
        "deadline_at": view.deadline_at,
        "estimate_s": view.estimate_s,
        "overruns": view.overruns,
        "links": {"self": own, "result": f"{own}/result", "events": f"{own}/events", **cancel},
    }


def _batch_json(
    view: JobView, settings: WorkerSettings, own: str, cancel: dict[str, str]
) -> dict[str, object]:
    left = view.total - view.done
    return {
        "id": view.id,
        "status": view.status,
        "total": view.total,
        "done": view.done,
        "succeeded": view.done - view.failed,
        "failed": view.failed + (left if view.status == "failed" else 0),
        "canceled": left if view.status == "canceled" else 0,
        "created_at": view.created_at,
        "started_at": view.started_at,
        "finished_at": view.finished_at,
        "expires_at": _expires_at(view, settings),
        "error": view.error,
        "position": None if view.place is None else view.place.position,
        "estimate_s": view.estimate_s,
        "overruns": view.overruns,
        "links": {"self": own, "results": f"{own}/results", "events": f"{own}/events", **cancel},
    }


def _expires_at(view: JobView, settings: WorkerSettings) -> str | None:
    """Returns until when a job that has ended is kept."""
    if view.finished_at is None:
        return None
    ttl = settings.job_ttl if view.status == "succeeded" else settings.failure_ttl
    end = datetime.fromisoformat(view.finished_at) + timedelta(seconds=ttl)
    return end.isoformat(timespec="seconds").replace("+00:00", "Z")


def earlier_state(view: JobView, status: str) -> dict[str, object]:
    """Returns what is known of a job for the time when its run came to a state."""
    return {
        "id": view.id,
        "run": view.run,
        "status": status,
        "created_at": view.created_at,
        "started_at": None if status == "queued" else view.started_at,
        "finished_at": None,
        "error": None,
    }


def _seconds(start: str | None, end: str | None) -> float | None:
    if start is None or end is None:
        return None
    return round((datetime.fromisoformat(end) - datetime.fromisoformat(start)).total_seconds(), 3)


def retry_after(view: JobView, settings: Settings) -> dict[str, str]:
    """Returns the header that says when to ask again for a job: sooner if it runs than if it waits."""
    seconds = 0 if view.place is None else min(ceil(view.place.seconds), settings.longest_poll_seconds)
    return {"Retry-After": str(max(settings.poll_seconds, seconds))}


def deliveries_json(deliveries: list[Delivery]) -> dict[str, object]:
    """Returns the log. It names hosts only, since other callers may have asked the same."""
    return {"deliveries": [_delivery_json(delivery) for delivery in deliveries]}


def _delivery_json(delivery: Delivery) -> dict[str, object]:
    return {
        "webhook_id": delivery.id,
        "type": event_type(delivery.job),
        "host": urlsplit(delivery.url).hostname,
        "state": delivery.state,
        "next_attempt_at": delivery.next_at,
        "attempts": [
            {"at": attempt.at_iso, "status": attempt.status, "problem": attempt.problem}
            for attempt in delivery.attempts
        ],
    }


def event_documents(settings: WorkerSettings, prefix: str = "") -> DocumentOf:
    """Returns what gives the document of a job or a batch for an event, whose links have a prefix."""

    def document(view: JobView) -> dict[str, object]:
        with prefixed(prefix):
            return state_json(view, settings)

    return document
