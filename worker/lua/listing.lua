-- The lists of jobs: an index by time has every job, another one every batch, and each client has two.
--
-- They hold a limited number of entries, and a few more until a job comes whose id ends with 0. A job that is kept
-- longer than it is listed can be asked for by its id.
-- include: now

local MOST, MOST_OF_CLIENT = 20000, 2000
local LISTED_SECONDS = 30 * 86400

local function list_in(index, job_id, most)
    redis.call('ZADD', index, now, job_id)
    if string.sub(job_id, -1) == '0' then redis.call('ZREMRANGEBYRANK', index, 0, -most - 1) end
    redis.call('EXPIRE', index, LISTED_SECONDS)
end

local function index_of(active, job_id)
    return active .. ':made:' .. (string.find(job_id, '^ba%-') and 'batches' or 'jobs')
end

-- Lists a job that begins, or begins again.
local function list_job(active, job_id) list_in(index_of(active, job_id), job_id, MOST) end

-- Lists a job for the client of a subscription, which it returns.
local function list_of(active, job_id, name)
    local client = string.match(name, '^[^#]*')
    list_in(index_of(active, job_id) .. ':' .. client, job_id, MOST_OF_CLIENT)
    return client
end

-- The same; the first one is its maker.
local function list_for(record, active, job_id, name)
    redis.call('HSETNX', record, 'maker', list_of(active, job_id, name))
end
