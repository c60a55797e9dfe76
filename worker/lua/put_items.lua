-- Counts items of a batch once each, whose results are kept. `outcomes` has three values for each: its position,
-- what it has beside them, or empty, and whether it failed. `offset` is that of the last of them.
-- Returns 0 if the attempt is out of date, 1 if more items remain, 2 if the batch is done.
-- include: ending
-- keys: record chunks bits errors events active ends
-- args: job_id run index attempt offset is_last job_ttl outcomes...

local chunk = open_chunk(record, chunks, run, index, attempt, unpack(COUNTED))
if not chunk then return 0 end
advance(chunk, offset, is_last == '1')
local news = {}
for i = 1, #outcomes, 3 do
    local item, outcome, is_failed = unpack(outcomes, i, i + 2)
    if redis.call('SETBIT', bits, item, 1) == 0 then
        if outcome ~= '' then redis.call('HSET', errors, item, outcome) end
        if is_failed == '1' then redis.call('HINCRBY', record, 'failed', 1) end
        table.insert(news, {'type', 'item', 'item', item,
            'status', is_failed == '1' and 'failed' or 'succeeded'})
    end
end
if #news == 0 then return 1 end
return count_parts(chunk, news, job_ttl)
