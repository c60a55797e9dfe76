-- Opens the next attempt at a chunk; `lost` is 'horses', 'workers' or empty. A loss is counted only for a
-- chunk that had started. One that was ahead is never lost too often, since it is not known by which slice.
-- Returns the new attempt's number, -1 if the chunk is out of date, -2 if it was lost too often.
-- include: jobs
-- keys: record chunks ends
-- args: run index attempt lost max_losses

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return -1 end
if lost ~= '' and chunk.state ~= 'queued' then
    redis.call('HINCRBY', ends, 'lost:' .. lost, 1)
    chunk[lost] = chunk[lost] + 1
    if chunk[lost] > tonumber(max_losses) and chunk.state ~= 'ahead' then return -2 end
end
chunk.state, chunk.attempt = 'queued', attempt + 1
put_chunk(chunks, index, chunk)
return chunk.attempt
