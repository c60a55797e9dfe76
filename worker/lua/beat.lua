-- Returns 1 if the attempt is open.
-- include: chunks
-- keys: record chunks beat locks
-- args: run index attempt worker ttl

redis.call('SET', beat, worker, 'PX', ttl)
for _, lock in ipairs(redis.call('SMEMBERS', locks)) do
    redis.call('PEXPIRE', lock, ttl)
    redis.call('PEXPIRE', locks, ttl)
end
return open_chunk(record, chunks, run, index, attempt) and 1 or 0
