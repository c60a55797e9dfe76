"""Connections to Redis, with timeouts for both the API and the workers."""

from __future__ import annotations

from typing import Any

from redis import Redis
from redis.backoff import ExponentialBackoff
from redis.retry import Retry

SOCKET_TIMEOUT = 20.0
"""Seconds; longer than any blocking command, and the time after which a dead server is noticed."""


def connect(url: str, *, max_connections: int = 256) -> Redis:
    """Return a client for `url` (`redis://`, `rediss://` or `unix://`); connects at first use."""
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
