"""Who wants a job. It is canceled only when the last of them no longer does.

A subscription is a field of the job's record: `by:KEY` for a client with a key, `by:ADDRESS#TOKEN` for one of
which only the network address is known; its value is the time. A request that waits for the job has a field
`wait:TOKEN` with the time at which it stops waiting, so that what other requests of its client withdraw does
not end it, and a process that died does not keep it.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field

from redis import Redis

from worker.jobs import scripts
from worker.jobs.keys import Keys
from worker.settings import WorkerSettings

MANY = 1000
"""Fields of a record, of which a dozen are its own; clients beyond that are one that never withdraws."""

_MARGIN = 10.0  # seconds, until a request that has stopped waiting has said so

# Returns 1 if the job is active, so that the subscription counts.
_SUBSCRIBE = """
local record, active = unpack(KEYS)
local job_id, name, token, seconds, many = unpack(ARGV)

local status = redis.call('HGET', record, 'status')
if status then list_for(record, active, job_id, name) end
if not is_active(status) then return 0 end
local is_one_more = redis.call('HEXISTS', record, 'by:' .. name) == 0
if is_one_more and redis.call('HLEN', record) >= tonumber(many) then name = 'many' end
subscribe(record, name, token, seconds)
return 1
"""

# Withdraws the subscription `name`; or the one with `token`, of whatever address; or, if both are empty, the
# newest one of `address` whose request no longer waits.
_WITHDRAW = """
local record = KEYS[1]
local name, address, token = unpack(ARGV)

local newest, newest_since = nil, -1
for _, field in ipairs(redis.call('HKEYS', record)) do
    local whose, its_token = string.match(field, '^by:([^#]*)#?(.*)$')
    if whose and name ~= '' then
        if field == 'by:' .. name then redis.call('HDEL', record, field) end
    elseif whose and token ~= '' then
        if its_token == token then redis.call('HDEL', record, field, 'wait:' .. token) end
    elseif whose == address and not is_waiting(record, 'wait:' .. its_token) then
        local since = tonumber(redis.call('HGET', record, field))
        if since > newest_since then newest, newest_since = field, since end
    end
end
if newest then redis.call('HDEL', record, newest) end
"""


@dataclass(frozen=True)
class Subscriber:
    """A client that wants a job.

    Attributes:
        client: its key, or its network address.
        is_known: whether that distinguishes it from all others, as a key does.
        token: distinguishes its request; on withdrawing, the request that is meant, or empty.
    """

    client: str
    is_known: bool
    token: str = field(default_factory=lambda: secrets.token_hex(12))

    @property
    def name(self) -> str:
        """The name of its subscription."""
        return self.client if self.is_known else f"{self.client}#{self.token}"


@dataclass(frozen=True)
class Subscription:
    """A client, and the seconds from now for which its request waits."""

    who: Subscriber
    seconds: float = 0.0

    @property
    def arguments(self) -> tuple[str, str, float]:
        """Returns what the scripts take."""
        return self.who.name, self.who.token, self.seconds + _MARGIN if self.seconds > 0 else 0


class Subscriptions:
    """The clients of jobs."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._subscribe = redis.register_script(scripts.PRELUDE + _SUBSCRIBE)
        self._withdraw = redis.register_script(scripts.PRELUDE + _WITHDRAW)

    def add(self, job_id: str, who: Subscriber, seconds: float = 0.0) -> bool:
        """Subscribe a client whose request waits `seconds` from now; returns False if the job has ended.

        A request that waited and goes without the answer subscribes again, with 0 seconds.
        """
        args = (job_id, *Subscription(who, seconds).arguments, MANY)
        return bool(self._subscribe(keys=[self.keys.job(job_id).record, self.keys.active], args=args))

    def leave(self, job_id: str, who: Subscriber) -> None:
        """Note that the request of a client waits no longer; a subscription it has not withdrawn stays."""
        self.redis.hdel(self.keys.job(job_id).record, f"wait:{who.token}")

    def withdraw(self, job_id: str, who: Subscriber) -> None:
        """Withdraw the subscription of a client.

        Of a client that is not known, without a token, it is the newest of its address that does not wait.
        """
        args = (who.client, "", "") if who.is_known else ("", who.client, who.token)
        self._withdraw(keys=[self.keys.job(job_id).record], args=args)
