-- Returns {1, its event, names and values of fields to show…} if the job was created; {1, ''} if it has ended at
-- once; {0} if another client has created or changed it meanwhile, or items of a batch are missing; {-1,
-- milliseconds until the backlog is done} if its lane is full.
--
-- `asked` is the request without its slices, `kept` what stays of it at the end, empty if it stays whole; its bytes
-- are counted in `ledger`, if there is one. `todo` has the parts to do, chunk by chunk; the items of a batch that
-- are none of them have failed. A batch with a deadline is one of which more items come; see `extend_batch`.
-- include: ending
-- keys: record chunks bits errors events active ends workers versions
-- args: job_id run seen_run total todo_count request asked kept ledger bytes kept_bytes chunk_size
-- args: chunk_count ttl origin lane work each max_backlog deadline_s version name token seconds todo...

-- So that the APIs of other versions find the job at once.
if version ~= '' then redis.call('SADD', versions, version) end
local old_run, old_status = unpack(redis.call('HMGET', record, 'run', 'status'))
if old_run and (is_active(old_status) or old_run ~= seen_run) then return {0} end
local is_batch = string.match(job_id, '^ba%-') ~= nil
local is_received = is_batch and deadline_s ~= ''
if is_batch and redis.call('LLEN', items_of(record)) ~= tonumber(total) then return {0} end
local wait = tonumber(todo_count) > 0 and wait_for_room(active, workers, lane, work, max_backlog, 0)
if wait then return {-1, wait} end
if old_run then release(unpack(counted(record))) end
redis.call('DEL', record, chunks, bits, errors, events, todo_of(record))
local shown = {'run', run, 'status', 'queued', 'total', total, 'done', tostring(total - todo_count), 'created', now,
    'work', work}
local fields = {'request', request, 'asked', asked, 'chunk_size', chunk_size, 'chunk_count', chunk_count,
    'origin', origin, 'each', each, unpack(shown)}
local function set(...)
    for _, value in ipairs({...}) do table.insert(fields, value) end
end
if kept ~= '' then set('kept', kept) end
if is_received then set('receiving', 1) else list_job(active, job_id) end
if ledger ~= '' then set('ledger', ledger, 'bytes', bytes, 'kept_bytes', kept_bytes) end
if name ~= '' then set('maker', list_of(active, job_id, name)) end
if tonumber(todo_count) > 0 then
    if name ~= '' then set(subscription(name, token, seconds)) end
    set('lane', lane, 'left', work, 'ahead', select(2, backlog(active, lane)))
end
redis.call('HSET', record, unpack(fields))
if is_batch then
    if not is_received then
        keep_items(record)
    end
    redis.call('HSET', record, 'failed', total - todo_count)
    mark_failed(bits, 0, total, todo)
end
if tonumber(todo_count) == 0 then
    redis.call('HSET', record, 'started', now)
    finish('succeeded', '', ttl)
    return {1, ''}
end
for index = 0, chunk_count - 1 do redis.call('HSET', chunks, index, 'queued:0:0:0:0') end
for first = 1, chunk_count, 1000 do  -- what `unpack` can take
    redis.call('RPUSH', todo_of(record), unpack(todo, first, math.min(chunk_count, first + 999)))
end
redis.call('ZADD', active, now, job_id)
redis.call('ZADD', active .. ':queued', rank(lane, now), job_id)
add_work(active, lane, 'added', work)
if deadline_s ~= '' then
    table.insert(shown, 'deadline')
    table.insert(shown, set_deadline(record, active, job_id, deadline_s))
end
return {1, add_event(events, 'type', 'status', 'status', 'queued'), unpack(shown)}
