"""How much one client may hold: a number of active jobs, their estimated work, and bytes of questions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from redis import Redis
from redis.commands.core import Script

from worker.jobs import scripts
from worker.jobs.keys import Keys
from worker.settings import WorkerSettings

_GRACE = 5  # seconds from the admission of a job to its record, at most
_TTL = 7 * 86400

# The hash of a client has for each of its jobs the time and the milliseconds of work. Those that have ended
# are forgotten here, so that nothing else must know of quotas. Its ledger (see `kept`) has beside the bytes
# of ended jobs those of questions that come, until their job is made: `END:BYTES`.
_HELD = """
local client, ledger = unpack(KEYS)
local job_id, job_prefix, size, max_bytes, grace, ttl = unpack(ARGV)
size, max_bytes = tonumber(size), tonumber(max_bytes)

-- Returns the number of the client's other jobs, their milliseconds of work, and their bytes.
local function held_by_active()
    local jobs, work, bytes = 0, 0, 0
    local entries = redis.call('HGETALL', client)
    for i = 1, #entries, 2 do
        local since, its_work = string.match(entries[i + 1], '^(.*):(%d+)$')
        local status, its_ledger, its_bytes =
            unpack(redis.call('HMGET', job_prefix .. entries[i], 'status', 'ledger', 'bytes'))
        local is_over = not is_active(status)
        if is_over and now - since > tonumber(grace) then
            redis.call('HDEL', client, entries[i])
        elseif entries[i] ~= job_id then
            jobs, work = jobs + 1, work + its_work
            if not is_over and its_ledger == ledger then bytes = bytes + its_bytes end
        end
    end
    return jobs, work, bytes
end

-- Returns the bytes of questions that come, and of ended jobs, and when those go: {{time, bytes}, …}.
local function held_by_ledger()
    local bytes, due = 0, {}
    local entries = redis.call('HGETALL', ledger)
    for i = 1, #entries, 2 do
        local name, value = entries[i], entries[i + 1]
        local goes = tonumber(string.match(name, '^@(%d+)$') or string.match(value, '^(.*):'))
        if goes <= tonumber(now) or (string.sub(name, 1, 1) ~= '@'
                and redis.call('EXISTS', job_prefix .. name) == 1) then
            redis.call('HDEL', ledger, name)
        elseif name ~= job_id then
            value = tonumber(string.match(value, '(%d+)$'))
            bytes = bytes + value
            table.insert(due, {goes, value})
        end
    end
    return bytes, due
end

-- Returns the seconds until so many bytes have gone by themselves; 0 if active jobs must end before.
local function seconds_until_gone(due, excess)
    table.sort(due, function(a, b) return a[1] < b[1] end)
    for _, entry in ipairs(due) do
        excess = excess - entry[2]
        if excess <= 0 then return math.ceil(entry[1] - now) end
    end
    return 0
end

local jobs, held, bytes = held_by_active()
local kept, due = held_by_ledger()
bytes = bytes + kept
local function count_question(seconds)
    redis.call('HSET', ledger, job_id, string.format('%.3f:%d', now + seconds, size))
    live_for(ledger, seconds)
end
local function refusal_of_bytes()
    if max_bytes == 0 or bytes + size <= max_bytes then return nil end
    return {jobs, held, -1, bytes, seconds_until_gone(due, bytes + size - max_bytes)}
end
"""

# Returns {jobs, milliseconds} of the client's other jobs, and 1 if the job is admitted; 0 if these are too
# many; -1, the bytes that it keeps, and the seconds until there is room, if these are.
_ADMIT = (
    _HELD
    + """
local work, max_jobs, max_work = unpack(ARGV, 7)
work, max_jobs, max_work = tonumber(work), tonumber(max_jobs), tonumber(max_work)

local is_too_much = jobs > 0 and (
    (max_jobs > 0 and jobs >= max_jobs) or (max_work > 0 and held + work > max_work))
if is_too_much then return {jobs, held, 0} end
local refused = refusal_of_bytes()
if refused then return refused end
redis.call('HSET', client, job_id, now .. ':' .. work)
redis.call('EXPIRE', client, ttl)
if max_bytes > 0 then count_question(tonumber(grace)) end
return {jobs, held, 1}
"""
)

# The same for a question of which so much has come, and more will within so many seconds.
_RECEIVE = (
    _HELD
    + """
local refused = refusal_of_bytes()
if refused then return refused end
count_question(tonumber(ARGV[7]))
return {jobs, held, 1}
"""
)


@dataclass(frozen=True)
class Quota:
    """What a client may hold: a number of active jobs, seconds of their estimated work, and bytes of kept
    questions; 0 is no bound."""

    jobs: int = 0
    seconds: int = 0
    kept_bytes: int = 0


class QuotaError(Exception):
    """A client holds too much already.

    Attributes:
        jobs: the number of its active jobs.
        seconds: their estimated work.
        kept_bytes: the bytes of its questions, if these are too many.
        retry_s: the seconds until enough of them have expired; 0 if active jobs must end before.
    """

    def __init__(self, jobs: int, seconds: float, kept_bytes: int | None = None, retry_s: int = 0) -> None:
        self.jobs, self.seconds, self.kept_bytes, self.retry_s = jobs, seconds, kept_bytes, retry_s
        kept = "" if kept_bytes is None else f" and {kept_bytes} bytes of questions"
        super().__init__(f"the client has {jobs} active jobs with {seconds:.0f} s of work{kept}")


class Quotas:
    """What each client holds. It may always have one job, however long."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._admit = redis.register_script(scripts.PRELUDE + _ADMIT)
        self._receive = redis.register_script(scripts.PRELUDE + _RECEIVE)

    def admit(self, client: str, job_id: str, seconds: float, quota: Quota, size: int = 0) -> None:
        """Count a job, of so much estimated work and bytes, as one of the client's.

        Raises:
            QuotaError: it is more than its quota.
        """
        if quota.jobs or quota.seconds or quota.kept_bytes:
            more = int(1000 * seconds), quota.jobs, 1000 * quota.seconds
            self._ask(self._admit, client, job_id, size, quota, *more)

    def receive(self, client: str, job_id: str, size: int, quota: Quota, seconds: float) -> None:
        """Count a question of which so many bytes have come; more will within so many seconds.

        Raises:
            QuotaError: it is more than its quota.
        """
        if quota.kept_bytes:
            self._ask(self._receive, client, job_id, size, quota, seconds)

    def forget(self, client: str, job_id: str) -> None:
        """Count a job no longer as one of the client's."""
        self.redis.hdel(self.keys.client(client), job_id)

    def forget_received(self, client: str, job_id: str) -> None:
        """Count no longer what has come of a question."""
        self.redis.hdel(self.keys.kept(client), job_id)

    def _ask(self, script: Script, client: str, job_id: str, size: int, quota: Quota, *more: float) -> None:
        prefix = self.keys.job("").record
        jobs, work, outcome, *of_bytes = cast(
            "list[int]",
            script(
                keys=[self.keys.client(client), self.keys.kept(client)],
                args=[job_id, prefix, size, quota.kept_bytes, _GRACE, _TTL, *more],
            ),
        )
        if outcome != 1:
            raise QuotaError(jobs, work / 1000, *of_bytes)
