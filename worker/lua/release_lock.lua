-- Frees a lock; one that has expired may be held by another worker by now.
-- keys: lock locks
-- args: token

redis.call('SREM', locks, lock)
if redis.call('GET', lock) == token then redis.call('DEL', lock) end
