"""The events of a job: waiting for its end, and following it as server-sent events."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import anyio
from redis.asyncio import Redis
from redis.exceptions import RedisError

from service.api.job_view import job_json
from service.api.redis_access import RedisAccess
from service.api.settings import Settings
from worker.connection import password
from worker.jobs.queue import JobQueue
from worker.jobs.records import JobView

log = logging.getLogger("rpr_cusps.service")

_BATCH = 200
_MARGIN = 10.0


@dataclass(frozen=True)
class Event:
    """One entry of a job's stream."""

    id: str
    fields: Mapping[str, str]


class JobEvents:
    """Reads the event streams of jobs without blocking threads."""

    def __init__(self, redis: Redis, queue: JobQueue, access: RedisAccess, keepalive: float) -> None:
        self.redis = redis
        self.queue = queue
        self.access = access
        self.keepalive = keepalive
        self._stopping = False
        self._reads: set[anyio.CancelScope] = set()

    @classmethod
    def of(cls, settings: Settings, queue: JobQueue, access: RedisAccess) -> JobEvents:
        """Returns a reader with a separate connection pool; each waiting client holds one connection."""
        redis = Redis.from_url(
            settings.redis_url,
            max_connections=settings.stream_connections,
            socket_timeout=settings.keepalive_seconds + _MARGIN,
            socket_connect_timeout=3.0,
            decode_responses=True,
            protocol=2,
            **password(settings.redis_url),
        )
        return cls(redis, queue, access, settings.keepalive_seconds)

    def stop(self) -> None:
        """End all streams and waits at shutdown; call it in the event loop."""
        self._stopping = True
        for read in list(self._reads):
            read.cancel()

    async def close(self) -> None:
        """Close the connections."""
        self.stop()
        await self.redis.aclose()

    async def wait(self, job_id: str, seconds: float) -> JobView | None:
        """Returns the job once it has ended, or its state when the time is over."""
        end = time.monotonic() + seconds
        while True:
            last = await self._last(job_id)
            view = await self._view(job_id)
            left = end - time.monotonic()
            if view is None or view.is_terminal or left <= 0 or self._stopping:
                return view
            block_end = time.monotonic() + min(left, self.keepalive)
            ended = False
            while not (ended or self._stopping) and (left := block_end - time.monotonic()) > 0:
                batch = await self._read(job_id, last, left)
                last = batch[-1].id if batch else last
                ended = any(_is_terminal(event) for event in batch)

    async def after(self, job_id: str, last_id: str) -> list[Event]:
        """Returns the first event after `last_id`, if it exists already."""
        entries: Any = await self.redis.xrange(
            self._key(job_id), min=f"({last_id}" if last_id != "0" else "-", count=1
        )
        return [Event(*entry) for entry in entries]

    async def follow(self, job_id: str, last_id: str) -> AsyncIterator[bytes]:
        """Yields the stream as text/event-stream, from after `last_id` to the end of the job.

        It ends early if Redis fails; a client that reconnects resumes it.
        """
        try:
            async for part in self._follow(job_id, last_id):
                yield part
        except RedisError as error:
            log.warning("the events of %s end early: %s", job_id, error)

    async def _follow(self, job_id: str, last_id: str) -> AsyncIterator[bytes]:
        yield b"retry: 1000\n\n"
        while True:
            batch = await self._read(job_id, last_id, self.keepalive)
            if self._stopping:
                return
            if not batch:
                view = await self._view(job_id)
                if view is None or view.is_terminal:
                    return
                yield b": waiting\n\n"
                continue
            slices = await self._slices(job_id, batch)
            for event in batch:
                if self._stopping:
                    return
                last_id = event.id
                yield await self._encode(job_id, event, slices)
                if _is_terminal(event):
                    return

    async def _encode(self, job_id: str, event: Event, slices: Mapping[str, Any]) -> bytes:
        fields = event.fields
        if fields["type"] == "slice":
            l1 = fields["l1"]
            return sse(event.id, "slice", {"l1": l1, **_progress(fields), "slice": slices.get(l1)})
        if fields["type"] == "progress":
            return sse(event.id, "progress", _progress(fields))
        view = await self._view(job_id)
        document = {"id": job_id, "status": fields["status"]} if view is None else job_json(view)
        return sse(event.id, "status", {**document, "status": fields["status"]})

    async def _slices(self, job_id: str, batch: Sequence[Event]) -> dict[str, Any]:
        l1 = [event.fields["l1"] for event in batch if event.fields["type"] == "slice"]
        return await self.access(self._known_slices, job_id, l1) if l1 else {}

    def _known_slices(self, job_id: str, l1: list[str]) -> dict[str, Any]:
        record = self.queue.records.request(job_id)
        if record is None:
            return {}
        _, request, errors = record
        return {**self.queue.store.get_slices(request, l1), **errors}

    async def _view(self, job_id: str) -> JobView | None:
        return await self.access(self.queue.get, job_id)

    async def _last(self, job_id: str) -> str:
        newest: Any = await self.redis.xrevrange(self._key(job_id), count=1)
        return cast(str, newest[0][0]) if newest else "0"

    async def _read(self, job_id: str, last_id: str, seconds: float) -> list[Event]:
        block = max(1, int(seconds * 1000))
        reply: Any = None
        with anyio.CancelScope() as scope:
            self._reads.add(scope)
            try:
                reply = await self.redis.xread({self._key(job_id): last_id}, count=_BATCH, block=block)
            finally:
                self._reads.discard(scope)
        return [Event(*entry) for entry in reply[0][1]] if reply else []

    def _key(self, job_id: str) -> str:
        return self.queue.records.keys.job(job_id).events


def sse(event_id: str, name: str, data: object) -> bytes:
    """Returns one server-sent event. The id comes first; `fastapi.sse` would write it last."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    return f"id: {event_id}\nevent: {name}\ndata: {text}\n\n".encode()


def _progress(fields: Mapping[str, str]) -> dict[str, object]:
    return {"progress": {"done": int(fields["done"]), "total": int(fields["total"])}}


def _is_terminal(event: Event) -> bool:
    return event.fields["type"] == "status" and event.fields["status"] not in ("queued", "running")
