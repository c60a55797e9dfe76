-- Light workers are in a second set too, so that the workers of heavy chunks can be counted.
-- The score of a worker is the time, in milliseconds by the clock of Redis, at which it counts as gone.
-- keys: workers
-- args: name ttl is_light

local time = redis.call('TIME')
local now = time[1] * 1000 + math.floor(time[2] / 1000)
for _, key in ipairs({workers, is_light == '1' and workers .. ':light' or nil}) do
    redis.call('ZADD', key, now + ttl, name)
    redis.call('ZREMRANGEBYSCORE', key, '-inf', now)
    redis.call('PEXPIRE', key, ttl)
end
