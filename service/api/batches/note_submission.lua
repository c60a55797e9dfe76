-- Notes a submission that was received.
-- keys: submission
-- args: token digest job_id ttl

redis.call('HSET', submission, 'token', token, 'digest', digest, 'job', job_id,
    'since', redis.call('TIME')[1])
redis.call('EXPIRE', submission, ttl)
