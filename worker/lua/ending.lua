-- How the parts of a job are counted, and how it ends; for scripts with the names record, chunks, bits, errors, events,
-- active, ends and job_id, and index where parts are counted.
-- include: jobs

-- Removes all that a job has.
local function remove_job()
    redis.call('DEL', record, chunks, bits, errors, events, items_of(record), questions_of(record), todo_of(record))
end

-- Ends a job; `done` is the number of its parts that are done, if it changes with that, and `fields` are those of
-- its record, if they were read. A batch that is being received is not known to anybody yet, and nothing of it stays.
local function finish(status, problem, ttl, done, fields)
    fields = fields or fields_of(record)
    if fields.receiving then
        retire(record, fields, active, job_id)
        remove_job()
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
    add_event(events, 'type', 'status', 'status', status)
    redis.call('EXPIRE', record, ttl)
    redis.call('EXPIRE', events, ttl)
    if is_batch or string.match(job_id, '^ct%-') then redis.call('EXPIRE', errors, ttl) end
    if is_batch then redis.call('EXPIRE', bits, ttl) end
end

-- Notes that the chunk has done the part `offset`, the last one of it or not.
local function advance(chunk, offset, is_last)
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

-- Counts parts that are done, and ends the job with the last one; `news` are the events of each.
-- Returns 1 if more parts remain, 2 if the job is done.
local function count_parts(chunk, news, job_ttl)
    local total, before, receiving, lane, left, apart = unpack(chunk.more)
    local done = tonumber(before)
    for _, event in ipairs(news) do
        done = done + 1
        for _, value in ipairs({'done', done, 'total', total}) do table.insert(event, value) end
        add_event(events, unpack(event))
    end
    if done < tonumber(total) or receiving then
        redis.call('HSET', record, 'done', done)
        count_work(record, active, chunk, #news, total - before, lane, left, apart)
        return 1
    end
    finish('succeeded', '', job_ttl, done)
    return 2
end
