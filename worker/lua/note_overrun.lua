-- Notes that an attempt takes a few times its estimate, if that `is_new`. With `gives_back`, opens the next
-- attempt for the heavy lane, unless there is no worker for it or the chunk is in that lane already.
-- Returns {0}; with what was given back {1, the attempt's number, its lane}.
-- include: jobs
-- keys: record chunks events active ends workers
-- args: run index attempt job_id is_new gives_back

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return {0} end
local lane = redis.call('HGET', record, 'lane')
local is_given = gives_back == '1' and chunk.moved == 0 and lane ~= heavy_of(lane)
    and select(2, live_workers(workers)) > 0
if is_new == '1' then
    redis.call('HINCRBY', record, 'overruns', 1)
    add_event(events, 'type', 'status', 'status', 'running')
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
