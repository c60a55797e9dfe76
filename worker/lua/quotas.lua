-- What a client holds; for scripts with the names client, ledger, job_id, job_prefix, size, max_bytes and grace.
--
-- The hash of a client has for each of its jobs the time and the milliseconds of work. Those that have ended
-- are forgotten here, so that nothing else must know of quotas. Its ledger (see `kept`) has beside the bytes
-- of ended jobs those of questions that come, until their job is made: `END:BYTES`.
-- include: jobs

size, max_bytes = tonumber(size), tonumber(max_bytes)

-- Returns the number of the client's other jobs, their milliseconds of work, and their bytes.
local function held_by_active()
    local jobs, work, bytes = 0, 0, 0
    local entries = redis.call('HGETALL', client)
    for i = 1, #entries, 2 do
        local since, its_work = string.match(entries[i + 1], '^(.*):(%d+)$')
        local status, its_ledger, its_bytes =
            unpack(redis.call('HMGET', job_prefix .. entries[i], 'status', 'ledger', 'bytes'))
        local is_over = not is_active(status)
        if is_over and now - since > tonumber(grace) then
            redis.call('HDEL', client, entries[i])
        elseif entries[i] ~= job_id then
            jobs, work = jobs + 1, work + its_work
            if not is_over and its_ledger == ledger then bytes = bytes + its_bytes end
        end
    end
    return jobs, work, bytes
end

-- Returns the bytes of questions that come, and of ended jobs, and when those go: {{time, bytes}, …}.
local function held_by_ledger()
    local bytes, due = 0, {}
    local entries = redis.call('HGETALL', ledger)
    for i = 1, #entries, 2 do
        local name, value = entries[i], entries[i + 1]
        local goes = tonumber(string.match(name, '^@(%d+)$') or string.match(value, '^(.*):'))
        if goes <= tonumber(now) or (string.sub(name, 1, 1) ~= '@'
                and redis.call('EXISTS', job_prefix .. name) == 1) then
            redis.call('HDEL', ledger, name)
        elseif name ~= job_id then
            value = tonumber(string.match(value, '(%d+)$'))
            bytes = bytes + value
            table.insert(due, {goes, value})
        end
    end
    return bytes, due
end

-- Returns the seconds until `excess` bytes have expired; 0 if active jobs must end before.
local function seconds_until_gone(due, excess)
    table.sort(due, function(a, b) return a[1] < b[1] end)
    for _, entry in ipairs(due) do
        excess = excess - entry[2]
        if excess <= 0 then return math.ceil(entry[1] - now) end
    end
    return 0
end

local jobs, held, bytes = held_by_active()
local kept, due = held_by_ledger()
bytes = bytes + kept
local function count_question(seconds)
    redis.call('HSET', ledger, job_id, string.format('%.3f:%d', now + seconds, size))
    live_for(ledger, seconds)
end
local function refusal_of_bytes()
    if max_bytes == 0 or bytes + size <= max_bytes then return nil end
    return {jobs, held, -1, bytes, seconds_until_gone(due, bytes + size - max_bytes)}
end
