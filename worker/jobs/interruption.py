"""What becomes of a chunk that was interrupted: it is run again, unless that is hopeless."""

from __future__ import annotations

from worker.answers.kinds import is_batch
from worker.jobs.attempts import ChunkRef, Lost
from worker.jobs.batches import Batches
from worker.jobs.chunks import ChunkQueue
from worker.jobs.records import JobRecords


def run_again(
    records: JobRecords, chunks: ChunkQueue, ref: ChunkRef, lost: Lost, kind: str, detail: str
) -> bool:
    """Put the next attempt at the front of its lane; False when there is none.

    When it was lost too often, what it was at is given up. `kind` and `detail` say why.
    """
    following = records.reopen(ref, lost)
    if following == "too-often":
        return give_up(records, chunks, ref, kind, detail)
    return _enqueue(records, chunks, following)


def give_up(records: JobRecords, chunks: ChunkQueue, ref: ChunkRef, kind: str, detail: str) -> bool:
    """Give up the slice or item at which a chunk is, and have the others computed; False when none is left.

    A chunk that was at none, such as a document, fails its job. One that was ahead of what it had kept runs
    again, slice by slice, until it is known which one to give up. `kind` and `detail` say why.
    """
    if is_ahead(records, ref):
        return _enqueue(records, chunks, records.reopen(ref, "horses"))
    batches = Batches(records.redis, records.settings)
    put = batches.give_up_item if is_batch(ref.job_id) else records.put_slice_error
    if put(ref, kind, detail):
        return _enqueue(records, chunks, records.reopen(ref))
    fail(records, chunks, ref, kind, detail)
    return False


def is_ahead(records: JobRecords, ref: ChunkRef) -> bool:
    """Whether the chunk solves slices of which it has not kept the one before."""
    current = records.current(ref)
    return current is not None and current[0].state == "ahead"


def place(records: JobRecords, ref: ChunkRef) -> int:
    """Returns how many items of a chunk are done; 0 if it is none of a batch, or its record has moved on."""
    current = records.current(ref) if is_batch(ref.job_id) else None
    return 0 if current is None else current[0].offset


def fail(records: JobRecords, chunks: ChunkQueue, ref: ChunkRef, kind: str, detail: str) -> None:
    """End the job because of this chunk, and the work on the others."""
    entries = records.fail(ref, kind, detail) or []
    chunks.withdraw([entry for entry in entries if entry.ref != ref])


def _enqueue(records: JobRecords, chunks: ChunkQueue, following: ChunkRef | str) -> bool:
    if isinstance(following, ChunkRef):
        chunks.put_back(following, records.lane(following))
        return True
    return False
