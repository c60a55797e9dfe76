-- Returns 1 if the job is active, so that the subscription counts.
-- include: jobs
-- keys: record active
-- args: job_id name token seconds limit

local status = redis.call('HGET', record, 'status')
if status then list_for(record, active, job_id, name) end
if not is_active(status) then return 0 end
local is_one_more = redis.call('HEXISTS', record, 'by:' .. name) == 0
if is_one_more and redis.call('HLEN', record) >= tonumber(limit) then name = 'many' end
subscribe(record, name, token, seconds)
return 1
