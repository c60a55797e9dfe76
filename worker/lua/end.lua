-- Ends a job: any run if `run` is empty (a cancel, or its deadline), otherwise only if that attempt of that
-- chunk is open. With the status `unwanted` a job is canceled if no client wants it; with `overdue` it fails
-- if its deadline is over. A search that has found something is asked to stop when it is canceled, and ended
-- when it is canceled again.
-- Returns the run and the open chunks {run, index, entry, …} if the job was ended, nothing otherwise.
-- include: ending
-- keys: record chunks bits errors events active ends
-- args: job_id status problem ttl run index attempt

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
if status == 'canceled' and redis.call('HEXISTS', record, 'improved') == 1
        and redis.call('HSETNX', record, 'stopping', now) == 1 then
    return false
end
local open = redis.call('HGETALL', chunks)
table.insert(open, 1, job_run)
finish(status, problem, ttl)
return open
