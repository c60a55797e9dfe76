-- From now on the work horse, if it dies, dies of the slice `offset`, or in the state `ahead` maybe of a later
-- one. Returns 0 if the attempt is out of date.
-- include: chunks
-- keys: record chunks
-- args: run index attempt state

local chunk = open_chunk(record, chunks, run, index, attempt)
if not chunk then return 0 end
chunk.state = state
put_chunk(chunks, index, chunk)
return 1
