"""Chunks of jobs: what is computed in one attempt, and what is recorded of it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from worker.answers.kinds import request_from_json
from worker.answers.requests import JobRequest

Lost = Literal["", "horses", "workers"]
"""What a chunk has lost: its work horse while its worker lived, its worker too, or nothing."""


@dataclass(frozen=True)
class ChunkRef:
    """One attempt at one chunk of one run of a job."""

    job_id: str
    run: str
    index: int
    attempt: int

    @property
    def rq_id(self) -> str:
        """The id of the RQ job that carries this attempt."""
        return f"{self.job_id}-{self.run}-{self.index}-{self.attempt}"


@dataclass(frozen=True)
class Estimate:
    """What a chunk was estimated to take, in seconds of one core, and the HTTP request that made its job."""

    seconds: float
    request_id: str = ""


@dataclass(frozen=True)
class ChunkEntry:
    """A chunk that is not done yet, as in the record of its job.

    `moved` is its work in milliseconds if it was given back to the heavy lane, else 0.
    """

    ref: ChunkRef
    state: str
    horses_lost: int = 0
    workers_lost: int = 0
    offset: int = 0
    moved: int = 0


@dataclass(frozen=True)
class Chunk:
    """Some parts of a request, the position of the first one in the job, and how many of them are done.

    Attributes:
        request: the question; of a table only for these slices.
        has_losses: whether a work horse, or its worker, was lost since the last part was done.
        origin: the id of the HTTP request that made the job, if one did, and its trace.
    """

    request: JobRequest
    parts: tuple[str, ...]
    first_position: int
    offset: int = 0
    has_losses: bool = False
    origin: Mapping[str, str] = field(default_factory=dict)


def entry_of(job_id: str, run: bytes, index: bytes, entry: bytes) -> ChunkEntry:
    """Reads the entry of a chunk in the record of its job."""
    state, attempt, *counts = entry.decode().split(":")
    return ChunkEntry(ChunkRef(job_id, run.decode(), int(index), int(attempt)), state, *map(int, counts))


def chunk_of(
    entry: ChunkEntry, todo: bytes | None, request: bytes, size: bytes, origin: bytes | None = None
) -> Chunk:
    """Reads a chunk from its entry, its parts (which Redis may have lost) and fields of its job's record."""
    first = entry.ref.index * int(size)
    parts = tuple(json.loads(todo or "[]"))
    has_losses = entry.horses_lost + entry.workers_lost > 0
    question = request_from_json(request)
    if question.kind.by_slices:
        question = question.of_slices(parts)
    return Chunk(question, parts, first, entry.offset, has_losses, json.loads(origin or "{}"))
