-- Counts a job as one of a client's. The hash of a client has for each of its jobs the time and the milliseconds of
-- work; those that have ended are forgotten here, so that nothing else must know of quotas. A client may always have
-- one job.
-- Returns {jobs, milliseconds} of its other jobs, and 1 if the job is admitted.
-- include: now
-- keys: client
-- args: job_id job_prefix grace ttl work max_jobs max_work

local jobs, held = 0, 0
local entries = redis.call('HGETALL', client)
for i = 1, #entries, 2 do
    local since, its_work = string.match(entries[i + 1], '^(.*):(%d+)$')
    local status = redis.call('HGET', job_prefix .. entries[i], 'status')
    local is_over = status ~= 'queued' and status ~= 'running' and now - since > tonumber(grace)
    if is_over then
        redis.call('HDEL', client, entries[i])
    elseif entries[i] ~= job_id then
        jobs, held = jobs + 1, held + its_work
    end
end
max_jobs, max_work = tonumber(max_jobs), tonumber(max_work)
if jobs > 0 and ((max_jobs > 0 and jobs >= max_jobs) or (max_work > 0 and held + work > max_work)) then
    return {jobs, held, 0}
end
redis.call('HSET', client, job_id, now .. ':' .. work)
redis.call('EXPIRE', client, ttl)
return {jobs, held, 1}
