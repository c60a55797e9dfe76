-- Renews the lifetime of results. Returns for each whether it is known.
-- include: keep
-- keys: results...
-- args: ttl

local known = {}
for i, key in ipairs(results) do known[i] = renew(key, ttl) and 1 or 0 end
return known
