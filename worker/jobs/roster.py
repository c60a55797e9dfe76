"""The workers that are alive, by what they say themselves.

Each worker says so again and again, so the roster is soon right after a crash, or after Redis was emptied.
"""

from __future__ import annotations

from typing import cast

from redis import Redis

from worker.jobs.keys import Keys
from worker.settings import WorkerSettings

_IDLE_WAIT = 1.0  # seconds that an idle worker lets pass between two beats, at most

# Light workers are in a second set too, so that the workers of heavy chunks can be counted.
# The score of a worker is the time, in milliseconds by the clock of Redis, at which it counts as gone.
_BEAT = """
local workers = KEYS[1]
local name, ttl, is_light = unpack(ARGV)

local time = redis.call('TIME')
local now = time[1] * 1000 + math.floor(time[2] / 1000)
for _, key in ipairs({workers, is_light == '1' and workers .. ':light' or nil}) do
    redis.call('ZADD', key, now + ttl, name)
    redis.call('ZREMRANGEBYSCORE', key, '-inf', now)
    redis.call('PEXPIRE', key, ttl)
end
"""

# Fails if a worker's beat would fail too, for example because Redis is out of memory.
_SILENCES = """
local workers, probe = unpack(KEYS)
local ttl = ARGV[1]

local time = redis.call('TIME')
local now = time[1] * 1000 + math.floor(time[2] / 1000)
redis.call('SET', probe, now, 'PX', ttl)
local silences = {}
local entries = redis.call('ZRANGE', workers, 0, -1, 'WITHSCORES')
for i = 1, #entries, 2 do
    silences[i] = entries[i]
    silences[i + 1] = now + ttl - tonumber(entries[i + 1])
end
return silences
"""


class Roster:
    """The workers of this version of the solver."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.key = Keys.of(settings).workers
        self._ttl = int((settings.beat_ttl + _IDLE_WAIT) * 1000)
        self._beat = redis.register_script(_BEAT)
        self._silences = redis.register_script(_SILENCES)

    def beat(self, name: str, *, is_light: bool = False) -> None:
        """Say that the worker `name` is alive, and whether it takes short chunks only."""
        self._beat(keys=[self.key], args=[name, self._ttl, int(is_light)])

    def age(self, score: float, now: float) -> float:
        """The seconds since the last beat of a worker with this score."""
        return max(0.0, now - (score - self._ttl) / 1000)

    def leave(self, name: str) -> None:
        """Say that the worker `name` ends."""
        for key in (self.key, f"{self.key}:light"):
            self.redis.zrem(key, name)

    def names(self) -> set[str]:
        """The workers that are alive."""
        return self._alive(self.key)

    def light(self) -> set[str]:
        """Those of them that take short chunks only."""
        return self._alive(f"{self.key}:light")

    def _alive(self, key: str) -> set[str]:
        seconds, micros = self.redis.time()
        names = self.redis.zrangebyscore(key, f"({seconds * 1000 + micros // 1000}", "+inf")
        return {name.decode() for name in cast("list[bytes]", names)}

    def silences(self) -> dict[str, float]:
        """The seconds since each worker's last beat. Raises an error if beats are not possible."""
        keys = [self.key, f"{self.key}:probe"]
        entries = cast("list[bytes | int]", self._silences(keys=keys, args=[self._ttl]))
        return {
            cast(bytes, name).decode(): max(0, cast(int, age)) / 1000
            for name, age in zip(entries[::2], entries[1::2], strict=True)
        }
