-- Removes keys whose lifetime has not been renewed since the look at it.
-- The record of a job leaves the ledger of its client, after its removal: before it there may be no room.
-- Returns the number of removed keys.
-- include: kept
-- keys: chosen...
-- args: lifetimes...

local removed = 0
for i, key in ipairs(chosen) do
    local left = redis.call('PTTL', key)
    if left >= 0 and left <= tonumber(lifetimes[i]) then
        local of = redis.call('TYPE', key).ok == 'hash' and counted(key) or {}
        removed = removed + redis.call('UNLINK', key)
        release(unpack(of, 1, 3))
    end
end
return removed
