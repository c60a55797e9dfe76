"""Deadlines of jobs, as their clients give them."""

from __future__ import annotations

from typing import cast

from redis import Redis

from worker.jobs import scripts
from worker.jobs.keys import Keys
from worker.settings import WorkerSettings

# Gives an active job the deadline of one more client; the latest counts, and none is the latest of all.
_EXTEND = """
local record, active = unpack(KEYS)
local job_id, deadline_s = unpack(ARGV)

local status, deadline = unpack(redis.call('HMGET', record, 'status', 'deadline'))
if not is_active(status) or not deadline then return end
if deadline_s == '' then
    redis.call('HDEL', record, 'deadline')
    redis.call('ZREM', active .. ':deadlines', job_id)
elseif now + deadline_s > tonumber(deadline) then
    set_deadline(record, active, job_id, deadline_s)
end
"""


class Deadlines:
    """The deadlines of active jobs; `JobRecords.create` sets the first one."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._extend = redis.register_script(scripts.PRELUDE + _EXTEND)

    def extend(self, job_id: str, seconds: float | None) -> None:
        """Give an active job the deadline of one more client; the latest counts, and None is none."""
        self._extend(
            keys=[self.keys.job(job_id).record, self.keys.active],
            args=[job_id, "" if seconds is None else seconds],
        )

    def over(self) -> list[str]:
        """Returns the active jobs whose deadline is over."""
        seconds, micros = self.redis.time()
        late = self.redis.zrangebyscore(self.keys.deadlines, "-inf", seconds + micros / 1e6)
        return [raw.decode() for raw in cast("list[bytes]", late)]
