"""The context of the routes: settings, the queue, the event streams and the metrics of one application."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Annotated, ParamSpec, TypeVar, cast

import anyio.to_thread
from fastapi import Depends, Request

from service.api.job_events import JobEvents
from service.api.metrics import Metrics
from service.api.settings import Settings
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True)
class Context:
    """The parts of one application. All persistent state is in Redis."""

    settings: Settings
    queue: JobQueue
    events: JobEvents
    metrics: Metrics

    @classmethod
    def of(cls, settings: Settings) -> Context:
        """Create the parts; nothing connects yet."""
        redis = connect(settings.redis_url, max_connections=settings.redis_connections)
        queue = JobQueue(redis, WorkerSettings())
        return cls(settings, queue, JobEvents.of(settings, queue), Metrics(queue))

    async def close(self) -> None:
        """Close the connections."""
        await self.events.close()
        await in_thread(self.queue.redis.close)


async def in_thread(function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """Run a blocking function (Redis, exact arithmetic) outside the event loop."""
    return await anyio.to_thread.run_sync(partial(function, *args, **kwargs))


async def _context(request: Request) -> Context:
    return cast(Context, request.app.state.context)


ContextDep = Annotated[Context, Depends(_context)]
