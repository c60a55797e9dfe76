-- Light workers are in a second set too, so that the workers of heavy chunks can be counted.
-- The score of a worker is the time, in milliseconds by the clock of Redis, at which it counts as gone.
-- include: now
-- keys: workers
-- args: name ttl is_light

for _, key in ipairs({workers, is_light == '1' and workers .. ':light' or nil}) do
    redis.call('ZADD', key, milliseconds + ttl, name)
    redis.call('ZREMRANGEBYSCORE', key, '-inf', milliseconds)
    redis.call('PEXPIRE', key, ttl)
end
