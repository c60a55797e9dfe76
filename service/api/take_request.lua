-- Takes one request from an allowance, by the generic cell rate algorithm. The key has the time at which the
-- allowance is full again.
-- Returns whether the request is allowed, the milliseconds until one is, and until the allowance is full.
-- keys: allowance
-- args: limit window

local share = window / limit
local time = redis.call('TIME')
local now = time[1] + time[2] / 1e6
local full = math.max(now, tonumber(redis.call('GET', allowance) or 0)) + share
local wait = full - now - window
if wait > 1e-6 then return {0, math.ceil(wait * 1000), math.ceil((window + wait - share) * 1000)} end
redis.call('SET', allowance, string.format('%.6f', full), 'PX', math.ceil((full - now) * 1000))
return {1, 0, math.ceil((full - now) * 1000)}
