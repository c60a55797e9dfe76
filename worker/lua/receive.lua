-- The same for a question of which so much has come, and more will within so many seconds.
-- include: quotas
-- keys: client ledger
-- args: job_id job_prefix size max_bytes grace seconds

local refused = refusal_of_bytes()
if refused then return refused end
count_question(tonumber(seconds))
return {jobs, held, 1}
