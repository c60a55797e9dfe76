-- Notes the outcome of an attempt; no effect if another has claimed the delivery meanwhile.
-- include: announcements
-- keys: due counts
-- args: id claim state delay entry host rest

if host ~= '' then redis.call('ZADD', due .. '-hosts', now + rest, host) end
local key = due .. ':' .. id
if redis.call('HGET', key, 'claims') ~= claim then return 0 end
redis.call('HSET', key, 'attempt:' .. claim, entry, 'state', state)
redis.call('EXPIRE', key, DELIVERY_TTL)
if state == 'pending' then
    redis.call('ZADD', due, now + delay, id)
    redis.call('HSET', key, 'next', string.format('%.3f', now + delay))
else
    redis.call('ZREM', due, id)
    redis.call('HDEL', key, 'next')
end
redis.call('HINCRBY', counts, state, 1)
return 1
