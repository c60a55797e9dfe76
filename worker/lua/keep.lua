-- A result that is kept stays as it is, and lives at least as long as was asked for last. One that is pinned has
-- no end. The address of one that is in the archive gives way to the result itself: then the archive had lost it.

-- Returns whether the result is known.
local function renew(key, ttl)
    local left = redis.call('TTL', key)
    if left >= 0 and left < tonumber(ttl) then redis.call('EXPIRE', key, ttl) end
    return left ~= -2
end

local function keep_result(key, value, ttl)
    if redis.call('SET', key, value, 'EX', ttl, 'NX') then return end
    if redis.call('GETRANGE', key, 0, 0) == '\2' then redis.call('SET', key, value, 'KEEPTTL') end
    renew(key, ttl)
end
