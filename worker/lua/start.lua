-- Begins an attempt. Returns {whether it counts, status, request, origin, bits, its chunk's entry}; nothing if there is no record. It
-- does not count if the job has ended, or was started anew; what it computes is then kept all the same.
-- include: jobs
-- keys: record chunks bits events active
-- args: job_id run index

local job_run, status, request, origin, lane =
    unpack(redis.call('HMGET', record, 'run', 'status', 'request', 'origin', 'lane'))
if not request then return false end
local counts = job_run == run and is_active(status)
if counts and status == 'queued' then
    redis.call('HSET', record, 'status', 'running', 'started', now)
    redis.call('ZREM', active .. ':queued:' .. lane, job_id)
    add_event(events, 'type', 'status', 'status', 'running')
end
return {counts and 1 or 0, status, request, origin or '', redis.call('GET', bits) or '',
    redis.call('HGET', chunks, index) or ''}
