-- Records the progress of a job of one chunk that counts its own steps; after an interruption, only once the
-- new attempt has caught up with the last one. Returns 0 if the attempt is out of date.
-- include: jobs
-- keys: record chunks events
-- args: run index attempt done total

if not open_chunk(record, chunks, run, index, attempt) then return 0 end
if tonumber(done) < tonumber(redis.call('HGET', record, 'done')) then return 1 end
redis.call('HSET', record, 'done', done, 'total', total)
add_event(events, 'type', 'progress', 'done', done, 'total', total)
return 1
