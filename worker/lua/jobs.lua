-- What the steps of a job's life have in common.
--
-- A job's record has a token `run`, which changes whenever the job is restarted, and each of its chunks has the
-- number of its attempt. Every script that changes a job names its run and attempt, and has no effect if the
-- record has moved on or the job has ended; so a late caller (an old worker, a second sweeper) can never
-- overwrite a newer state.
--
-- A chunk's entry is `state:attempt:horses_lost:workers_lost:offset`; it is deleted when the chunk is done. The
-- slices before `offset` are done, and losses are counted since the last one was. The state is `queued`,
-- `running`, `solving` while it solves the slice `offset`, or `ahead` while it solves this or one of the next,
-- some of which are not kept yet. That of a chunk that was given back to the heavy lane has the milliseconds of
-- its work at its end; see `accounts`.
--
-- Beside the set of active jobs, and named after it, there are: `:queued`, the queued jobs by lane and age;
-- `:deadlines`, the jobs with a deadline by its time; `:work`, the accounts of the lanes.
-- include: now ends announcements kept accounts listing chunks

-- Adds an event to the stream of a job, of which about the newest 20000 stay; returns its id.
local function add_event(events, ...) return redis.call('XADD', events, 'MAXLEN', '~', 20000, '*', ...) end

-- Whether the request of a field `wait:TOKEN` still waits.
local function is_waiting(record, field)
    local till = redis.call('HGET', record, field)
    return till and tonumber(till) > tonumber(now)
end

local function is_wanted(record)
    for _, field in ipairs(redis.call('HKEYS', record)) do
        if string.find(field, '^by:') then return true end
        if string.find(field, '^wait:') and is_waiting(record, field) then return true end
    end
    return false
end

-- Returns the fields of a subscription.
local function subscription(name, token, seconds)
    if tonumber(seconds) <= 0 then return 'by:' .. name, now end
    return 'by:' .. name, now, 'wait:' .. token, string.format('%.3f', now + seconds)
end

local function subscribe(record, name, token, seconds)
    redis.call('HSET', record, subscription(name, token, seconds))
    if tonumber(seconds) <= 0 then redis.call('HDEL', record, 'wait:' .. token) end
end

local function set_deadline(record, active, job_id, seconds)
    local deadline = string.format('%.6f', now + seconds)
    redis.call('HSET', record, 'deadline', deadline)
    redis.call('ZADD', active .. ':deadlines', now + seconds, job_id)
    return deadline
end

-- Takes a job off the active ones. Once there is none, the lanes are counted anew, since Redis may have lost
-- records with work that is counted.
local function retire(record, fields, active, job_id)
    redis.call('ZREM', active, job_id)
    if fields.status ~= 'running' then redis.call('ZREM', active .. ':queued', job_id) end
    if fields.deadline or not fields.status then redis.call('ZREM', active .. ':deadlines', job_id) end
    if redis.call('EXISTS', active) == 0 then
        redis.call('DEL', active .. ':queued', active .. ':deadlines', active .. ':work')
    elseif is_active(fields.status) then
        drop_work(fields, active)
    end
    if fields.kept then redis.call('HDEL', record, 'kept') end
end

-- The list of a batch's items; no other job has one.
local function items_of(record) return record .. ':items' end

-- The list of those items of an active batch of which only a part is kept, as a whole; the others are empty.
local function questions_of(record) return record .. ':questions' end

-- The list of the parts that each chunk of an active job is to do, as JSON.
local function todo_of(record) return record .. ':todo' end

-- Keeps the items of a batch for as long as it is active.
local function keep_items(record)
    for _, key in ipairs({items_of(record), questions_of(record)}) do redis.call('PERSIST', key) end
end

-- Marks those items of a batch as done, from `first` on, that are in none of the chunks in `todo`: they failed.
local function mark_failed(bits, first, total, todo)
    local open = {}
    for _, parts in ipairs(todo) do
        for _, item in ipairs(cjson.decode(parts)) do open[tonumber(item)] = true end
    end
    for item = first, total - 1 do
        if not open[item] then redis.call('SETBIT', bits, item, 1) end
    end
end
