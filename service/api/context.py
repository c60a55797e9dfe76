"""The context of the routes: settings, the queue, the event streams, the metrics and the latest answers of
one application.

Answers are kept in the memory of the API for a short time after they were sent. Asked for again, they need no
store; and a question that is repeated word for word need not be read.

An answer never changes, so what is kept is always right. It is kept for a short time only, so that the links
in it do not outlive for long what they lead to. What may change (a table with errors, a search that was
stopped) is not kept.
"""

from __future__ import annotations

import logging
import time
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from typing import Annotated, NamedTuple, cast

from fastapi import Depends, Request
from redis.exceptions import RedisError
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.http import Slots
from service.api.job_events import JobEvents
from service.api.metrics import Metrics
from service.api.settings import Settings, here
from service.api.threads import Breaker, RedisAccess, Refusals, Threads
from service.webhooks.callbacks import Callbacks
from worker.answers.kinds import kind_of_job
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


_KEPT = "rpr_cusps.kept"
_MOST_QUESTIONS = 500
_LONGEST = 1 << 10  # bytes of a question
_SIGNIFICANT = frozenset({b"accept", b"content-type", b"content-encoding"})
"""The header fields on which the answer to a posted question depends, as far as this layer sees them."""


class _Reply(NamedTuple):
    kind: str
    answer: Kept
    route: object
    headers: list[tuple[bytes, bytes]]


def note_kept(scope: Scope, kept: Kept) -> None:
    """Note in a request which of the kept answers is sent."""
    scope[_KEPT] = kept


class Repeats:
    """A layer behind the guard that answers repeated questions; for the thread of the event loop.

    Bodies are compared as bytes, with everything else on which the answer depends. So this layer knows
    nothing of questions, and callers, rates, logs and metrics are the same as for every request.

    Args:
        app: the application.
        kept: the answers that are kept.
        count: counts an answer to a kind of question, which was `cached`.
    """

    def __init__(self, app: ASGIApp, kept: KeptAnswers, count: Callable[[str, str], object]) -> None:
        self.app = app
        self._kept = kept
        self._count = count
        self._replies: OrderedDict[object, _Reply] = OrderedDict()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http" or scope["method"] != "POST" or not _is_short(scope):
            await self.app(scope, receive, send)
            return
        first = await receive()
        if first["type"] != "http.request" or first.get("more_body"):
            await self.app(scope, _after(first, receive), send)
            return
        fields = tuple(field for field in scope["headers"] if field[0] in _SIGNIFICANT)
        key = here(scope["path"]), scope["query_string"], fields, first.get("body", b"")
        reply = self._replies.get(key)
        if reply is not None and self._kept.get(reply.answer.job_id, reply.answer.form) is reply.answer:
            self._replies.move_to_end(key)
            scope["route"] = reply.route
            self._count(reply.kind, "cached")
            await send({"type": "http.response.start", "status": 200, "headers": [*reply.headers]})
            await send({"type": "http.response.body", "body": reply.answer.body})
            return

        async def send_on(message: Message) -> None:
            if message["type"] == "http.response.start" and message["status"] == 200 and _KEPT in scope:
                self._note(key, scope, [*message["headers"]])
            await send(message)

        await self.app(scope, _after(first, receive), send_on)

    def _note(self, key: object, scope: Scope, headers: list[tuple[bytes, bytes]]) -> None:
        answer: Kept = scope[_KEPT]
        kind = kind_of_job(answer.job_id)
        assert kind is not None, "it answers a question"
        self._replies[key] = _Reply(kind.name, answer, scope.get("route"), headers)
        if len(self._replies) > _MOST_QUESTIONS:
            self._replies.popitem(last=False)


def _is_short(scope: Scope) -> bool:
    size = next((value for name, value in scope["headers"] if name == b"content-length"), b"")
    return size.isdigit() and len(size) <= len(str(_LONGEST)) and int(size) <= _LONGEST


def _after(first: Message, receive: Receive) -> Receive:
    """Returns a `receive` that first gives the message that was received already."""
    waiting = [first]

    async def receive_on() -> Message:
        return waiting.pop() if waiting else await receive()

    return receive_on


log = logging.getLogger("rpr_cusps.service")

_EVENT_THREADS = 8
_PARSING_THREADS = 4
_SCRAPING_THREADS = 2


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
            settings.redis_url,
            max_connections=settings.redis_connections,
            timeout=settings.redis_timeout_seconds,
        )
        breaker, retry = Breaker(), settings.retry_seconds
        self.settings = settings
        self.queue = queue = JobQueue(redis, WorkerSettings())
        self.callbacks = Callbacks(redis, queue.settings)
        self.metrics = Metrics(queue)
        self.redis = RedisAccess(Threads(settings.threads), breaker)
        self.parsing = Threads(_PARSING_THREADS)
        self.kept = KeptAnswers(settings.answer_cache_mb << 20, settings.answer_cache_seconds)
        self.scraping = Threads(_SCRAPING_THREADS)
        self.refusals = Refusals()
        self.events = JobEvents(settings, queue, RedisAccess(Threads(_EVENT_THREADS), breaker), self.refusals)
        self.large_answers = Slots(
            "large results", settings.large_answers, retry, settings.large_answer_bytes
        )
        self.followers = Slots("streams of events", settings.max_followers, retry)

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
