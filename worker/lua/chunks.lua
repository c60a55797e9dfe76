-- The entries of a job's chunks, and the fields of its record; see `jobs`. This needs no clock.

local function is_active(status) return status == 'queued' or status == 'running' end

-- Returns all fields of a job's record.
local function fields_of(record)
    local fields, flat = {}, redis.call('HGETALL', record)
    for i = 1, #flat, 2 do fields[flat[i]] = flat[i + 1] end
    return fields
end

-- Returns the entry of a chunk if this attempt of this run is open, by the run and the status of the record,
-- else nil.
local function chunk_of(job_run, status, chunks, run, index, attempt)
    if job_run ~= run or not is_active(status) then return nil end
    local state, open_attempt, horses, workers, offset, moved = string.match(
        redis.call('HGET', chunks, index) or '', '(%a+):(%d+):(%d+):(%d+):(%d+):?(%d*)')
    if open_attempt ~= attempt then return nil end
    return {state = state, attempt = attempt, horses = horses, job_status = status,
        workers = workers, offset = tonumber(offset), moved = tonumber(moved) or 0}
end

-- The same; `more` are further fields of the record that it is to have.
local function open_chunk(record, chunks, run, index, attempt, ...)
    local more = redis.call('HMGET', record, 'run', 'status', ...)
    local job_run, status = table.remove(more, 1), table.remove(more, 1)
    local chunk = chunk_of(job_run, status, chunks, run, index, attempt)
    if chunk then chunk.more = more end
    return chunk
end

-- Returns the entry as it is kept.
local function put_chunk(chunks, index, chunk)
    local entry = string.format('%s:%d:%d:%d:%d%s', chunk.state, chunk.attempt,
        chunk.horses, chunk.workers, chunk.offset, chunk.moved > 0 and ':' .. chunk.moved or '')
    redis.call('HSET', chunks, index, entry)
    return entry
end
