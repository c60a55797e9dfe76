-- Returns {jobs, milliseconds} of the client's other jobs, and 1 if the job is admitted; 0 if these are too
-- many; -1, the bytes that it keeps, and the seconds until there is room, if these are.
-- include: quotas
-- keys: client ledger
-- args: job_id job_prefix size max_bytes grace ttl work max_jobs max_work

work, max_jobs, max_work = tonumber(work), tonumber(max_jobs), tonumber(max_work)

local is_too_much = jobs > 0 and (
    (max_jobs > 0 and jobs >= max_jobs) or (max_work > 0 and held + work > max_work))
if is_too_much then return {jobs, held, 0} end
local refused = refusal_of_bytes()
if refused then return refused end
redis.call('HSET', client, job_id, now .. ':' .. work)
redis.call('EXPIRE', client, ttl)
if max_bytes > 0 then count_question(tonumber(grace)) end
return {jobs, held, 1}
