-- Records that the attempt no longer runs, frees the locks that it held, and deletes its RQ job.
-- Returns 1 if the attempt is open.
-- include: chunks
-- keys: record chunks beat locks rq_job
-- args: run index attempt

redis.call('DEL', rq_job, beat, locks, unpack(redis.call('SMEMBERS', locks)))
return open_chunk(record, chunks, run, index, attempt) and 1 or 0
