"""The chunks of jobs, with the test acting as the worker."""

from __future__ import annotations

from worker.jobs.chunks import ChunkEntry, ChunkRef
from worker.jobs.queue import JobQueue


def refs(queue: JobQueue) -> list[ChunkRef]:
    """Returns the open chunks of all jobs, by their index."""
    return sorted((entry.ref for entry in queue.records.open_chunks()), key=lambda ref: ref.index)


def work(
    queue: JobQueue, ref: ChunkRef, slices: int = 100, *, error: str = "", one_by_one: bool = True
) -> None:
    """Process a chunk, or its first slices, as a worker does."""
    chunk = queue.attempts.start(ref)
    assert chunk is not None
    assert queue.attempts.begin_slices(ref, one_by_one=one_by_one)
    for offset in range(chunk.offset, min(chunk.offset + slices, len(chunk.parts))):
        l1 = chunk.parts[offset]
        value: dict[str, object] = {"l1": l1, "count": 0, "cusps": []}
        if l1 == error:
            value = {"l1": l1, "error": {"type": "solver-error", "detail": "undecided"}}
        queue.attempts.put_slices(ref, chunk, offset, [value])


def finish(queue: JobQueue) -> None:
    """Process all open chunks."""
    for ref in refs(queue):
        work(queue, ref)


def entry(queue: JobQueue, index: int = 0) -> ChunkEntry:
    """Returns the record of an open chunk."""
    return next(e for e in queue.records.open_chunks() if e.ref.index == index)
