-- What a job that ends leaves for those who asked for a callback.
--
-- A callback is a field `call:URL` of the job's record. Each becomes a delivery: a hash with the state of the
-- job as it is then, an entry in the sorted set of deliveries by the time at which they are due, and one in the
-- list of the job's deliveries. The id of a delivery depends on the run and the URL only, so that asking twice
-- in one run delivers once.
-- include: now constants

local DELIVERY_TTL = 3 * 86400 -- longer than any pause between two attempts

-- Makes a delivery of the news that the job has ended; see `callbacks`. Once for each run and URL.
local function announce(record, ends, job_id, url)
    local due = string.gsub(ends, 'ends$', 'deliveries')
    local id = 'msg_' .. redis.sha1hex(redis.call('HGET', record, 'run') .. ' ' .. job_id .. ' ' .. url)
    local key, of_job = due .. ':' .. id, due .. '-of:' .. job_id
    if redis.call('EXISTS', key) == 1 then return end
    redis.call('HSET', key, 'id', id, 'job', job_id, 'url', url, 'state', 'pending', 'claims', 0, 'next', now)
    for _, name in ipairs(VIEW_FIELDS) do
        local value = redis.call('HGET', record, name)
        if value then redis.call('HSET', key, 'j:' .. name, value) end
    end
    redis.call('ZADD', due, now, id)
    redis.call('RPUSH', of_job, id)
    redis.call('LTRIM', of_job, -200, -1)
    for _, kept in ipairs({key, of_job}) do redis.call('EXPIRE', kept, DELIVERY_TTL) end
end

local function announce_to_all(record, fields, ends, job_id)
    for field in pairs(fields) do
        local url = string.match(field, '^call:(.*)$')
        if url then
            announce(record, ends, job_id, url)
            redis.call('HDEL', record, field)
        end
    end
end
