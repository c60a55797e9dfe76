"""Answers that are kept for ever, such as those that a paper cites.

The results of a pinned question have no lifetime, in Redis or as addresses of the archive, and neither has
the question by which the id of its job finds them. Nothing that removes old results touches these.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import cast

from worker.answers.kinds import as_kept, known_answer, missing_parts
from worker.answers.layout import kind_of
from worker.answers.requests import JobRequest
from worker.answers.stored_tables import StoredTable
from worker.jobs.queue import JobLookup
from worker.lua import Scripts


class NotPinnableError(Exception):
    """The answer is not there, or may change: a table with errors, or a search that was stopped."""


class Pins:
    """The pinned answers of one version of the solver."""

    def __init__(self, queue: JobLookup) -> None:
        self.queue = queue
        self.store = queue.store
        settings = queue.settings
        self._key = f"{settings.key_prefix}:{kind_of('pins', settings.solver_version)}"
        self._run = Scripts(queue.redis)

    def ids(self) -> list[str]:
        """Returns the ids of the jobs whose answers are pinned, sorted."""
        members = cast("set[bytes]", self.queue.redis.smembers(self._key))
        return sorted(raw.decode() for raw in members)

    def pin(self, job_id: str) -> None:
        """Keep the answer of a job, or of a question that was answered without one, for ever.

        Raises:
            NotPinnableError: it is not there, or may change.
        """
        request = self.queue.question(job_id)
        if request is None or not self._is_lasting(request):
            raise NotPinnableError(job_id)
        text = zlib.compress(as_kept(request).to_json().encode(), 1)
        keys = {"question": self.store.keys.question(job_id), "pins": self._key}
        if not self._run("pin", keys, results=self._results(request), text=text, job_id=job_id):
            raise NotPinnableError(job_id)

    def unpin(self, job_id: str) -> bool:
        """Let an answer expire as others do; returns False if it was not pinned."""
        request = self.queue.question(job_id)
        results = [] if request is None else self._results(request)
        keys = {"question": self.store.keys.question(job_id), "pins": self._key}
        ttl = self.queue.settings.longest_lifetime
        is_over = self._run("unpin", keys, results=results, job_id=job_id, ttl=ttl)
        for other in self.ids() if is_over else ():  # they may share slices
            self.pin(other)
        return bool(is_over)

    def _is_lasting(self, request: JobRequest) -> bool:
        """Whether the answer is whole and will not change; keeps what it was put together from as its own."""
        answer = known_answer(request, self.store)
        if answer is None:
            return False
        if isinstance(answer, StoredTable):
            return not answer.has_errors and not missing_parts(request, self.store)
        self.store.put_document(request, answer)
        return True

    def _results(self, request: JobRequest) -> Sequence[str]:
        keys = self.store.keys
        if request.kind.by_slices:
            return self.store.slice_keys(request, request.parts)
        return [keys.document(request.content_hash)]
