"""Connections to Redis, with timeouts for both the API and the workers."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import urlsplit

from redis import Redis
from redis.backoff import ExponentialBackoff, NoBackoff
from redis.connection import SSLConnection
from redis.exceptions import RedisError
from redis.exceptions import TimeoutError as RedisTimeoutError
from redis.retry import Retry

SOCKET_TIMEOUT = 20.0
"""Seconds; longer than any blocking command, and the time after which a dead server is noticed."""


_TLS_TIMEOUT = 4.0  # a server without TLS waits for ever for the end of what it takes for a command


class UnreachableError(Exception):
    """Nobody answers at the address; the message is for the user, and has no password in it."""


def connect(url: str, *, max_connections: int = 256) -> Redis:
    """Return a client for `url` (`redis://`, `rediss://` or `unix://`); connects at first use.

    Raises:
        ValueError: the address cannot be understood.
    """
    _check_address(url)
    over_network: dict[str, Any] = {"socket_connect_timeout": 3.0, "socket_keepalive": True}
    return Redis.from_url(
        url,
        max_connections=max_connections,
        socket_timeout=SOCKET_TIMEOUT,
        protocol=2,
        driver_info=None,  # looking up the client's own version costs a millisecond per connection
        **({} if url.startswith("unix:") else over_network),
        retry=Retry(ExponentialBackoff(cap=0.5, base=0.02), 3),
    )


def check(url: str) -> None:
    """Have the server at `url` answer once.

    Raises:
        UnreachableError: it does not, or the address cannot be understood.
    """
    try:
        with connect(url) as redis:
            if url.startswith("rediss:"):
                redis.connection_pool.connection_kwargs["socket_timeout"] = _TLS_TIMEOUT
                redis.connection_pool.connection_kwargs["retry"] = Retry(NoBackoff(), 0)
            redis.ping()
    except (RedisError, ValueError) as error:
        no_tls = isinstance(error, RedisTimeoutError) or "WRONG_VERSION_NUMBER" in str(error)
        hint = "; perhaps it speaks no TLS, then the address begins with redis://"
        raise UnreachableError(
            f"cannot reach Redis: {error}{hint if url.startswith('rediss:') and no_tls else ''}"
        ) from error


def address(redis: Redis) -> str:
    """Where a client connects to, without user and password."""
    options = redis.connection_pool.connection_kwargs
    if "path" in options:
        return f"unix://{options['path']}?db={options.get('db', 0)}"
    scheme = "rediss" if issubclass(redis.connection_pool.connection_class, SSLConnection) else "redis"
    host = str(options.get("host", "localhost"))
    host = f"[{host}]" if ":" in host else host
    return f"{scheme}://{host}:{options.get('port', 6379)}/{options.get('db', 0)}"


def _check_address(url: str) -> None:
    """Refuse what redis-py would misread in silence, or quote with a part of the password."""
    try:
        parts = urlsplit(url)
        _ = parts.port
    except ValueError:
        raise ValueError(
            "the address is not of the form redis://[user:password@]host[:port][/database]; in a password "
            "/ is written %2F, # %23 and ? %3F"
        ) from None
    if parts.scheme in ("redis", "rediss") and not re.fullmatch(r"/?[0-9]*", parts.path):
        raise ValueError("the database in the address must be a number, as in redis://127.0.0.1:6379/0")
