"""Blocking work in threads: each sort has its own, and Redis is not asked while it does not answer."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import ParamSpec, TypeVar

import anyio
import anyio.to_thread
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import TimeoutError as RedisTimeoutError

from rpr_solver.errors import clipped

P = ParamSpec("P")
T = TypeVar("T")


class Threads:
    """At most `count` threads at the same time."""

    def __init__(self, count: int) -> None:
        self._limiter = anyio.CapacityLimiter(count)

    async def __call__(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Run a function in a thread, once one is free."""
        return await anyio.to_thread.run_sync(partial(function, *args, **kwargs), limiter=self._limiter)


log = logging.getLogger("rpr_cusps.service")


_PAUSE = 1.0  # seconds without a command to a server that did not answer
_QUIET = 10.0  # seconds until the same is logged again
_REMEMBERED = 50


class Breaker:
    """A circuit breaker for Redis: open for a moment after a time-out, then half-open (one request at a
    time)."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._next_try: float | None = None

    def check(self) -> None:
        """Check that Redis may be asked.

        Raises:
            RedisConnectionError: it did not answer a moment ago.
        """
        moment = self._next_try
        if moment is not None and time.monotonic() < moment:
            raise RedisConnectionError("it did not answer a moment ago, and is not tried again yet")

    def enter(self) -> None:
        """Check it again just before a command: while one client tries, the others do not.

        Raises:
            RedisConnectionError: Redis did not answer a moment ago.
        """
        with self._lock:
            self.check()
            if self._next_try is not None:
                self._next_try = time.monotonic() + _PAUSE

    def answered(self) -> None:
        """Redis answered, whatever it said."""
        self._next_try = None

    def timed_out(self) -> None:
        """Redis did not answer."""
        self._next_try = time.monotonic() + _PAUSE


class RedisAccess:
    """Runs functions that use Redis outside the event loop."""

    def __init__(self, threads: Threads, breaker: Breaker) -> None:
        self._threads = threads
        self._breaker = breaker

    async def __call__(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Run a function in a thread.

        Raises:
            RedisConnectionError: Redis did not answer a moment ago, and is not asked.
        """
        self._breaker.check()
        return await self._threads(lambda: self._ask(partial(function, *args, **kwargs)))

    def _ask(self, function: Callable[[], T]) -> T:
        self._breaker.enter()
        try:
            result = function()
        except RedisTimeoutError:
            self._breaker.timed_out()
            raise
        except RedisConnectionError:
            raise  # away, which is known at once
        except Exception:
            self._breaker.answered()
            raise
        self._breaker.answered()
        return result


class Refusals:
    """Logs what Redis refuses: one line, and the same again only after a while."""

    def __init__(self) -> None:
        self._logged: dict[str, float] = {}

    def log(self, error: Exception) -> None:
        """Log an error of Redis."""
        reason = str(error).rpartition("caused error: ")[2].partition(" script: ")[0]
        text = clipped(f"{type(error).__name__}: {reason}", 300)
        now = time.monotonic()
        if now - self._logged.get(text, -_QUIET) < _QUIET:
            return
        if len(self._logged) >= _REMEMBERED:
            self._logged.clear()
        self._logged[text] = now
        log.warning("Redis cannot be used (%s)", text)
