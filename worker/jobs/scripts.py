"""The atomic steps of a job's life, as Lua scripts.

A job's record has a token `run`, which changes whenever the job is restarted, and each of its chunks has the
number of its attempt. Every script that changes a job names its run and attempt, and has no effect if the
record has moved on or the job has ended; so a late caller (an old worker, a second sweeper) can never
overwrite a newer state.

A chunk's entry is `state:attempt:horses_lost:workers_lost:offset`; it is deleted when the chunk is done. The
slices before `offset` are done, and losses are counted since the last one was. The state is `queued`,
`running`, `solving` while it solves the slice `offset`, or `ahead` while it solves this or one of the next,
some of which are not kept yet. Entries of version 0.1.0 end after the first count. That of a chunk that was
given back to the heavy lane has the milliseconds of its work at its end; see `accounts`.

Beside the set of active jobs, and named after it, there are: `:queued`, the queued jobs by lane and age;
`:deadlines`, the jobs with a deadline by its time; `:work`, the accounts of the lanes.

Each script begins with the names of its keys and arguments, in the order in which `records` passes them.
"""

from __future__ import annotations

from worker.jobs.accounts import ACCOUNTS
from worker.jobs.announcements import ANNOUNCE
from worker.jobs.ends import COUNT_END
from worker.jobs.kept import KEPT
from worker.jobs.listing import LIST

_NOW = """
local time = redis.call('TIME')
local now = string.format('%d.%06d', time[1], time[2])
"""

_JOBS = """
local function is_active(status) return status == 'queued' or status == 'running' end

-- Returns the entry of a chunk if this attempt of this run is open, else nil.
local function open_chunk(record, chunks, run, index, attempt)
    local job_run, status = unpack(redis.call('HMGET', record, 'run', 'status'))
    if job_run ~= run or not is_active(status) then return nil end
    local state, open_attempt, horses, workers, offset, moved = string.match(
        redis.call('HGET', chunks, index) or '', '(%a+):(%d+):(%d+):?(%d*):?(%d*):?(%d*)')
    if open_attempt ~= attempt then return nil end
    return {state = state, attempt = attempt, horses = horses,
        workers = tonumber(workers) or 0, offset = tonumber(offset) or 0, moved = tonumber(moved) or 0}
end

local function put_chunk(chunks, index, chunk)
    redis.call('HSET', chunks, index, string.format('%s:%d:%d:%d:%d%s', chunk.state, chunk.attempt,
        chunk.horses, chunk.workers, chunk.offset, chunk.moved > 0 and ':' .. chunk.moved or ''))
end

-- Whether the request of a field `wait:TOKEN` still waits; see `subscriptions`.
local function is_waiting(record, field)
    local till = redis.call('HGET', record, field)
    return till and tonumber(till) > tonumber(now)
end

local function is_wanted(record)
    for _, field in ipairs(redis.call('HKEYS', record)) do
        if string.find(field, '^by:') then return true end
        if string.find(field, '^wait:') and is_waiting(record, field) then return true end
    end
    return false
end

local function subscribe(record, name, token, seconds)
    redis.call('HSET', record, 'by:' .. name, now)
    if tonumber(seconds) > 0 then
        redis.call('HSET', record, 'wait:' .. token, string.format('%.3f', now + seconds))
    else
        redis.call('HDEL', record, 'wait:' .. token)
    end
end

local function set_deadline(record, active, job_id, seconds)
    redis.call('HSET', record, 'deadline', string.format('%.6f', now + seconds))
    redis.call('ZADD', active .. ':deadlines', now + seconds, job_id)
end

-- Takes a job off the active ones. Once there is none, the lanes are counted anew, since Redis may have lost
-- records with work that is counted.
local function retire(record, active, job_id)
    for _, key in ipairs({active, active .. ':queued', active .. ':deadlines'}) do
        redis.call('ZREM', key, job_id)
    end
    if redis.call('EXISTS', active) == 0 then
        redis.call('DEL', active .. ':queued', active .. ':deadlines', active .. ':work')
    end
    drop_work(record, active)
end

-- The list of a batch's items; no other job has one.
local function items_of(record) return record .. ':items' end

-- The list of those items of an active batch of which only a part is kept, as a whole; the others are empty.
local function questions_of(record) return record .. ':questions' end

-- The list of the parts that each chunk of an active job is to do, as JSON.
local function todo_of(record) return record .. ':todo' end

local function finish(record, chunks, bits, errors, events, active, ends, job_id, status, problem, ttl)
    count_end(record, ends, job_id, status, problem)
    redis.call('HSET', record, 'status', status, 'finished', now, 'error', problem)
    retire(record, active, job_id)
    announce_to_all(record, ends, job_id)
    local kept = redis.call('HGET', record, 'kept')
    if kept then
        redis.call('HSET', record, 'request', kept)
        redis.call('HDEL', record, 'kept')
    end
    count_kept(record, ttl)
    redis.call('DEL', chunks, todo_of(record), questions_of(record))
    if redis.call('EXPIRE', items_of(record), ttl) == 0 then redis.call('DEL', bits) end
    redis.call('XADD', events, 'MAXLEN', '~', 20000, '*', 'type', 'status', 'status', status)
    for _, key in ipairs({record, bits, errors, events}) do redis.call('EXPIRE', key, ttl) end
end

-- Notes that the chunk has done the part `offset`, the last one of it or not.
local function advance(record, active, chunks, index, chunk, offset, is_last)
    if is_last then
        redis.call('HDEL', chunks, index)
        if chunk.moved > 0 then end_moved(record, active, chunk) end
    elseif tonumber(offset) >= chunk.offset then
        chunk.offset, chunk.horses, chunk.workers = offset + 1, 0, 0
        put_chunk(chunks, index, chunk)
    end
end

-- Counts parts that are done, and ends the job with the last one; `events` are what to tell of each.
-- Returns 1 if more parts remain, 2 if the job is done.
local function count_parts(record, chunks, bits, errors, stream, active, ends, job_id, job_ttl, chunk, events)
    local total, before = unpack(redis.call('HMGET', record, 'total', 'done'))
    local done = tonumber(before)
    for _, event in ipairs(events) do
        done = done + 1
        for _, value in ipairs({'done', done, 'total', total}) do table.insert(event, value) end
        redis.call('XADD', stream, 'MAXLEN', '~', 20000, '*', unpack(event))
    end
    redis.call('HSET', record, 'done', done)
    if done < tonumber(total) then
        count_work(record, active, chunk, #events, total - before)
        return 1
    end
    finish(record, chunks, bits, errors, stream, active, ends, job_id, 'succeeded', '', job_ttl)
    return 2
end
"""

