-- How jobs ended, counted in one hash for the whole installation; see `Ends` in `worker.jobs`.
-- include: now constants

local function interval(seconds)
    for i, bound in ipairs(DURATION_BOUNDS) do if seconds <= bound then return i - 1 end end
    return #DURATION_BOUNDS
end

-- Counts a job that ends now, by the fields of its record; one that never ran has no RUN.
local function count_end(fields, ends, job_id, status, problem)
    local created, started = fields.created, fields.started
    if not created then return end
    local kind = string.match(job_id, '^%a+') or ''
    local reason = status == 'failed' and cjson.decode(problem).type or ''
    local wait, run = (started or now) - created, ''
    if started then
        run = interval(now - started)
        redis.call('HINCRBYFLOAT', ends, 'run:' .. kind, now - started)
    end
    redis.call('HINCRBYFLOAT', ends, 'wait:' .. kind, wait)
    redis.call('HINCRBY', ends, table.concat({'n', kind, status, reason, interval(wait), run}, ':'), 1)
end
