-- The bytes that are kept of each client's questions, as its quota counts them.
--
-- While a job is active, its record says how many there are. At its end those that stay are added to the ledger
-- of the client, in the field `@TIME` of all that expires at about the same time; the client that made the job
-- pays for it, whoever else wants it. The scripts that end, replace and remove a record do so in one step with
-- it. What expires, or is lost, has left the ledger when the time of its field has come.
-- include: now

local function live_for(key, seconds)
    if redis.call('TTL', key) < seconds then redis.call('EXPIRE', key, math.ceil(seconds)) end
end

-- Counts what is kept of a job that ends for whoever made it, until its record expires, by the fields of this.
-- Returns those that are to be set.
local function count_kept(fields, ttl)
    local ledger, bytes = fields.ledger, fields.kept_bytes
    if not ledger then return {} end
    local step = math.max(1, math.ceil(ttl / 100))  -- so that a ledger has few fields
    local due = string.format('@%d', math.ceil((now + ttl) / step) * step)
    local is_new = redis.call('HINCRBY', ledger, due, bytes) == tonumber(bytes)
    if is_new then live_for(ledger, ttl + step) end
    return {'bytes', bytes, 'due', due}
end

-- Returns what `release` needs to know of a record that is about to be removed.
local function counted(record) return redis.call('HMGET', record, 'ledger', 'due', 'bytes') end

local function release(ledger, due, bytes)
    if due and redis.call('HEXISTS', ledger, due) == 1 then redis.call('HINCRBY', ledger, due, -bytes) end
end
