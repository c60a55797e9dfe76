-- Keeps the results of a question without an end, and the question by which its id finds them. Returns 1, or 0
-- if one of them is not there any more; then nothing is changed.
-- keys: question pins results...
-- args: text job_id

for _, key in ipairs(results) do
    if redis.call('EXISTS', key) == 0 then return 0 end
end
redis.call('SET', question, text)
redis.call('SADD', pins, job_id)
for _, key in ipairs(results) do redis.call('PERSIST', key) end
return 1
