"""Chunks that take a few times their estimate: noted in their jobs, and given back to the heavy lane.

A worker that is kept for short work gives such a chunk back, once, to a lane from which it takes nothing. The
chunk's next attempt goes on where this one was, and no loss is counted.
"""

from __future__ import annotations

from typing import cast

from redis import Redis

from worker.jobs import scripts
from worker.jobs.attempts import ChunkRef
from worker.jobs.keys import Keys
from worker.jobs.lanes import Lane
from worker.settings import WorkerSettings

# Notes that an attempt takes a few times its estimate, if that `is_new`. With `gives_back`, opens the next
# attempt for the heavy lane, unless there is no worker for it or the chunk is in that lane already.
# Returns {0}; with what was given back {1, the attempt's number, its lane}.
_OVERRUN = """
local record, chunks, events, active, ends, workers = unpack(KEYS)
local run, index, attempt, job_id, is_new, gives_back = unpack(ARGV)

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return {0} end
local lane = redis.call('HGET', record, 'lane')
local is_given = gives_back == '1' and chunk.moved == 0 and lane ~= heavy_of(lane)
    and select(2, live_workers(workers)) > 0
if is_new == '1' then
    redis.call('HINCRBY', record, 'overruns', 1)
    redis.call('XADD', events, 'MAXLEN', '~', 20000, '*', 'type', 'status', 'status', 'running')
end
if is_new == '1' or is_given then
    local kind, what = string.match(job_id, '^%a+') or '', is_given and 'given-back' or 'left'
    redis.call('HINCRBY', ends, table.concat({'overruns', kind, what}, ':'), 1)
end
if not is_given then return {0} end
local parts = #cjson.decode(redis.call('LINDEX', todo_of(record), index) or '[]') - chunk.offset
move_work(record, active, chunk, math.max(1, parts))
chunk.state, chunk.attempt = 'queued', attempt + 1
put_chunk(chunks, index, chunk)
return {1, chunk.attempt, heavy_of(lane)}
"""


class Overruns:
    """The chunks that take a few times their estimate."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.keys = Keys.of(settings)
        self._overrun = redis.register_script(scripts.PRELUDE + _OVERRUN)

    def note(self, ref: ChunkRef, *, is_new: bool, gives_back: bool) -> tuple[ChunkRef, Lane] | None:
        """Note that an attempt has overrun, the first time if it `is_new`.

        Returns the next attempt and its lane if this one is to be given back, which its worker then ends.
        """
        keys = self.keys.job(ref.job_id)
        reply = self._overrun(
            keys=[
                *(keys.record, keys.chunks, keys.events),
                *(self.keys.active, self.keys.ends, self.keys.workers),
            ],
            args=[ref.run, ref.index, ref.attempt, ref.job_id, int(is_new), int(gives_back)],
        )
        if not reply[0]:
            return None
        return ChunkRef(ref.job_id, ref.run, ref.index, int(reply[1])), cast(Lane, reply[2].decode())
