-- Adds items to a batch that is being received, chunk by chunk in `todo`; those of them that are in no chunk have
-- failed. With the last ones the batch is complete, and others see it. Heavy chunks of a batch with short ones
-- join the heavy lane, as if they had been given back to it.
-- Returns {1, index of the first new chunk, their lane}; {0} if the batch is not received any more or items are
-- missing; {-1, milliseconds until the backlog is done} if its lane is full.
-- include: ending
-- keys: record chunks bits errors events active ends workers
-- args: job_id run total todo_count request ledger bytes kept_bytes chunk_count ttl lane work each max_backlog
-- args: deadline_s todo...

local fields = redis.call('HMGET', record, 'run', 'status', 'receiving', 'lane', 'chunk_count', 'total', 'each')
local its_run, status, receiving, its_lane, first, before, longest = unpack(fields)
if its_run ~= run or not is_active(status) or not receiving or redis.call('LLEN', items_of(record)) ~= tonumber(total) then
    return {0}
end
local is_heavy = lane == heavy_of(its_lane) and lane ~= its_lane
if not is_heavy then lane = its_lane end
local own = status == 'queued' and not is_heavy and 1 or 0
local wait = tonumber(todo_count) > 0 and wait_for_room(active, workers, lane, work, max_backlog, own)
if wait then return {-1, wait} end
local moved = is_heavy and math.max(1, math.floor(work / chunk_count)) or 0
for i, parts in ipairs(todo) do
    redis.call('RPUSH', todo_of(record), parts)
    local chunk = {state = 'queued', attempt = 0, horses = 0, workers = 0, offset = 0, moved = moved}
    put_chunk(chunks, first + i - 1, chunk)
end
mark_failed(bits, before, total, todo)
local failed = total - before - todo_count
local done = redis.call('HINCRBY', record, 'done', failed)
redis.call('HINCRBY', record, 'failed', failed)
redis.call('HINCRBY', record, 'chunk_count', chunk_count)
redis.call('HINCRBY', record, 'work', work)
redis.call('HSET', record, 'total', total, 'request', request, 'each', math.max(each, longest))
if ledger ~= '' then
    redis.call('HSET', record, 'ledger', ledger, 'bytes', bytes, 'kept_bytes', kept_bytes)
end
if is_heavy then
    redis.call('HINCRBY', record, 'moved', moved * chunk_count)
    redis.call('HINCRBY', record, 'apart', todo_count)
    add_work(active, lane, 'added', moved * chunk_count)
elseif tonumber(todo_count) > 0 then
    redis.call('HINCRBY', record, 'left', work)
    add_work(active, lane, 'added', work)
end
if deadline_s ~= '' then
    set_deadline(record, active, job_id, deadline_s)
    return {1, tonumber(first), lane}
end
redis.call('HDEL', record, 'receiving', 'deadline')
redis.call('ZREM', active .. ':deadlines', job_id)
keep_items(record)
list_job(active, job_id)
if done == tonumber(total) then
    finish('succeeded', '', ttl)
end
return {1, tonumber(first), lane}
