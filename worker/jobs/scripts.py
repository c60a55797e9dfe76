"""The atomic steps of a job's life, as Lua scripts.

A job's record carries `run`, a token that changes whenever the job is started afresh. Every script that
changes a job names the run it means and does nothing when the record has moved on or is terminal; so what
comes late (an old worker, a second sweeper) can never overwrite a newer state.

A chunk's entry is `state:attempt:losses`; it is deleted when the chunk is done.
"""

from __future__ import annotations

_NOW = """
local time = redis.call('TIME')
local now = string.format('%d.%06d', time[1], time[2])
"""

_FINISH = """
local function finish(record, chunks, bits, errors, events, active, job_id, status, problem, ttl)
    redis.call('HSET', record, 'status', status, 'finished', now, 'error', problem)
    redis.call('ZREM', active, job_id)
    redis.call('HDEL', record, 'todo')
    redis.call('DEL', chunks, bits)
    redis.call('XADD', events, 'MAXLEN', '~', 20000, '*', 'type', 'status', 'status', status)
    for _, key in ipairs({record, errors, events}) do redis.call('EXPIRE', key, ttl) end
end
"""

# KEYS: record chunks bits errors events active
# ARGV: job_id run seen_run total todo_count request todo chunk_size chunk_count ttl
# Returns 1 when the job was made, 0 when somebody else has made or changed it meanwhile.
CREATE = (
    _NOW
    + _FINISH
    + """
local old = redis.call('HMGET', KEYS[1], 'run', 'status')
if old[1] and (old[2] == 'queued' or old[2] == 'running' or old[1] ~= ARGV[3]) then return 0 end
redis.call('DEL', KEYS[1], KEYS[2], KEYS[3], KEYS[4], KEYS[5])
local todo = tonumber(ARGV[5])
redis.call('HSET', KEYS[1], 'run', ARGV[2], 'status', 'queued', 'total', ARGV[4],
    'done', tonumber(ARGV[4]) - todo, 'request', ARGV[6], 'todo', ARGV[7], 'chunk_size', ARGV[8],
    'chunk_count', ARGV[9], 'created', now)
if todo == 0 then
    redis.call('HSET', KEYS[1], 'started', now)
    finish(KEYS[1], KEYS[2], KEYS[3], KEYS[4], KEYS[5], KEYS[6], ARGV[1], 'succeeded', '', ARGV[10])
    return 1
end
for index = 0, tonumber(ARGV[9]) - 1 do redis.call('HSET', KEYS[2], index, 'queued:0:0') end
redis.call('ZADD', KEYS[6], now, ARGV[1])
redis.call('XADD', KEYS[5], '*', 'type', 'status', 'status', 'queued')
return 1
"""
)

# KEYS: record chunks events    ARGV: run index attempt
# Returns {request, todo, chunk_size} when the chunk may start, nothing when it is out of date.
START = (
    _NOW
    + """
local job = redis.call('HMGET', KEYS[1], 'run', 'status', 'request', 'todo', 'chunk_size')
if job[1] ~= ARGV[1] or (job[2] ~= 'queued' and job[2] ~= 'running') then return false end
local chunk = redis.call('HGET', KEYS[2], ARGV[2])
if not chunk then return false end
local state, attempt, losses = string.match(chunk, '(%a+):(%d+):(%d+)')
if attempt ~= ARGV[3] then return false end
redis.call('HSET', KEYS[2], ARGV[2], 'running:' .. attempt .. ':' .. losses)
if job[2] == 'queued' then
    redis.call('HSET', KEYS[1], 'status', 'running', 'started', now)
    redis.call('XADD', KEYS[3], '*', 'type', 'status', 'status', 'running')
end
return {job[3], job[4], job[5]}
"""
)

