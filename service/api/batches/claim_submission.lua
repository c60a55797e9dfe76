-- Returns the earlier submission {token, digest, job id}, or nothing: then the key is the caller's.
-- keys: submission
-- args: token ttl

local earlier = redis.call('HMGET', submission, 'token', 'digest', 'job')
if earlier[1] then return {earlier[1], earlier[2] or '', earlier[3] or ''} end
redis.call('HSET', submission, 'token', token)
redis.call('EXPIRE', submission, ttl)
return false
