-- Takes a lock for a holder, beside the others that it holds. Returns 1 if it was free.
-- keys: lock locks
-- args: token ttl

if not redis.call('SET', lock, token, 'NX', 'PX', ttl) then return 0 end
redis.call('SADD', locks, lock)
redis.call('PEXPIRE', locks, ttl)
return 1
