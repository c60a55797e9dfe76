"""Answers that were sent a moment ago, in the memory of the API: asked for again, they need no store.

An answer never changes, so what is kept can only be right. It is kept for a short time all the same, so that
the links in it do not outlive what they lead to for long. What may change (a table with errors, a search that
was stopped) is not kept.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from typing import NamedTuple

_MOST_BYTES = 256 << 10
"""Of one answer; larger ones are sent in pieces."""
_OVERHEAD = 500


class Kept(NamedTuple):
    """An answer in one form.

    Attributes:
        form: its media type, with its parameter.
        digest: that of its ETag.
        body: its bytes.
        until: the time from which on it is looked up again (`time.monotonic()`).
    """

    form: str
    digest: str
    body: bytes
    until: float


class KeptAnswers:
    """The answers sent last, by the ids of their jobs and by form; for the thread of the event loop.

    Args:
        most_bytes: the memory that they may take, about; 0 keeps none.
        seconds: how long each is kept.
    """

    def __init__(self, most_bytes: int, seconds: float) -> None:
        self._left = most_bytes
        self._seconds = seconds
        self._kept: OrderedDict[tuple[str, str], Kept] = OrderedDict()

    def get(self, job_id: str, form: str) -> Kept | None:
        """Returns what is kept of an answer in this form, if anything."""
        key = job_id, form
        kept = self._kept.get(key)
        if kept is None:
            return None
        if kept.until < time.monotonic():
            self._drop(key)
            return None
        self._kept.move_to_end(key)
        return kept

    def put(self, job_id: str, form: str, digest: str, body: bytes) -> None:
        """Keep an answer that will not change, in place of those that were not asked for lately."""
        key = job_id, form
        if len(body) > _MOST_BYTES or self._seconds <= 0:
            return
        self._drop(key)
        self._kept[key] = Kept(form, digest, body, time.monotonic() + self._seconds)
        self._left -= len(body) + _OVERHEAD
        while self._left < 0 and self._kept:
            self._drop(next(iter(self._kept)))

    def _drop(self, key: tuple[str, str]) -> None:
        kept = self._kept.pop(key, None)
        if kept is not None:
            self._left += len(kept.body) + _OVERHEAD
