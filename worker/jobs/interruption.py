"""What becomes of a chunk that was interrupted: it is run again, unless it was lost too often."""

from __future__ import annotations

from worker.jobs.chunks import ChunkQueue
from worker.jobs.records import ChunkRef, JobRecords, Lost


def run_again(
    records: JobRecords, chunks: ChunkQueue, ref: ChunkRef, lost: Lost, kind: str, detail: str
) -> bool:
    """Put the next attempt at the front of the queue; False when there is none.

    When it was lost too often, the slice that was being solved is given up, and the others go on; a chunk
    that was at no slice, such as a document, fails its job. `kind` and `detail` say why.
    """
    following = records.reopen(ref, lost)
    if following == "too-often" and records.put_slice_error(ref, kind, detail):
        following = records.reopen(ref)
    if following == "too-often":
        fail(records, chunks, ref, kind, detail)
    if not isinstance(following, ChunkRef):
        return False
    chunks.enqueue([following], bulk=False, at_front=True)
    return True


def fail(records: JobRecords, chunks: ChunkQueue, ref: ChunkRef, kind: str, detail: str) -> None:
    """End the job because of this chunk, and the work on the others."""
    entries = records.fail(ref, kind, detail) or []
    chunks.withdraw([entry for entry in entries if entry.ref != ref])
