-- Keeps results, each the first of several. One that is kept stays as it is, and lives at least as long as was asked
-- for last; it takes the place of an address in the archive, which had lost it then. `values` has for each the
-- seconds and the value.
-- keys: results...
-- args: values...

for i, key in ipairs(results) do
    local ttl, value = unpack(values, 2 * i - 1, 2 * i)
    if not redis.call('SET', key, value, 'EX', ttl, 'NX') then
        if redis.call('GETRANGE', key, 0, 0) == '\2' then redis.call('SET', key, value, 'KEEPTTL') end
        if redis.call('TTL', key) < tonumber(ttl) then redis.call('EXPIRE', key, ttl) end
    end
end
