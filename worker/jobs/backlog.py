"""The places of jobs in the queue, as the scripts count them."""

from __future__ import annotations

from typing import cast

from redis import Redis

from worker.jobs import scripts
from worker.jobs.keys import Keys
from worker.jobs.lanes import Place
from worker.settings import WorkerSettings

# Returns the number of jobs before a queued job in its lane, and the milliseconds that the work before it
# takes its workers; nothing if the job is not queued.
_PLACE = """
local record, active, workers = unpack(KEYS)
local job_id = ARGV[1]

local own = redis.call('ZSCORE', active .. ':queued', job_id)
local lane, ahead = unpack(redis.call('HMGET', record, 'lane', 'ahead'))
if not own or not ahead then return false end
local before = redis.call('ZCOUNT', active .. ':queued', rank(lane, 0), '(' .. own)
local _, added = backlog(active, lane)
local done = redis.call('HGET', active .. ':work', lane .. ':done') or 0
return {before, math.ceil(math.max(0, math.min(ahead, added) - done) / workers_of(lane, workers))}
"""


class Backlog:
    """The places of jobs in the queue."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._place = redis.register_script(scripts.PRELUDE + _PLACE)

    def place(self, job_id: str) -> Place | None:
        """Returns the place of a job in its lane, or None if it is not queued."""
        reply = cast(
            "list[int] | None",
            self._place(
                keys=[self.keys.job(job_id).record, self.keys.active, self.keys.workers], args=[job_id]
            ),
        )
        return Place(reply[0], reply[1] / 1000) if reply else None
