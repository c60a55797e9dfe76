"""Who is to be told of the end of a job, and the deliveries of that news; see `announcements`.

Whoever claims a delivery takes a lease: its entry moves to the time at which another may claim it, so that a
delivery survives those who make it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Literal, cast
from urllib.parse import urlsplit

from redis import Redis

from worker.jobs import scripts
from worker.jobs.announcements import DELIVERY_TTL
from worker.jobs.keys import Keys
from worker.jobs.views import JobView, iso, job_view
from worker.settings import WorkerSettings

MANY = 100
"""Callbacks of one job, at most."""

_READY_SECONDS = 60
"""After which a delivery that waits for its host's turn is looked at again, in case that turn was lost."""

_MANY_AT_ONCE = 1000

State = Literal["pending", "delivered", "gone", "refused", "exhausted"]
"""How a delivery stands: `gone` if the receiver answered 410, `refused` if its address is not allowed,
`exhausted` after the last attempt."""

# Returns 1 if the callback is kept or its delivery is due, 0 if there is no such job, -1 if it has too many.
_ADD = """
local record, ends = unpack(KEYS)
local job_id, url, many = unpack(ARGV)

local status = redis.call('HGET', record, 'status')
if not status then return 0 end
if not is_active(status) then
    announce(record, ends, job_id, url)
    return 1
end
if redis.call('HEXISTS', record, 'call:' .. url) == 1 then return 1 end
local count = 0
for _, field in ipairs(redis.call('HKEYS', record)) do
    if string.find(field, '^call:') then count = count + 1 end
end
if count >= tonumber(many) then return -1 end
redis.call('HSET', record, 'call:' .. url, now)
return 1
"""

# Returns the fields of a delivery that is due, and leases it; nothing if none is.
#
# What is due goes into the sorted set of its host first, so that a host that must wait holds up no other: the
# hosts take turns, the one that was served longest ago first. There it waits under a lease too, so that a set
# that is lost, or a process of an older version, changes nothing. The arguments after `many` are the names of
# hosts that must wait, or `*.` and what they end with.
_CLAIM = """
local due = KEYS[1]
local lease, waits, many = unpack(ARGV)
local hosts = due .. '-hosts'

for _, id in ipairs(redis.call('ZRANGEBYSCORE', due, '-inf', now, 'LIMIT', 0, many)) do
    local url = redis.call('HGET', due .. ':' .. id, 'url')
    if url then
        local authority = string.lower(string.match(url, '^%a+://([^/?#]*)') or '')
        local host = string.match(authority, '^%[(.*)%]') or string.match(authority, '^[^:]*')
        redis.call('ZADD', due .. '-to:' .. host, 'NX', now, id)
        redis.call('ZADD', hosts, 'NX', now, host)
        redis.call('ZADD', due, now + waits, id)
    else
        redis.call('ZREM', due, id)
    end
end

local function must_wait(host)
    for i = 4, #ARGV do
        local name = ARGV[i]
        if name == host then return true end
        if string.sub(name, 1, 1) == '*' and string.sub(host, 1 - #name) == string.sub(name, 2) then
            redis.call('ZADD', hosts, now, host)
            return true
        end
    end
    return false
end

for _, host in ipairs(redis.call('ZRANGEBYSCORE', hosts, '-inf', now, 'LIMIT', 0, many)) do
    local ready = due .. '-to:' .. host
    while not must_wait(host) do
        local id = redis.call('ZRANGE', ready, 0, 0)[1]
        if not id then
            redis.call('ZREM', hosts, host)
            break
        end
        redis.call('ZREM', ready, id)
        local key = due .. ':' .. id
        if redis.call('ZSCORE', due, id) and redis.call('EXISTS', key) == 1 then
            redis.call('ZADD', hosts, now, host)
            redis.call('ZADD', due, now + lease, id)
            local claim = redis.call('HINCRBY', key, 'claims', 1)
            redis.call('HSET', key, 'attempt:' .. claim, string.format('{"at":%s}', now))
            redis.call('HSET', key, 'next', string.format('%.3f', now + lease))
            return redis.call('HGETALL', key)
        end
    end
end
return false
"""

# Notes the outcome of an attempt; no effect if another has claimed the delivery meanwhile.
_SETTLE = """
local due, counts = unpack(KEYS)
local id, claim, state, delay, entry, ttl, host, rest = unpack(ARGV)

if host then redis.call('ZADD', due .. '-hosts', now + rest, host) end
local key = due .. ':' .. id
if redis.call('HGET', key, 'claims') ~= claim then return 0 end
redis.call('HSET', key, 'attempt:' .. claim, entry, 'state', state)
redis.call('EXPIRE', key, ttl)
if state == 'pending' then
    redis.call('ZADD', due, now + delay, id)
    redis.call('HSET', key, 'next', string.format('%.3f', now + delay))
else
    redis.call('ZREM', due, id)
    redis.call('HDEL', key, 'next')
end
redis.call('HINCRBY', counts, state, 1)
return 1
"""


