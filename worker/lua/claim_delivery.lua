-- Returns the fields of a delivery that is due, and leases it; nothing if none is.
--
-- What is due goes into the sorted set of its host first, so that a host that must wait holds up no other: the
-- hosts take turns, the one that was served longest ago first. There it waits under a lease too, so that a set
-- that is lost, or a process of an older version, changes nothing. `waiting` has the names of
-- hosts that must wait, or `*.` and what they end with.
-- include: now
-- keys: due
-- args: lease waits many waiting...

local hosts = due .. '-hosts'

for _, id in ipairs(redis.call('ZRANGEBYSCORE', due, '-inf', now, 'LIMIT', 0, many)) do
    local url = redis.call('HGET', due .. ':' .. id, 'url')
    if url then
        local authority = string.lower(string.match(url, '^%a+://([^/?#]*)') or '')
        local host = string.match(authority, '^%[(.*)%]') or string.match(authority, '^[^:]*')
        redis.call('ZADD', due .. '-to:' .. host, 'NX', now, id)
        redis.call('ZADD', hosts, 'NX', now, host)
        redis.call('ZADD', due, now + waits, id)
    else
        redis.call('ZREM', due, id)
    end
end

local function must_wait(host)
    for _, name in ipairs(waiting) do
        if name == host then return true end
        if string.sub(name, 1, 1) == '*' and string.sub(host, 1 - #name) == string.sub(name, 2) then
            redis.call('ZADD', hosts, now, host)
            return true
        end
    end
    return false
end

for _, host in ipairs(redis.call('ZRANGEBYSCORE', hosts, '-inf', now, 'LIMIT', 0, many)) do
    local ready = due .. '-to:' .. host
    while not must_wait(host) do
        local id = redis.call('ZRANGE', ready, 0, 0)[1]
        if not id then
            redis.call('ZREM', hosts, host)
            break
        end
        redis.call('ZREM', ready, id)
        local key = due .. ':' .. id
        if redis.call('ZSCORE', due, id) and redis.call('EXISTS', key) == 1 then
            redis.call('ZADD', hosts, now, host)
            redis.call('ZADD', due, now + lease, id)
            local claim = redis.call('HINCRBY', key, 'claims', 1)
            redis.call('HSET', key, 'attempt:' .. claim, string.format('{"at":%s}', now))
            redis.call('HSET', key, 'next', string.format('%.3f', now + lease))
            return redis.call('HGETALL', key)
        end
    end
end
return false
