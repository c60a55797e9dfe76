"""How many requests a caller may send: an allowance that refills evenly, one for all processes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

from redis import Redis

WINDOW = 60
"""Seconds in which an empty allowance is full again."""

# The generic cell rate algorithm. The key has the time at which the allowance is full again.
# Returns whether the request is allowed, the milliseconds until one is, and until the allowance is full.
_TAKE = """
local key, limit, window = KEYS[1], tonumber(ARGV[1]), tonumber(ARGV[2])

local time = redis.call('TIME')
local now = time[1] + time[2] / 1e6
local full = math.max(now, tonumber(redis.call('GET', key) or 0)) + window / limit
local wait = full - now - window
if wait > 1e-6 then return {0, math.ceil(wait * 1000), math.ceil((window + wait - window / limit) * 1000)} end
redis.call('SET', key, string.format('%.6f', full), 'PX', math.ceil((full - now) * 1000))
return {1, 0, math.ceil((full - now) * 1000)}
"""


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
        self._take = redis.register_script(_TAKE)

    def take(self, caller_id: str) -> Allowance:
        """Take one request from the allowance of a caller."""
        key = f"{self._prefix}:rate:{caller_id}"
        allowed, retry_ms, full_ms = cast("list[int]", self._take(keys=[key], args=[self.limit, WINDOW]))
        return Allowance(self.limit, not allowed, retry_ms / 1000, full_ms / 1000)