class TooManyCallbacksError(Exception):
    """A job has as many callbacks as it may have."""


@dataclass(frozen=True)
class Attempt:
    """One attempt at a delivery.

    Attributes:
        at: when it began, in seconds since 1970.
        status: the HTTP status of the answer, if one came.
        problem: why it did not succeed; None if it did, or its end is not known.
        is_over: whether its end is known; it is not while it lasts, or if its process died.
    """

    at: float
    status: int | None = None
    problem: str | None = None
    is_over: bool = True

    @property
    def at_iso(self) -> str:
        """When it began, in ISO 8601."""
        return iso(self.at)

    def to_json(self) -> str:
        """Returns it as it is kept."""
        return json.dumps({"at": self.at, "status": self.status, "problem": self.problem})


@dataclass(frozen=True)
class Delivery:
    """The news of one end of a job for one receiver.

    Attributes:
        id: the same at every attempt.
        url: where it goes.
        state: how it stands.
        claim: the number of attempts that were begun, also of the one that a claim has begun.
        next_at: when the next attempt is due, ISO 8601; None if there is none.
        job: the job as it ended.
        attempts: those so far.
    """

    id: str
    url: str
    state: State
    claim: int
    next_at: str | None
    job: JobView
    attempts: tuple[Attempt, ...]

    @property
    def host(self) -> str:
        """The name of its receiver, as it takes turns with others."""
        with suppress(ValueError):
            return urlsplit(self.url).hostname or ""
        return ""


class Callbacks:
    """The callbacks of an installation and their deliveries. Instances are cheap, and safe for threads."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._add = redis.register_script(scripts.PRELUDE + _ADD)
        self._claim = redis.register_script(scripts.PRELUDE + _CLAIM)
        self._settle = redis.register_script(scripts.PRELUDE + _SETTLE)

    def add(self, job_id: str, url: str) -> None:
        """Have a URL called when a job ends; at once if it has ended.

        Raises:
            TooManyCallbacksError: the job has too many.
        """
        keys = [self.keys.job(job_id).record, self.keys.ends]
        if self._add(keys=keys, args=[job_id, url, MANY]) == -1:
            raise TooManyCallbacksError(job_id)

    def claim(self, lease: float, must_wait: Iterable[str] = ()) -> Delivery | None:
        """Begin an attempt at a delivery that is due; nobody else does for `lease` seconds.

        Args:
            lease: how long.
            must_wait: hosts whose deliveries are passed over: their names, or `*.` and what names end with.
        """
        reply = self._claim(
            keys=[self.keys.deliveries], args=[lease, _READY_SECONDS, _MANY_AT_ONCE, *must_wait]
        )
        return _delivery(dict(zip(reply[::2], reply[1::2], strict=True))) if reply else None

    def settle(
        self, delivery: Delivery, state: State, attempt: Attempt, delay: float = 0.0, rest: float = 0.0
    ) -> bool:
        """Note how an attempt ended; the next one is due in `delay` seconds if it is still pending.

        Args:
            delivery, state, attempt, delay: as said.
            rest: how long no other delivery goes to this host, in seconds.

        Returns False if the lease was over and another attempt has begun.
        """
        args: list[str | float] = [delivery.id, delivery.claim, state, delay, attempt.to_json(), DELIVERY_TTL]
        if rest:
            args += [delivery.host, rest]
        return bool(self._settle(keys=[self.keys.deliveries, self.keys.delivery_counts], args=args))

    def of_job(self, job_id: str) -> list[Delivery]:
        """Returns the deliveries of a job, the oldest first, as long as they are kept."""
        ids = cast("list[bytes]", self.redis.lrange(self.keys.deliveries_of(job_id), 0, -1))
        with self.redis.pipeline(transaction=False) as pipe:
            for raw in ids:
                pipe.hgetall(self.keys.delivery(raw.decode()))
            return [_delivery(fields) for fields in pipe.execute() if fields]


def _delivery(raw: Mapping[bytes, bytes]) -> Delivery:
    fields = {name.decode(): value.decode() for name, value in raw.items()}
    claim = int(fields["claims"])
    texts = (fields.get(f"attempt:{number}") for number in range(1, claim + 1))
    return Delivery(
        id=fields["id"],
        url=fields["url"],
        state=cast(State, fields["state"]),
        claim=claim,
        next_at=iso(float(fields["next"])) if "next" in fields else None,
        job=job_view(fields["job"], {name[2:]: text for name, text in fields.items() if name[:2] == "j:"}),
        attempts=tuple(_attempt(json.loads(text)) for text in texts if text),
    )


def _attempt(kept: Mapping[str, object]) -> Attempt:
    return Attempt(
        at=cast(float, kept["at"]),
        status=cast("int | None", kept.get("status")),
        problem=cast("str | None", kept.get("problem")),
        is_over="status" in kept,
    )
