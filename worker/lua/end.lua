-- Ends a job, if this `run` of it is active (any, if empty): with the status `unwanted` it is canceled if no key
-- wants it, with `overdue` it fails if its deadline is over, with `stopped` it has succeeded with an answer of its
-- own (`problem` is then the hash of this). A search that has found something is asked to stop when it is canceled,
-- and ended when it is canceled again.
-- Returns 1 if it has ended the job.
-- include: jobs
-- keys: record chunks bits errors events items wanted active ends
-- args: job_id run status problem ttl

local job_run, job_status, deadline, total = unpack(redis.call('HMGET', record, 'run', 'status', 'deadline', 'total'))
if not is_active(job_status) or (run ~= '' and run ~= job_run) then return 0 end
if status == 'unwanted' then
    if redis.call('EXISTS', wanted) == 1 then return 0 end
    status = 'canceled'
elseif status == 'overdue' then
    if not deadline or tonumber(now) < tonumber(deadline) then return 0 end
    status = 'failed'
elseif status == 'stopped' then
    redis.call('HSET', record, 'stopped', problem)
    status, problem = 'succeeded', ''
elseif status == 'succeeded' then
    redis.call('HSET', record, 'done', total)
end
if status == 'canceled' and redis.call('HEXISTS', record, 'improved') == 1
        and redis.call('HSETNX', record, 'stopping', now) == 1 then
    return 0
end
finish({record = record, chunks = chunks, bits = bits, errors = errors, events = events, items = items,
    wanted = wanted}, active, ends, job_id, status, problem, ttl)
return 1
