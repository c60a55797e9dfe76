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

-- Removes all that a job has.
local function remove_job(record, chunks, bits, errors, events)
    redis.call('DEL', record, chunks, bits, errors, events, items_of(record), questions_of(record), todo_of(record))
end

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

-- Ends a job; `done` is the number of its parts that are done, if it changes with that, and `fields` are those of
-- its record, if they were read. Of a batch that is being received nobody knows yet, and nothing stays.
local function finish(record, chunks, bits, errors, events, active, ends, job_id, status, problem, ttl, done, fields)
    fields = fields or fields_of(record)
    if fields.receiving then
        retire(record, fields, active, job_id)
        remove_job(record, chunks, bits, errors, events)
        return
    end
    count_end(fields, ends, job_id, status, problem)
    local values = count_kept(fields, ttl)
    if done == 'all' then done = fields.total end
    local set = {status = status, finished = now, error = problem, request = fields.kept or nil, done = done}
    for name, value in pairs(set) do
        table.insert(values, name)
        table.insert(values, value)
    end
    redis.call('HSET', record, unpack(values))
    retire(record, fields, active, job_id)
    announce_to_all(record, fields, ends, job_id)
    local is_batch = string.match(job_id, '^ba%-')
    local has_items = is_batch and redis.call('EXPIRE', items_of(record), ttl) == 1
    redis.call('DEL', chunks, todo_of(record), questions_of(record), has_items and chunks or bits)
    redis.call('XADD', events, 'MAXLEN', '~', 20000, '*', 'type', 'status', 'status', status)
    redis.call('EXPIRE', record, ttl)
    redis.call('EXPIRE', events, ttl)
    if is_batch or string.match(job_id, '^ct%-') then redis.call('EXPIRE', errors, ttl) end
    if is_batch then redis.call('EXPIRE', bits, ttl) end
end

-- Notes that the chunk has done the part `offset`, the last one of it or not.
local function advance(record, active, chunks, index, chunk, offset, is_last)
    if is_last then
        redis.call('HDEL', chunks, index)
        if chunk.moved > 0 then end_moved(record, active, chunk) end
    elseif tonumber(offset) >= chunk.offset then
        chunk.offset, chunk.horses, chunk.workers = offset + 1, 0, 0
        put_chunk(chunks, index, chunk)
    end
end

-- The fields of a record that `count_parts` needs; its chunk has them as `more`.
local COUNTED = {'total', 'done', 'receiving', 'lane', 'left', 'apart'}

-- Counts parts that are done, and ends the job with the last one; `events` are what to tell of each.
-- Returns 1 if more parts remain, 2 if the job is done.
local function count_parts(record, chunks, bits, errors, stream, active, ends, job_id, job_ttl, chunk, events)
    local total, before, receiving, lane, left, apart = unpack(chunk.more)
    local done = tonumber(before)
    for _, event in ipairs(events) do
        done = done + 1
        for _, value in ipairs({'done', done, 'total', total}) do table.insert(event, value) end
        redis.call('XADD', stream, 'MAXLEN', '~', 20000, '*', unpack(event))
    end
    if done < tonumber(total) or receiving then
        redis.call('HSET', record, 'done', done)
        count_work(record, active, chunk, #events, total - before, lane, left, apart)
        return 1
    end
    finish(record, chunks, bits, errors, stream, active, ends, job_id, 'succeeded', '', job_ttl, done)
    return 2
end
