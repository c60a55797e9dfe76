-- Tells how far a job of one document is, or of an improvement that a search has found, if that is news: after an
-- interruption the next attempt tells nothing until it has caught up with the last one.
-- Returns 0 if the job has ended or was started anew.
-- include: jobs
-- keys: record events
-- args: run done total improved improvement

local job_run, status, before, best = unpack(redis.call('HMGET', record, 'run', 'status', 'done', 'improved'))
if job_run ~= run or not is_active(status) then return 0 end
if improvement ~= '' then
    if tonumber(improved) > tonumber(best or 0) then
        redis.call('HSET', record, 'improved', improved)
        add_event(events, 'type', 'improvement', 'improvement', improvement)
    end
elseif tonumber(done) >= tonumber(before) then
    redis.call('HSET', record, 'done', done, 'total', total)
    add_event(events, 'type', 'progress', 'done', done, 'total', total)
end
return 1
