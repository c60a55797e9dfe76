-- Counts parts of a job whose answers are kept, each once; with the last one the job has succeeded. `parts` has five
-- values for each: its position, its name in events, what is kept in the hash of errors (or nothing), whether it
-- failed, and of a long item what is kept in its place (or nothing). Every part that an event tells of is of the type
-- `of`: `slice` or `item`.
-- Returns 0 if the job has ended or was started anew, 1 if more parts remain, 2 if it is done.
-- include: jobs
-- keys: record chunks bits errors events items wanted active ends
-- args: job_id run index is_last of ttl parts...

local job_run, status, total, before, left, lane =
    unpack(redis.call('HMGET', record, 'run', 'status', 'total', 'done', 'left', 'lane'))
if job_run ~= run or not is_active(status) then return 0 end
local done = tonumber(before)
for i = 1, #parts, 5 do
    local position, name, outcome, is_failed, kept = unpack(parts, i, i + 4)
    if redis.call('SETBIT', bits, position, 1) == 0 then
        done = done + 1
        if outcome ~= '' then redis.call('HSET', errors, name, outcome) end
        if is_failed == '1' then redis.call('HINCRBY', record, 'failed', 1) end
        if kept ~= '' and redis.call('LLEN', items) > tonumber(position) then
            redis.call('LSET', items, position, kept)
        end
        if of == 'slice' then
            add_event(events, 'type', of, 'l1', name, 'done', done, 'total', total)
        else
            add_event(events, 'type', of, 'item', name, 'status', is_failed == '1' and 'failed' or 'succeeded',
                'done', done, 'total', total)
        end
    end
end
if is_last == '1' then redis.call('HDEL', chunks, index) end
local share = math.floor(left * (done - before) / math.max(1, total - before))
redis.call('HSET', record, 'done', done, 'left', left - share)
redis.call('HINCRBY', active .. ':work', lane .. ':done', share)
if done < tonumber(total) then return 1 end
finish({record = record, chunks = chunks, bits = bits, errors = errors, events = events, items = items,
    wanted = wanted}, active, ends, job_id, 'succeeded', '', ttl)
return 2