# KEYS: slice digits record chunks bits errors events active
# ARGV: job_id run index last position l1 json is_error digits slice_ttl job_ttl
# Keeps the result in any case (it is true whatever became of the job), then counts it once.
# Returns 0 when the job does not want it any more, 1 when there is more to do, 2 when the job is done.
SLICE = (
    _NOW
    + _FINISH
    + """
local is_error = ARGV[8] == '1'
if not redis.call('SET', KEYS[1], ARGV[7], 'EX', ARGV[10], 'NX') and not is_error then
    redis.call('EXPIRE', KEYS[1], ARGV[10])
end
if not is_error then
    redis.call('SADD', KEYS[2], ARGV[9])
    redis.call('EXPIRE', KEYS[2], ARGV[10])
end
local job = redis.call('HMGET', KEYS[3], 'run', 'status', 'total')
if job[1] ~= ARGV[2] or (job[2] ~= 'queued' and job[2] ~= 'running') then return 0 end
if is_error then redis.call('HSET', KEYS[6], ARGV[6], ARGV[7]) end
if ARGV[4] == '1' then redis.call('HDEL', KEYS[4], ARGV[3]) end
if redis.call('SETBIT', KEYS[5], ARGV[5], 1) == 1 then return 1 end
local done = redis.call('HINCRBY', KEYS[3], 'done', 1)
redis.call('XADD', KEYS[7], 'MAXLEN', '~', 20000, '*', 'type', 'slice', 'l1', ARGV[6], 'done', done,
    'total', job[3])
if done < tonumber(job[3]) then return 1 end
finish(KEYS[3], KEYS[4], KEYS[5], KEYS[6], KEYS[7], KEYS[8], ARGV[1], 'succeeded', '', ARGV[11])
return 2
"""
)

# KEYS: record events    ARGV: run done total
# How far a job of one chunk is that counts its own steps. It may start over after an interruption.
PROGRESS = """
local job = redis.call('HMGET', KEYS[1], 'run', 'status')
if job[1] ~= ARGV[1] or job[2] ~= 'running' then return 0 end
redis.call('HSET', KEYS[1], 'done', ARGV[2], 'total', ARGV[3])
redis.call('XADD', KEYS[2], 'MAXLEN', '~', 20000, '*', 'type', 'progress', 'done', ARGV[2], 'total', ARGV[3])
return 1
"""

# KEYS: document record chunks bits errors events active    ARGV: job_id run json document_ttl job_ttl
# Keeps a document in any case, the first one if there are several, and ends the job that asked for it.
DOCUMENT = (
    _NOW
    + _FINISH
    + """
if not redis.call('SET', KEYS[1], ARGV[3], 'EX', ARGV[4], 'NX') then
    redis.call('EXPIRE', KEYS[1], ARGV[4])
end
local job = redis.call('HMGET', KEYS[2], 'run', 'status', 'total')
if job[1] ~= ARGV[2] or (job[2] ~= 'queued' and job[2] ~= 'running') then return 0 end
redis.call('HSET', KEYS[2], 'done', job[3])
finish(KEYS[2], KEYS[3], KEYS[4], KEYS[5], KEYS[6], KEYS[7], ARGV[1], 'succeeded', '', ARGV[5])
return 2
"""
)

# KEYS: record chunks bits errors events active
# ARGV: job_id status problem ttl run index attempt
# With an empty run: whatever the run is (a cancel). Otherwise only if that attempt of that chunk is open.
# Returns the run and the open chunks {run, index, entry, …} when the job was ended, nothing otherwise.
END = (
    _NOW
    + _FINISH
    + """
local job = redis.call('HMGET', KEYS[1], 'run', 'status')
if job[2] ~= 'queued' and job[2] ~= 'running' then return false end
if ARGV[5] ~= '' then
    local chunk = redis.call('HGET', KEYS[2], ARGV[6])
    if job[1] ~= ARGV[5] or not chunk or string.match(chunk, ':(%d+):') ~= ARGV[7] then return false end
end
local open = redis.call('HGETALL', KEYS[2])
table.insert(open, 1, job[1])
finish(KEYS[1], KEYS[2], KEYS[3], KEYS[4], KEYS[5], KEYS[6], ARGV[1], ARGV[2], ARGV[3], ARGV[4])
return open
"""
)

# KEYS: record chunks    ARGV: run index attempt lost max_losses
# Opens the next attempt of a chunk. A loss is counted only for a chunk that had begun.
# Returns the new attempt's number, -1 when it is out of date, -2 when it was lost too often.
REOPEN = """
local job = redis.call('HMGET', KEYS[1], 'run', 'status')
if job[1] ~= ARGV[1] or (job[2] ~= 'queued' and job[2] ~= 'running') then return -1 end
local chunk = redis.call('HGET', KEYS[2], ARGV[2])
if not chunk then return -1 end
local state, attempt, losses = string.match(chunk, '(%a+):(%d+):(%d+)')
if attempt ~= ARGV[3] then return -1 end
if ARGV[4] == '1' and state == 'running' then losses = losses + 1 end
if tonumber(losses) > tonumber(ARGV[5]) then return -2 end
attempt = attempt + 1
redis.call('HSET', KEYS[2], ARGV[2], string.format('queued:%d:%d', attempt, losses))
return attempt
"""
