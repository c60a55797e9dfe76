-- The time by the clock of Redis since 1970: in seconds, as text with microseconds, and in milliseconds.

local time = redis.call('TIME')
local now = string.format('%d.%06d', time[1], time[2])
local milliseconds = time[1] * 1000 + math.floor(time[2] / 1000)