PRELUDE = _NOW + COUNT_END + ANNOUNCE + KEPT + ACCOUNTS + LIST + _JOBS
"""The definitions that precede every script."""

# Returns {1, its event} if the job was created, {0} if another client has created or changed it meanwhile or
# items of a batch are missing, and {-1, milliseconds until the backlog is done} if its lane is full; one in
# which no job waits is never full. `asked` is the request without its slices, `kept` what stays of it at the
# end, empty if it stays whole; its bytes are counted in `ledger`, if there is one. The other arguments are
# the parts to do, chunk by chunk; the items of a batch that are none of them have failed.
CREATE = """
local record, chunks, bits, errors, events, active, ends, workers = unpack(KEYS)
local job_id, run, seen_run, total, todo_count, request, asked, kept = unpack(ARGV)
local ledger, bytes, kept_bytes, chunk_size, chunk_count, ttl, origin = unpack(ARGV, 9)
local lane, work, each, max_backlog, deadline_s, name, token, seconds = unpack(ARGV, 16)

local old_run, old_status = unpack(redis.call('HMGET', record, 'run', 'status'))
if old_run and (is_active(old_status) or old_run ~= seen_run) then return {0} end
local items = items_of(record)
local is_batch = string.match(job_id, '^ba%-') ~= nil
if is_batch and redis.call('LLEN', items) ~= tonumber(total) then return {0} end
local waiting, added = backlog(active, lane)
local count = workers_of(lane, workers)
if tonumber(todo_count) > 0 and waiting + work > max_backlog * count
        and redis.call('ZCOUNT', active .. ':queued', rank(lane, 0), rank(lane, 1e10 - 1)) > 0 then
    return {-1, math.ceil(waiting / count)}
end
release(unpack(counted(record)))
redis.call('DEL', record, chunks, bits, errors, events, todo_of(record))
redis.call('HSET', record, 'run', run, 'status', 'queued', 'total', total, 'done', total - todo_count,
    'request', request, 'asked', asked, 'chunk_size', chunk_size, 'chunk_count', chunk_count, 'created', now,
    'origin', origin, 'work', work, 'each', each)
if kept ~= '' then redis.call('HSET', record, 'kept', kept) end
list_job(active, job_id)
if name ~= '' then list_for(record, active, job_id, name) end
if ledger ~= '' then
    redis.call('HSET', record, 'ledger', ledger, 'bytes', bytes, 'kept_bytes', kept_bytes)
end
if is_batch then
    for _, key in ipairs({items, questions_of(record)}) do redis.call('PERSIST', key) end
    redis.call('HSET', record, 'failed', total - todo_count)
    local open = {}
    for i = 24, #ARGV do
        for _, item in ipairs(cjson.decode(ARGV[i])) do open[tonumber(item)] = true end
    end
    for item = 0, total - 1 do
        if not open[item] then redis.call('SETBIT', bits, item, 1) end
    end
end
if tonumber(todo_count) == 0 then
    redis.call('HSET', record, 'started', now)
    finish(record, chunks, bits, errors, events, active, ends, job_id, 'succeeded', '', ttl)
    return {1, ''}
end
for index = 0, chunk_count - 1 do
    redis.call('HSET', chunks, index, 'queued:0:0:0:0')
    redis.call('RPUSH', todo_of(record), ARGV[24 + index])
end
redis.call('ZADD', active, now, job_id)
redis.call('HSET', record, 'lane', lane, 'left', work, 'ahead', added)
redis.call('ZADD', active .. ':queued', rank(lane, now), job_id)
add_work(active, lane, 'added', work)
if deadline_s ~= '' then set_deadline(record, active, job_id, deadline_s) end
if name ~= '' then subscribe(record, name, token, seconds) end
return {1, redis.call('XADD', events, '*', 'type', 'status', 'status', 'queued')}
"""

