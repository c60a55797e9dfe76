-- The slices are valid whatever the state of the job, so they are kept in any case; then each is counted once.
-- `offset` and `position` are those of the first of them.
-- Returns 0 if the attempt is out of date, 1 if more slices remain, 2 if the job is done.
-- include: ending slices
-- keys: known_digits record chunks bits errors events active ends slice_keys...
-- args: job_id run index attempt offset is_last position digits ttl error_ttl digits_ttl job_ttl stored...

local slices = keep_slices(slice_keys, stored, known_digits, digits, ttl, error_ttl, digits_ttl)
local chunk = open_chunk(record, chunks, run, index, attempt, unpack(COUNTED))
if not chunk then return 0 end
advance(chunk, offset + #slices - 1, is_last == '1')
local news = {}
for i, slice in ipairs(slices) do
    if slice.is_error then redis.call('HSET', errors, slice.l1, slice.packed) end
    if redis.call('SETBIT', bits, position + i - 1, 1) == 0 then
        table.insert(news, {'type', 'slice', 'l1', slice.l1})
    end
end
if #news == 0 then return 1 end
return count_parts(chunk, news, job_ttl)
