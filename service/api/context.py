"""The context of the routes: settings, the queue, the event streams, the metrics and the latest answers of
one application.

Answers are kept in the memory of the API for a short time after they were sent. Asked for again, they need no
store.

An answer never changes, so what is kept is always right. It is kept for a short time only, so that the links
in it do not outlive for long what they lead to. What may change (a table with errors, a search that was
stopped) is not kept.
"""

from __future__ import annotations

import logging
import time
from collections import OrderedDict
from contextlib import suppress
from typing import Annotated, NamedTuple, cast

from fastapi import Depends, Request
from redis.exceptions import RedisError

from service.api.http import Slots
from service.api.job_events import JobEvents
from service.api.metrics import Metrics
from service.api.settings import REDIS_CONNECTIONS, RETRY_SECONDS, Settings
from service.api.threads import Breaker, RedisAccess, Refusals, Threads
from service.webhooks.callbacks import Callbacks
from worker.connection import connect, eviction_warning
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

_MOST_BYTES = 256 << 10
"""Of one answer; larger ones are sent in pieces."""
_OVERHEAD = 500


class Kept(NamedTuple):
    """An answer in one form.

    Attributes:
        job_id: the id of the job of its question.
        form: its media type, with its parameter.
        digest: that of its ETag.
        body: its bytes.
        until: the time from which on it is looked up again (`time.monotonic()`).
    """

    job_id: str
    form: str
    digest: str
    body: bytes
    until: float


class KeptAnswers:
    """The answers sent last, by the ids of their jobs and by form; for the thread of the event loop.

    Args:
        most_bytes: the memory that they may take, about; 0 keeps none.
        seconds: how long each is kept.
    """

    def __init__(self, most_bytes: int, seconds: float) -> None:
        self._left = most_bytes
        self._seconds = seconds
        self._kept: OrderedDict[tuple[str, str], Kept] = OrderedDict()

    def get(self, job_id: str, form: str) -> Kept | None:
        """Returns what is kept of an answer in this form, if anything."""
        key = job_id, form
        kept = self._kept.get(key)
        if kept is None:
            return None
        if kept.until < time.monotonic():
            self._drop(key)
            return None
        self._kept.move_to_end(key)
        return kept

    def put(self, job_id: str, form: str, digest: str, body: bytes) -> None:
        """Keep an answer that will not change, in place of those that were asked for least recently."""
        key = job_id, form
        if len(body) > _MOST_BYTES:
            return
        self._drop(key)
        self._kept[key] = Kept(job_id, form, digest, body, time.monotonic() + self._seconds)
        self._left -= len(body) + _OVERHEAD
        while self._left < 0 and self._kept:
            self._drop(next(iter(self._kept)))

    def _drop(self, key: tuple[str, str]) -> None:
        kept = self._kept.pop(key, None)
        if kept is not None:
            self._left += len(kept.body) + _OVERHEAD


log = logging.getLogger("rpr_cusps.service")

_REDIS_THREADS = 40  # for short commands: of fewer than the connections, so that none waits for one
_EVENT_THREADS = 8
_PARSING_THREADS = 4
_SCRAPING_THREADS = 2
_CACHE_SECONDS = 60.0  # for which an answer that was sent is kept: who asks again soon does so at once
_LARGE_ANSWER_BYTES = 256 << 20  # of memory that large results take which are being sent, about


class Context:
    """The parts of one application. All persistent state is in Redis.

    Attributes:
        settings: how the process runs.
        queue: the jobs and results.
        callbacks: the URLs to call at the end of jobs.
        events: the event streams of jobs.
        metrics: counts and times.
        redis: runs what uses Redis, outside the event loop.
        parsing: threads for the reading of requests.
        kept: answers that were sent a moment ago.
        scraping: threads for the metrics.
        refusals: the log of what Redis refuses.
        large_answers: the large results that are being sent.
        followers: the streams of events that are being sent.
    """

    def __init__(self, settings: Settings) -> None:
        """Create the parts; nothing connects yet."""
        redis = connect(
            settings.redis_url, max_connections=REDIS_CONNECTIONS, timeout=settings.redis_timeout_seconds
        )
        breaker = Breaker()
        self.settings = settings
        self.queue = queue = JobQueue(redis, WorkerSettings())
        self.callbacks = Callbacks(redis, queue.settings)
        self.metrics = Metrics(queue)
        self.redis = RedisAccess(Threads(_REDIS_THREADS), breaker)
        self.parsing = Threads(_PARSING_THREADS)
        self.kept = KeptAnswers(settings.answer_cache_mb << 20, _CACHE_SECONDS)
        self.scraping = Threads(_SCRAPING_THREADS)
        self.refusals = Refusals()
        self.events = JobEvents(settings, queue, RedisAccess(Threads(_EVENT_THREADS), breaker), self.refusals)
        self.large_answers = Slots(
            "large results", settings.large_answers, RETRY_SECONDS, _LARGE_ANSWER_BYTES
        )
        self.followers = Slots("streams of events", settings.max_followers, RETRY_SECONDS)

    async def check_redis(self) -> None:
        """Log problems of a Redis that can be reached; requests report one that cannot."""
        with suppress(RedisError):
            warning = await self.redis(eviction_warning, self.queue.redis)
            if warning is not None:
                log.warning("%s", warning)

    async def close(self) -> None:
        """Close the connections."""
        await self.events.close()
        await self.parsing(self.queue.redis.close)


async def _context(request: Request) -> Context:
    return cast(Context, request.app.state.context)


ContextDep = Annotated[Context, Depends(_context)]
