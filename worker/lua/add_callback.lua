-- Returns 1 if the callback is kept or its delivery is due, 0 if there is no such job, -1 if it has too many.
-- include: jobs
-- keys: record ends
-- args: job_id url limit

local status = redis.call('HGET', record, 'status')
if not status then return 0 end
if not is_active(status) then
    announce(record, ends, job_id, url)
    return 1
end
if redis.call('HEXISTS', record, 'call:' .. url) == 1 then return 1 end
local count = 0
for _, field in ipairs(redis.call('HKEYS', record)) do
    if string.find(field, '^call:') then count = count + 1 end
end
if count >= tonumber(limit) then return -1 end
redis.call('HSET', record, 'call:' .. url, now)
return 1
