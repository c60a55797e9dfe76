"""The reading of posted questions: in threads, since it may be slow, and only once for the latest of them."""

from __future__ import annotations

from collections import OrderedDict
from typing import NamedTuple

from service.api.body import json_of
from service.api.operations import Operation
from service.api.threads import Threads
from service.schemas.document import Source, read
from service.schemas.limits import Limits
from worker.answers.requests import JobRequest

_KEPT = 500
_LONGEST_KEPT = 1 << 10  # bytes
_MOST_PARTS_KEPT = 50


class Asked(NamedTuple):
    """A question, its deadline in seconds, and where its end is to be told."""

    request: JobRequest
    deadline_s: float | None
    callback_url: str | None = None


class Reading:
    """Reads bodies; remembers the questions of short ones, the latest first."""

    def __init__(self, limits: Limits, threads: Threads) -> None:
        self._limits = limits
        self._threads = threads
        self._kept: OrderedDict[tuple[str, bytes], Asked] = OrderedDict()

    async def question(self, operation: Operation, body: bytes) -> Asked:
        """Returns the question that a body asks.

        Raises:
            InputError: it asks none.
            ProblemError: it is not strict JSON.
        """
        key = operation.name, body
        asked = self._kept.get(key)
        if asked is None:
            asked = await self._threads(self._read, operation, body)
            if len(body) > _LONGEST_KEPT or len(asked.request.parts) > _MOST_PARTS_KEPT:
                return asked
            if len(self._kept) >= _KEPT:
                self._kept.popitem(last=False)
            self._kept[key] = asked
        self._kept.move_to_end(key)
        return asked

    def _read(self, operation: Operation, body: bytes) -> Asked:
        return asked_of(operation, json_of(body, self._limits), self._limits)


def asked_of(operation: Operation, document: object, limits: Limits) -> Asked:
    """Returns the question that a document asks.

    Raises:
        InputError: it asks none.
    """
    question = read(operation.question, document, Source(limits))
    return Asked(question.job_request(), question.deadline_s, question.callback_url)
