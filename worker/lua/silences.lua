-- Fails if a worker's beat would fail too, for example because Redis is out of memory.
-- include: now
-- keys: workers probe
-- args: ttl

redis.call('SET', probe, milliseconds, 'PX', ttl)
local silences = {}
local entries = redis.call('ZRANGE', workers, 0, -1, 'WITHSCORES')
for i = 1, #entries, 2 do
    silences[i] = entries[i]
    silences[i + 1] = milliseconds + ttl - tonumber(entries[i + 1])
end
return silences
