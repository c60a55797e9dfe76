"""What a worker does about an error between two chunks: tell it once, and wait longer and longer."""

from __future__ import annotations

import logging
import random
import time

from redis.exceptions import RedisError

log = logging.getLogger("rpr_cusps.worker")

_SHORTEST, _LONGEST = 0.1, 10.0


class Outage:
    """A run of errors without any success in between."""

    def __init__(self) -> None:
        self._count = 0
        self._since = 0.0
        self._told = ""

    def note(self, error: Exception) -> float:
        """Tell of an error, unless it is the last one again; returns how long to wait, in seconds."""
        if self._count == 0:
            self._since = time.monotonic()
        if (text := f"{type(error).__name__}: {error}") != self._told:
            self._told = text
            unforeseen = None if isinstance(error, RedisError) else error
            log.warning("no work is possible (%s); trying again and again", text, exc_info=unforeseen)
        pause = min(_LONGEST, _SHORTEST * 2.0 ** min(self._count, 10))
        self._count += 1
        return pause * random.uniform(0.5, 1.0)  # not all workers of a machine at the same time

    def end(self) -> None:
        """Work is possible; tell it if it was not before."""
        if self._count:
            log.warning("work is possible again after %.1f s", time.monotonic() - self._since)
            self._count, self._told = 0, ""
