-- Keeps a document in any case, the first of several, and ends the job that requested it.
-- include: jobs
-- keys: document record chunks bits errors events active ends
-- args: job_id run index attempt json document_ttl job_ttl

if not redis.call('SET', document, json, 'EX', document_ttl, 'NX') then
    redis.call('EXPIRE', document, document_ttl)
end
if not open_chunk(record, chunks, run, index, attempt) then return 0 end
redis.call('HSET', record, 'done', redis.call('HGET', record, 'total'))
finish(record, chunks, bits, errors, events, active, ends, job_id, 'succeeded', '', job_ttl)
return 2
