"""The door of the service: a request must name this service, and its caller must be allowed what it asks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from redis import Redis
from redis.exceptions import RedisError
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.caller import CHALLENGE, Caller, Rules, check_scope, is_known, set_caller
from service.api.context import Context
from service.api.http.middleware import problem_of
from service.api.keys import KeyRing, KeyStore
from service.api.problems import ProblemError, ProblemType
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
        _check_host(headers, self.settings.host_names)
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
    name = "max_requests_per_minute"
    return ProblemError(
        ProblemType.TOO_MANY_REQUESTS,
        f"More than {allowance.limit} requests in a minute; the limit is {name}.",
        headers={"Retry-After": str(max(1, math.ceil(allowance.retry_s)))},
        extra={"limit": {"name": name, "value": allowance.limit}},
    )


def _check_host(headers: Headers, names: tuple[str, ...]) -> None:
    header = headers.get("host")
    # without one, the client speaks HTTP/1.0 and is no browser
    if header is None or is_known(header, names):
        return
    sent = header[:100]
    raise ProblemError(
        ProblemType.UNKNOWN_HOST,
        f"The Host header {sent!r} is not a name of this service. Use its IP address, or ask its operator "
        "to add the name to RPR_CUSPS_ALLOWED_HOSTS.",
        errors=[("Host", f"{sent!r} is not in RPR_CUSPS_ALLOWED_HOSTS")],
    )
