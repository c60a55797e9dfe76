-- What the steps of a job's life have in common.
--
-- A record has a token `run`, which changes whenever the job is started anew, and a `status`, which is set to its
-- last value once. What is done is a bit for each part, so a part may be computed any number of times.
--
-- The hash `:work`, named after the set of active jobs, has the milliseconds of estimated work that each lane was
-- given (`LANE:added`) and that are done or dropped (`LANE:done`); a record has the `work` of its job, and what is
-- `left` of it.
-- include: now ends announcements

local function is_active(status) return status == 'queued' or status == 'running' end

-- Adds an event to the stream of a job, of which about the newest 20000 stay; returns its id.
local function add_event(events, ...) return redis.call('XADD', events, 'MAXLEN', '~', 20000, '*', ...) end

local function fields_of(record)
    local fields, flat = {}, redis.call('HGETALL', record)
    for i = 1, #flat, 2 do fields[flat[i]] = flat[i + 1] end
    return fields
end

-- Takes a job off the active ones. With the last one all accounts end, since Redis may have lost records whose work
-- they count.
local function retire(fields, active, job_id)
    redis.call('ZREM', active, job_id)
    redis.call('ZREM', active .. ':queued:' .. fields.lane, job_id)
    redis.call('ZREM', active .. ':deadlines', job_id)
    if redis.call('EXISTS', active) == 0 then
        redis.call('DEL', active .. ':work')
    else
        redis.call('HINCRBY', active .. ':work', fields.lane .. ':done', fields.left)
    end
end

-- Ends a job: `keys` are its own. `problem` is empty unless it failed; then the question is kept whole, so that its
-- chunks can be requeued.
local function finish(keys, active, ends, job_id, status, problem, ttl)
    local fields = fields_of(keys.record)
    count_end(fields, ends, job_id, status, problem)
    redis.call('HSET', keys.record, 'status', status, 'finished', now, 'error', problem)
    if status ~= 'failed' and fields.kept then redis.call('HSET', keys.record, 'request', fields.kept) end
    redis.call('HDEL', keys.record, 'left', 'kept')
    retire(fields, active, job_id)
    announce_to_all(keys.record, fields, ends, job_id)
    redis.call('DEL', keys.chunks, keys.wanted)
    add_event(keys.events, 'type', 'status', 'status', status)
    for _, key in ipairs({keys.record, keys.events, keys.bits, keys.errors, keys.items}) do
        redis.call('EXPIRE', key, ttl)
    end
end
