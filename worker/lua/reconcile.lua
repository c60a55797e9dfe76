-- Corrects the set of active jobs, and ends an active job that has no chunks and so could never end.
-- Returns 1 if the job is active.
-- include: ending
-- keys: record chunks bits errors events active ends
-- args: job_id problem ttl

local status = redis.call('HGET', record, 'status')
if not is_active(status) then
    retire(record, fields_of(record), active, job_id)
    if not status then remove_job() end
    return 0
end
if redis.call('EXISTS', chunks) == 0 and redis.call('HEXISTS', record, 'receiving') == 0 then
    finish('failed', problem, ttl)
    return 0
end
redis.call('ZADD', active, 'NX', now, job_id)
return 1
