-- Returns the first bytes of slices, as many as are wanted.
-- keys: slice_keys...
-- args: count

local heads = {}
for i, key in ipairs(slice_keys) do heads[i] = redis.call('GETRANGE', key, 0, count - 1) end
return heads
