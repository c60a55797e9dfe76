-- Starts a chunk, with a first heartbeat if there is a worker; `asking` is the field with its request.
-- Returns {entry, parts, request, chunk_size, origin} if it may start, nothing if it is out of date.
-- include: jobs
-- keys: record chunks events active beat rq_job
-- args: run index attempt job_id worker ttl asking

redis.call('DEL', rq_job) -- a worker that dies from now on leaves none behind
local chunk = open_chunk(record, chunks, run, index, attempt, asking, 'chunk_size', 'origin')
if not chunk then return false end
if worker ~= '' then redis.call('SET', beat, worker, 'PX', ttl) end
chunk.state = 'running'
local entry = put_chunk(chunks, index, chunk)
if chunk.job_status == 'queued' then
    redis.call('HSET', record, 'status', 'running', 'started', now)
    redis.call('ZREM', active .. ':queued', job_id)
    add_event(events, 'type', 'status', 'status', 'running')
end
return {entry, redis.call('LINDEX', todo_of(record), index), unpack(chunk.more, 1, 3)}
