"""The FastAPI application, and the guard before it: a request must name this service, and its caller must
have the scope that the call needs."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass

from anyio import to_thread
from fastapi import FastAPI, Response
from redis import Redis
from redis.exceptions import RedisError
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.cors import CORSMiddleware
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rpr_solver.errors import clipped
from service import __version__
from service.api.caller import CHALLENGE, Caller, Rules, check_scope, is_known, set_caller
from service.api.context import Context
from service.api.contract.openapi import describe, operation_id
from service.api.http.middleware import (
    AccessLog,
    Compression,
    RequestEnvelope,
    add_error_handlers,
    problem_of,
)
from service.api.keys import KeyRing, KeyStore
from service.api.problems import ProblemError, ProblemType
from service.api.routes import jobs, pages
from service.api.routes import router as questions
from service.api.routes.pages import WEB, Assets
from service.api.settings import Settings
from service.commit import commit
from worker.lua import Scripts

WINDOW = 60
"""Seconds in which an empty allowance is full again."""


@dataclass(frozen=True)
class Allowance:
    """What a caller has left.

    Attributes:
        limit: requests in a window.
        is_over: whether this request is one too many.
        retry_s: seconds until the next one is allowed.
        full_s: seconds until the allowance is full again.
    """

    limit: int
    is_over: bool
    retry_s: float
    full_s: float

    @property
    def left(self) -> int:
        """The number of requests that are allowed at once."""
        return max(0, math.floor(self.limit * (1 - self.full_s / WINDOW)))

    def headers(self) -> dict[str, str]:
        """Returns the headers of the draft `draft-ietf-httpapi-ratelimit-headers`.

        >>> Allowance(100, False, 0.0, 3.0).headers()
        {'RateLimit-Policy': '"requests";q=100;w=60', 'RateLimit': '"requests";r=95;t=3'}
        """
        return {
            "RateLimit-Policy": f'"requests";q={self.limit};w={WINDOW}',
            "RateLimit": f'"requests";r={self.left};t={math.ceil(self.full_s)}',
        }


class RateLimit:
    """The allowances of all callers."""

    def __init__(self, redis: Redis, prefix: str, limit: int) -> None:
        self.limit = limit
        self._prefix = prefix
        self._run = Scripts(redis, "service.api")

    def take(self, caller_id: str) -> Allowance:
        """Take one request from the allowance of a caller."""
        key = f"{self._prefix}:rate:{caller_id}"
        reply = self._run("take_request", allowance=key, limit=self.limit, window=WINDOW)
        allowed, retry_ms, full_ms = reply
        return Allowance(self.limit, not allowed, retry_ms / 1000, full_ms / 1000)


class Guard:
    """A layer of the application; refuses before a body is read."""

    def __init__(self, app: ASGIApp, context: Context, rules: Rules) -> None:
        settings, redis, prefix = context.settings, context.queue.redis, context.queue.settings.key_prefix
        self.app = app
        self.settings = settings
        self.rules = rules
        self.ask = context.redis
        self.ring = KeyRing(KeyStore(redis, prefix), context.redis)
        self.rate = RateLimit(redis, prefix, settings.limits.max_requests_per_minute)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let one request in, or answer it with a problem."""
        if scope["type"] == "http":
            headers: dict[str, str] = {}
            send = _with_headers(send, headers)
            try:
                await self._admit(scope, headers)
            except (ProblemError, RedisError) as error:
                response = problem_of(Request(scope), error).response(scope["path"])
                await response(scope, receive, send)
                return
        await self.app(scope, receive, send)

    async def _admit(self, scope: Scope, answer_headers: dict[str, str]) -> None:
        headers = Headers(scope=scope)
        _check_host(headers, self.settings.allowed_hosts)
        needed = self.rules.scope_needed(scope["method"], scope["path"])
        if needed is None:
            return
        caller = await self._caller(scope, headers)
        set_caller(scope, caller)
        if caller.is_limited and self.rate.limit:
            allowance = await self.ask(self.rate.take, caller.id)
            answer_headers.update(allowance.headers())
            if allowance.is_over:
                raise _too_many(allowance)
        check_scope(caller, needed)

    async def _caller(self, scope: Scope, headers: Headers) -> Caller:
        sent = headers.get("authorization", "")
        scheme, _, token = sent.partition(" ")
        token = token.strip() if scheme.lower() == "bearer" else ""
        is_open = await self._is_open()
        if is_open and not token.startswith("rpr_"):
            address = scope["client"][0] if scope.get("client") else "unknown"
            return Caller(f"address:{address}", None, "admin")
        if not sent:
            raise ProblemError(
                ProblemType.UNAUTHORIZED,
                "This service requires a key: send it as Authorization: Bearer rpr_….",
                headers={"WWW-Authenticate": CHALLENGE},
            )
        key = await self.ring.find(token)
        if key is None:
            raise ProblemError(
                ProblemType.UNAUTHORIZED,
                "The Authorization header has no valid key: the key is unknown, expired or revoked, or not "
                "sent as Bearer rpr_….",
                headers={"WWW-Authenticate": f'{CHALLENGE}, error="invalid_token"'},
            )
        return Caller(f"key:{key.id}", key.name, key.scope)

    async def _is_open(self) -> bool:
        required = self.settings.require_keys
        return required == "never" or (required == "auto" and await self.ring.is_empty())


