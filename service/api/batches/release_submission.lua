-- Forgets a submission; if `after` is given, only one that was noted at least so many seconds ago.
-- keys: submission
-- args: token after

local owner, since = unpack(redis.call('HMGET', submission, 'token', 'since'))
if owner ~= token then return end
if after ~= '' and redis.call('TIME')[1] - (since or 0) < tonumber(after) then return end
redis.call('DEL', submission)
