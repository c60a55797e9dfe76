-- Renews the lifetime of results. Returns for each whether it is known.
-- keys: results...
-- args: ttl

local known = {}
for i, key in ipairs(results) do
    local left = redis.call('TTL', key)
    if left >= 0 and left < tonumber(ttl) then redis.call('EXPIRE', key, ttl) end
    known[i] = left ~= -2 and 1 or 0
end
return known
