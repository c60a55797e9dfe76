-- The estimated work of each lane.
--
-- The hash `:work`, named after the set of active jobs, has the milliseconds that each lane was given
-- (`LANE:added`) and that are done or dropped (`LANE:done`). Their difference is the lane's backlog. A record
-- keeps the `work` of its job and of `each` of its chunks, what is `left` of it, and the `ahead` of it: its
-- lane's `added` when it was queued.
--
-- A chunk that was given back is in the heavy lane that belongs to its job's (`heavy_of`), with its work, which
-- its entry keeps. The record has the sum of what is `moved` so, and how many open parts are `apart` there.
-- include: now

local LANES = {small = 1, bulk = 2, heavy = 3, batch = 4, ['heavy-batch'] = 5, shared = 6}
-- A score that orders by lane, then by time to 10 microseconds: a double holds no more.
local function rank(lane, time) return string.format('%.5f', LANES[lane] * 1e10 + time) end
local function add_work(active, lane, what, work)
    redis.call('HINCRBY', active .. ':work', lane .. ':' .. what, work)
end

-- Returns the work of a lane that is not done, in milliseconds, and all that it was given.
local function backlog(active, lane)
    local added, done = unpack(redis.call('HMGET', active .. ':work', lane .. ':added', lane .. ':done'))
    return math.max(0, (added or 0) - (done or 0)), added or 0
end

-- Returns the number of live workers, and of those that take heavy chunks too.
local function live_workers(workers)
    local alive = '(' .. milliseconds
    local count = redis.call('ZCOUNT', workers, alive, '+inf')
    return count, count - redis.call('ZCOUNT', workers .. ':light', alive, '+inf')
end

-- Returns the number of live workers that take chunks of a lane; 1 if there is none.
local function workers_of(lane, workers)
    local all, strong = live_workers(workers)
    return math.max(1, string.find(lane, '^heavy') and strong or all)
end

-- Returns the milliseconds until the backlog of a lane is done if it is too long for more `work`; nothing if there
-- is room, as in a lane in which no job waits; `own` of those that do are not counted.
local function wait_for_room(active, workers, lane, work, max_backlog, own)
    local waiting = backlog(active, lane)
    if waiting + work <= tonumber(max_backlog) then return nil end -- there is room even for one worker
    local count = workers_of(lane, workers)
    local jobs = redis.call('ZCOUNT', active .. ':queued', rank(lane, 0), rank(lane, 1e10 - 1))
    if waiting + work > max_backlog * count and jobs > own then return math.ceil(waiting / count) end
end

local function heavy_of(lane) return string.match(lane, 'batch$') and 'heavy-batch' or 'heavy' end

-- Counts parts of a chunk as done, of `open` ones that the job had, by some fields of its record.
local function count_work(record, active, chunk, parts, open, lane, left, apart)
    if chunk.moved > 0 then
        redis.call('HINCRBY', record, 'apart', -parts)
        return
    end
    if left then
        local share = math.floor(left * parts / math.max(parts, open - (apart or 0)))
        redis.call('HSET', record, 'left', left - share)
        add_work(active, lane, 'done', share)
    end
end

-- Moves a chunk, with `parts` left to do, to the heavy lane with its share of the job's work.
local function move_work(record, active, chunk, parts)
    local fields = redis.call('HMGET', record, 'lane', 'left', 'apart', 'total', 'done', 'chunk_count')
    local lane, left, apart, total, done, chunk_count = unpack(fields)
    left = tonumber(left) or 0
    local share = left
    if chunk_count ~= '1' then -- else the steps of a document may be what is counted
        share = math.floor(left * parts / math.max(parts, total - done - (apart or 0)))
        redis.call('HINCRBY', record, 'apart', parts)
    end
    chunk.moved = math.max(1, share)
    redis.call('HSET', record, 'left', left - share)
    redis.call('HINCRBY', record, 'moved', chunk.moved)
    add_work(active, lane, 'done', share)
    add_work(active, heavy_of(lane), 'added', chunk.moved)
end

-- A chunk of the heavy lane that was given to it is done.
local function end_moved(record, active, chunk)
    redis.call('HINCRBY', record, 'moved', -chunk.moved)
    add_work(active, heavy_of(redis.call('HGET', record, 'lane')), 'done', chunk.moved)
end

-- Takes what is left of a job's work off its lanes, by the fields of its record.
local function drop_work(fields, active)
    if fields.left and redis.call('EXISTS', active .. ':work') == 1 then
        add_work(active, fields.lane, 'done', fields.left)
        if fields.moved then add_work(active, heavy_of(fields.lane), 'done', fields.moved) end
    end
end