# Returns 1 if the attempt is open.
BEAT = """
local record, chunks, beat, locks = unpack(KEYS)
local run, index, attempt, worker, ttl = unpack(ARGV)

redis.call('SET', beat, worker, 'PX', ttl)
for _, lock in ipairs(redis.call('SMEMBERS', locks)) do
    redis.call('PEXPIRE', lock, ttl)
    redis.call('PEXPIRE', locks, ttl)
end
return open_chunk(record, chunks, run, index, attempt) and 1 or 0
"""

# Records that nobody runs the attempt any more, frees the locks that it held, and deletes its RQ job.
# Returns 1 if the attempt is open.
END_BEAT = """
local record, chunks, beat, locks, rq_job = unpack(KEYS)
local run, index, attempt = unpack(ARGV)

redis.call('DEL', rq_job, beat, locks, unpack(redis.call('SMEMBERS', locks)))
return open_chunk(record, chunks, run, index, attempt) and 1 or 0
"""

# Starts a chunk, with a first heartbeat if there is a worker; `asking` is the field with its request.
# Returns {entry, parts, request, chunk_size, origin} if it may start, nothing if it is out of date.
START = """
local record, chunks, events, active, beat = unpack(KEYS)
local run, index, attempt, job_id, worker, ttl, asking = unpack(ARGV)

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return false end
if worker ~= '' then redis.call('SET', beat, worker, 'PX', ttl) end
chunk.state = 'running'
put_chunk(chunks, index, chunk)
if redis.call('HGET', record, 'status') == 'queued' then
    redis.call('HSET', record, 'status', 'running', 'started', now)
    redis.call('ZREM', active .. ':queued', job_id)
    redis.call('XADD', events, '*', 'type', 'status', 'status', 'running')
end
return {redis.call('HGET', chunks, index), redis.call('LINDEX', todo_of(record), index),
    unpack(redis.call('HMGET', record, asking, 'chunk_size', 'origin'))}
"""

# From now on the work horse, if it dies, dies of the slice `offset`, or in the state `ahead` maybe of a later
# one. Returns 0 if the attempt is out of date.
SOLVE = """
local record, chunks = unpack(KEYS)
local run, index, attempt, state = unpack(ARGV)

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return 0 end
chunk.state = state
put_chunk(chunks, index, chunk)
return 1
"""

