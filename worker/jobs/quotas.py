"""How much of the queue one client may hold: the number of its active jobs, and their estimated work."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from redis import Redis

from worker.jobs import scripts
from worker.jobs.keys import Keys
from worker.settings import WorkerSettings

_GRACE = 5  # seconds from the admission of a job to its record, at most
_TTL = 7 * 86400

# The hash of a client has for each of its jobs the time and the milliseconds of work. Those that have ended
# are forgotten here, so that nothing else must know of quotas.
# Returns {jobs, milliseconds} of the client's other jobs, and 1 if the job is admitted.
_ADMIT = """
local client = KEYS[1]
local job_id, work, max_jobs, max_work, job_prefix, grace, ttl = unpack(ARGV)
work, max_jobs, max_work = tonumber(work), tonumber(max_jobs), tonumber(max_work)

local jobs, held = 0, 0
local entries = redis.call('HGETALL', client)
for i = 1, #entries, 2 do
    local since, its_work = string.match(entries[i + 1], '^(.*):(%d+)$')
    local is_over = not is_active(redis.call('HGET', job_prefix .. entries[i], 'status'))
    if is_over and now - since > tonumber(grace) then
        redis.call('HDEL', client, entries[i])
    elseif entries[i] ~= job_id then
        jobs, held = jobs + 1, held + its_work
    end
end
local is_too_much = jobs > 0 and (
    (max_jobs > 0 and jobs >= max_jobs) or (max_work > 0 and held + work > max_work))
if is_too_much then return {jobs, held, 0} end
redis.call('HSET', client, job_id, now .. ':' .. work)
redis.call('EXPIRE', client, ttl)
return {jobs, held, 1}
"""


@dataclass(frozen=True)
class Quota:
    """What a client may hold: a number of active jobs, and seconds of estimated work; 0 is no bound."""

    jobs: int = 0
    seconds: int = 0


class QuotaError(Exception):
    """A client holds too much already.

    Attributes:
        jobs: the number of its active jobs.
        seconds: their estimated work.
    """

    def __init__(self, jobs: int, seconds: float) -> None:
        self.jobs, self.seconds = jobs, seconds
        super().__init__(f"the client has {jobs} active jobs with {seconds:.0f} s of work")


class Quotas:
    """The jobs of each client. A client may always have one, however large."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._admit = redis.register_script(scripts.PRELUDE + _ADMIT)

    def admit(self, client: str, job_id: str, seconds: float, quota: Quota) -> None:
        """Count a job, of so much estimated work, as one of the client's.

        Raises:
            QuotaError: it is more than its quota.
        """
        if not (quota.jobs or quota.seconds):
            return
        prefix = self.keys.job("").record
        reply = self._admit(
            keys=[self.keys.client(client)],
            args=[
                job_id, int(1000 * seconds), quota.jobs, 1000 * quota.seconds, prefix, _GRACE, _TTL,
            ],
        )  # fmt: skip
        jobs, work, is_admitted = cast("list[int]", reply)
        if not is_admitted:
            raise QuotaError(jobs, work / 1000)

    def forget(self, client: str, job_id: str) -> None:
        """Count a job no longer as one of the client's."""
        self.redis.hdel(self.keys.client(client), job_id)
