-- Tells of an improvement that a search has found, unless another chunk of the job has done so.
-- include: jobs
-- keys: record chunks events
-- args: run index attempt number json

if not open_chunk(record, chunks, run, index, attempt) then return 0 end
if tonumber(number) <= tonumber(redis.call('HGET', record, 'improved') or 0) then return 1 end
redis.call('HSET', record, 'improved', number)
add_event(events, 'type', 'improvement', 'improvement', json)
return 1
