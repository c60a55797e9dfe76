-- Gives a lifetime again to what was kept without an end. Returns 1, or 0 if it was not pinned.
-- keys: question pins results...
-- args: job_id ttl

if redis.call('SREM', pins, job_id) == 0 then return 0 end
for _, key in ipairs({question, unpack(results)}) do
    if redis.call('TTL', key) == -1 then redis.call('EXPIRE', key, ttl) end
end
return 1
