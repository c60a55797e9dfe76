-- The same for a question of which `size` bytes have come so far; more come within `seconds`.
-- include: quotas
-- keys: client ledger
-- args: job_id job_prefix size max_bytes grace seconds

local refused = refusal_of_bytes()
if refused then return refused end
count_question(tonumber(seconds))
return {jobs, held, 1}
