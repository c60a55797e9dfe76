-- Keeps a document in any case, the first of several, and ends the job that requested it. `own_hash` is empty,
-- or that of a search that was stopped; then the document is the answer of this job alone.
-- include: ending keep
-- keys: document record chunks bits errors events active ends
-- args: job_id run index attempt json own_hash document_ttl job_ttl

keep_result(document, json, document_ttl)
local fields = fields_of(record)
if not chunk_of(fields.run, fields.status, chunks, run, index, attempt) then return 0 end
if own_hash ~= '' then
    redis.call('HSET', record, 'stopped', own_hash)
end
local done = own_hash == '' and 'all' or nil
finish('succeeded', '', job_ttl, done, fields)
return 2
