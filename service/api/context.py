"""The context of the routes: settings, the queue, the event streams and the metrics of one application."""

from __future__ import annotations

import logging
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends, Request
from redis.exceptions import RedisError

from service.api.answers.kept import KeptAnswers
from service.api.http.transport import Slots
from service.api.jobs.events import JobEvents
from service.api.metrics import Metrics
from service.api.settings import Settings
from service.api.threads import Breaker, RedisAccess, Refusals, Threads
from worker.connection import connect, eviction_warning
from worker.jobs.clients import Callbacks
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.service")

_EVENT_THREADS = 8
_PARSING_THREADS = 4
_SCRAPING_THREADS = 2


@dataclass(frozen=True)
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

    settings: Settings
    queue: JobQueue
    callbacks: Callbacks
    events: JobEvents
    metrics: Metrics
    redis: RedisAccess
    parsing: Threads
    kept: KeptAnswers
    scraping: Threads
    refusals: Refusals
    large_answers: Slots
    followers: Slots

    @classmethod
    def of(cls, settings: Settings) -> Context:
        """Create the parts; nothing connects yet."""
        redis = connect(
            settings.redis_url,
            max_connections=settings.redis_connections,
            timeout=settings.redis_timeout_seconds,
        )
        queue = JobQueue(redis, WorkerSettings())
        breaker, refusals = Breaker(), Refusals()
        return cls(
            settings=settings,
            queue=queue,
            callbacks=Callbacks(redis, queue.settings),
            events=JobEvents.of(settings, queue, RedisAccess(Threads(_EVENT_THREADS), breaker), refusals),
            metrics=Metrics(queue),
            redis=RedisAccess(Threads(settings.threads), breaker),
            parsing=Threads(_PARSING_THREADS),
            kept=KeptAnswers(settings.answer_cache_mb << 20, settings.answer_cache_seconds),
            scraping=Threads(_SCRAPING_THREADS),
            refusals=refusals,
            large_answers=Slots(
                "large results", settings.large_answers, settings.retry_seconds, settings.large_answer_bytes
            ),
            followers=Slots("streams of events", settings.max_followers, settings.retry_seconds),
        )

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
