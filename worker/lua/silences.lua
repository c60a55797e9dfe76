-- Fails if a worker's beat would fail too, for example because Redis is out of memory.
-- keys: workers probe
-- args: ttl

local time = redis.call('TIME')
local now = time[1] * 1000 + math.floor(time[2] / 1000)
redis.call('SET', probe, now, 'PX', ttl)
local silences = {}
local entries = redis.call('ZRANGE', workers, 0, -1, 'WITHSCORES')
for i = 1, #entries, 2 do
    silences[i] = entries[i]
    silences[i + 1] = now + ttl - tonumber(entries[i + 1])
end
return silences
