-- include: keep

-- Keeps slices under their keys. `stored` has three values for each: its length, the slice as it is stored, and
-- whether it is an error. `digits_ttl`: the longest that slices live. A known answer has its lifetime renewed, and
-- is never replaced by an error.
local function keep_slices(slice_keys, stored, known_digits, digits, ttl, error_ttl, digits_ttl)
    local slices, is_one_known = {}, false
    for i, key in ipairs(slice_keys) do
        local l1, packed, is_error = unpack(stored, 3 * i - 2, 3 * i)
        is_error = is_error == '1'
        if is_error then
            redis.call('SET', key, packed, 'EX', error_ttl, 'NX')
        else
            keep_result(key, packed, ttl)
        end
        is_one_known = is_one_known or not is_error
        slices[i] = {l1 = l1, packed = packed, is_error = is_error}
    end
    if is_one_known then
        redis.call('SADD', known_digits, digits)
        redis.call('EXPIRE', known_digits, digits_ttl)
    end
    return slices
end