def _with_headers(send: Send, headers: Mapping[str, str]) -> Send:
    async def send_on(message: Message) -> None:
        if headers and message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(headers)
        await send(message)

    return send_on


def _too_many(allowance: Allowance) -> ProblemError:
    name, retry_s = "max_requests_per_minute", max(1, math.ceil(allowance.retry_s))
    detail = f"More than {allowance.limit} requests in a minute; the limit is {name}."
    return ProblemError.too_many(detail, name, allowance.limit, retry_s)


def _check_host(headers: Headers, names: tuple[str, ...]) -> None:
    header = headers.get("host")
    # without one, the client speaks HTTP/1.0 and is no browser
    if header is None or is_known(header, names):
        return
    sent = clipped(header, 100)
    raise ProblemError(
        ProblemType.UNKNOWN_HOST,
        f"The Host header {sent!r} is not a name of this service. Use its IP address, or ask its operator "
        "to add the name to RPR_CUSPS_ALLOWED_HOSTS.",
        errors=[("Host", f"{sent!r} is not in RPR_CUSPS_ALLOWED_HOSTS")],
    )


_GZIP_BYTES = 1024  # from which on a response is compressed: shorter ones fit into one packet
_GZIP_LEVEL = 1  # digits: level 5 takes five times as long for five per cent fewer bytes
_ALLOWED_HEADERS = (
    *("Authorization", "Content-Type", "Idempotency-Key", "If-None-Match"),
    *("Last-Event-ID", "Prefer"),
)
_EXPOSED_HEADERS = (
    *("Content-Location", "ETag", "Location"),
    *("Preference-Applied", "Retry-After", "X-Request-ID"),
)


def create_app(settings: Settings | None = None) -> FastAPI:
    """Create the application. It starts and runs without Redis too."""
    settings = settings or Settings()
    context = Context(settings)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        check = asyncio.create_task(context.check_redis())
        asking = asyncio.create_task(
            to_thread.run_sync(commit)
        )  # before files change under a service that runs
        try:
            yield
        finally:
            check.cancel()
            await asking
            await context.close()

    app = FastAPI(
        title="rpr-cusps",
        version=__version__,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
        redirect_slashes=False,
        default_response_class=Response,
        generate_unique_id_function=operation_id,
        telemetry={"tracing": False, "metrics": False, "logs": False},  # we have our own
    )
    app.state.context = context
    app.state.begin_shutdown = context.events.stop
    for router in (questions, jobs.batches, jobs.router, pages.status, pages.router):
        app.include_router(router)
    app.mount("/static", Assets(directory=WEB), name="static")
    add_error_handlers(app)
    describe(app)
    app.add_middleware(Guard, context=context, rules=Rules(app.routes))
    app.add_middleware(
        Compression, minimum_size=_GZIP_BYTES, compresslevel=_GZIP_LEVEL, thread_minimum_size=1 << 14
    )
    if settings.cors_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.cors_origins,
            allow_methods=("GET", "POST", "DELETE"),
            allow_headers=_ALLOWED_HEADERS,
            expose_headers=_EXPOSED_HEADERS,
        )
    log = AccessLog(settings.access_log)
    app.add_middleware(RequestEnvelope, metrics=context.metrics, access_log=log, settings=settings)
    return app
