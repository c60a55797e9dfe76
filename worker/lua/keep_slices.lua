-- Keeps slices of tables, or the errors in their place; a known answer has its lifetime renewed. For each table
-- `kept_keys` has the key of its digits and those of its slices, and `values` the number of its slices, its
-- digits, and three values for each slice; see `slices`.
-- include: slices
-- keys: kept_keys...
-- args: ttl error_ttl digits_ttl values...

local key, value = 1, 1
while key <= #kept_keys do
    local count, digits = unpack(values, value, value + 1)
    keep_slices({unpack(kept_keys, key + 1, key + count)}, {unpack(values, value + 2, value + 1 + 3 * count)},
        kept_keys[key], digits, ttl, error_ttl, digits_ttl)
    key, value = key + 1 + count, value + 2 + 3 * count
end
