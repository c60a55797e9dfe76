-- The time by the clock of Redis: seconds since 1970, as text with microseconds.

local time = redis.call('TIME')
local now = string.format('%d.%06d', time[1], time[2])
