-- Counts an item of a batch once, whose results are kept; `outcome`: what it has beside them, or empty.
-- Returns 0 if the attempt is out of date, 1 if more items remain, 2 if the batch is done.
-- include: jobs
-- keys: record chunks bits errors events active ends
-- args: job_id run index attempt offset is_last item outcome is_failed job_ttl

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return 0 end
advance(record, active, chunks, index, chunk, offset, is_last == '1')
if redis.call('SETBIT', bits, item, 1) == 1 then return 1 end
if outcome ~= '' then redis.call('HSET', errors, item, outcome) end
if is_failed == '1' then redis.call('HINCRBY', record, 'failed', 1) end
local event = {'type', 'item', 'item', item, 'status', is_failed == '1' and 'failed' or 'succeeded'}
return count_parts(record, chunks, bits, errors, events, active, ends, job_id, job_ttl, chunk, {event})
