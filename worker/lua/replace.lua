-- Puts addresses in the place of results that were moved to the archive, or removes an address under which there
-- is nothing any more (an empty value); only where the value is still the one of this SHA-1. An address lives at
-- least as long as `ttl`. Returns how many were replaced. `values` has two for each: the SHA-1 and the new value.
-- keys: results...
-- args: ttl values...

local replaced = 0
for i, key in ipairs(results) do
    local value = redis.call('GET', key)
    if value and redis.sha1hex(value) == values[2 * i - 1] then
        local left = redis.call('TTL', key)
        redis.call('DEL', key) -- first: a Redis that is full lets a script go on that has freed something
        if values[2 * i] ~= '' then
            redis.call('SET', key, values[2 * i])
            if left >= 0 then redis.call('EXPIRE', key, math.max(left, ttl)) end
        end
        replaced = replaced + 1
    end
end
return replaced
