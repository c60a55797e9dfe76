-- Gives an active job the deadline of one more client; the latest counts, and none is the latest of all.
-- include: jobs
-- keys: record active
-- args: job_id deadline_s

local status, deadline = unpack(redis.call('HMGET', record, 'status', 'deadline'))
if not is_active(status) or not deadline then return end
if deadline_s == '' then
    redis.call('HDEL', record, 'deadline')
    redis.call('ZREM', active .. ':deadlines', job_id)
elseif now + deadline_s > tonumber(deadline) then
    set_deadline(record, active, job_id, deadline_s)
end
