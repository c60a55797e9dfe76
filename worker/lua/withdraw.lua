-- Withdraws the subscription `name`; or the one with `token`, of whatever address; or, if both are empty, the
-- newest one of `address` whose request no longer waits.
-- include: jobs
-- keys: record
-- args: name address token

local newest, newest_since = nil, -1
for _, field in ipairs(redis.call('HKEYS', record)) do
    local whose, its_token = string.match(field, '^by:([^#]*)#?(.*)$')
    if whose and name ~= '' then
        if field == 'by:' .. name then redis.call('HDEL', record, field) end
    elseif whose and token ~= '' then
        if its_token == token then redis.call('HDEL', record, field, 'wait:' .. token) end
    elseif whose == address and not is_waiting(record, 'wait:' .. its_token) then
        local since = tonumber(redis.call('HGET', record, field))
        if since > newest_since then newest, newest_since = field, since end
    end
end
if newest then redis.call('HDEL', record, newest) end
