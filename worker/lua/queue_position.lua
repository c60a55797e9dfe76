-- Returns the number of jobs before a queued job in its lane, and the milliseconds that the work before it
-- takes its workers; nothing if the job is not queued.
-- include: accounts
-- keys: record active workers
-- args: job_id

local own = redis.call('ZSCORE', active .. ':queued', job_id)
local lane, ahead = unpack(redis.call('HMGET', record, 'lane', 'ahead'))
if not own or not ahead then return false end
local before = redis.call('ZCOUNT', active .. ':queued', rank(lane, 0), '(' .. own)
local _, added = backlog(active, lane)
local done = redis.call('HGET', active .. ':work', lane .. ':done') or 0
return {before, math.ceil(math.max(0, math.min(ahead, added) - done) / workers_of(lane, workers))}