# Records the progress of a job of one chunk that counts its own steps; after an interruption, only once the
# new attempt is as far as the last one. Returns 0 if the attempt is out of date.
PROGRESS = """
local record, chunks, events = unpack(KEYS)
local run, index, attempt, done, total = unpack(ARGV)

if not open_chunk(record, chunks, run, index, attempt) then return 0 end
if tonumber(done) < tonumber(redis.call('HGET', record, 'done')) then return 1 end
redis.call('HSET', record, 'done', done, 'total', total)
redis.call('XADD', events, 'MAXLEN', '~', 20000, '*', 'type', 'progress', 'done', done, 'total', total)
return 1
"""

# Keeps a document in any case, the first of several, and ends the job that requested it.
DOCUMENT = """
local document, record, chunks, bits, errors, events, active, ends = unpack(KEYS)
local job_id, run, index, attempt, json, document_ttl, job_ttl = unpack(ARGV)

if not redis.call('SET', document, json, 'EX', document_ttl, 'NX') then
    redis.call('EXPIRE', document, document_ttl)
end
if not open_chunk(record, chunks, run, index, attempt) then return 0 end
redis.call('HSET', record, 'done', redis.call('HGET', record, 'total'))
finish(record, chunks, bits, errors, events, active, ends, job_id, 'succeeded', '', job_ttl)
return 2
"""

# Ends a job: any run if `run` is empty (a cancel, or its deadline), otherwise only if that attempt of that
# chunk is open. With the status `unwanted` a job is canceled if no client wants it; with `overdue` it fails
# if its deadline is over.
# Returns the run and the open chunks {run, index, entry, …} if the job was ended, nothing otherwise.
END = """
local record, chunks, bits, errors, events, active, ends = unpack(KEYS)
local job_id, status, problem, ttl, run, index, attempt = unpack(ARGV)

local job_run, job_status = unpack(redis.call('HMGET', record, 'run', 'status'))
if not is_active(job_status) then return false end
if run ~= '' and not open_chunk(record, chunks, run, index, attempt) then return false end
if status == 'unwanted' then
    if is_wanted(record) then return false end
    status = 'canceled'
elseif status == 'overdue' then
    local deadline = redis.call('HGET', record, 'deadline')
    if not deadline or tonumber(now) < tonumber(deadline) then return false end
    status = 'failed'
end
local open = redis.call('HGETALL', chunks)
table.insert(open, 1, job_run)
finish(record, chunks, bits, errors, events, active, ends, job_id, status, problem, ttl)
return open
"""

# Opens the next attempt at a chunk; `lost` is 'horses', 'workers' or empty. A loss is counted only for a
# chunk that had started. One that was ahead is never lost too often, since it is not known by which slice.
# Returns the new attempt's number, -1 if the chunk is out of date, -2 if it was lost too often.
REOPEN = """
local record, chunks, ends = unpack(KEYS)
local run, index, attempt, lost, max_losses = unpack(ARGV)

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return -1 end
if lost ~= '' and chunk.state ~= 'queued' then
    redis.call('HINCRBY', ends, 'lost:' .. lost, 1)
    chunk[lost] = chunk[lost] + 1
    if chunk[lost] > tonumber(max_losses) and chunk.state ~= 'ahead' then return -2 end
end
chunk.state, chunk.attempt = 'queued', attempt + 1
put_chunk(chunks, index, chunk)
return chunk.attempt
"""

# Corrects the set of active jobs, and ends an active job that has no chunks and so could never end.
# Returns 1 if the job is active.
RECONCILE = """
local record, chunks, bits, errors, events, active, ends = unpack(KEYS)
local job_id, problem, ttl = unpack(ARGV)

local status = redis.call('HGET', record, 'status')
if not is_active(status) then
    retire(record, active, job_id)
    if not status then
        redis.call('DEL', chunks, bits, errors, events, items_of(record), questions_of(record),
            todo_of(record))
    end
    return 0
end
if redis.call('EXISTS', chunks) == 0 then
    finish(record, chunks, bits, errors, events, active, ends, job_id, 'failed', problem, ttl)
    return 0
end
redis.call('ZADD', active, 'NX', now, job_id)
return 1
"""
