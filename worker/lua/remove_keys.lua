-- Removes keys whose lifetime has not been renewed since the look at it. Returns the number of removed keys.
-- keys: chosen...
-- args: lifetimes...

local removed = 0
for i, key in ipairs(chosen) do
    local left = redis.call('PTTL', key)
    if left >= 0 and left <= tonumber(lifetimes[i]) then removed = removed + redis.call('UNLINK', key) end
end
return removed
