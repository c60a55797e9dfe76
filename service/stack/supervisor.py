"""Keeps Valkey, the workers and the API running, each in a process of its own, and does nothing else."""

from __future__ import annotations

import time
from collections.abc import Callable

from service.stack.api_child import ApiChild
from service.stack.output import announce
from service.stack.valkey_child import ValkeyChild
from worker.process.child import end_all
from worker.process.pool import WorkerPool

_TICK = 0.05
_ANNOUNCE_PATIENCE = 5.0  # seconds that the announcement waits for workers, once the API answers


class Supervisor:
    """The processes of one machine. All calls must come from one thread, since they end with it."""

    def __init__(
        self, valkey: ValkeyChild | None, api: ApiChild, pool: WorkerPool, announcement: str
    ) -> None:
        self._valkey, self._api, self._pool = valkey, api, pool
        self._announcement = announcement
        self._announce_at = float("inf")

    def run(self, is_wanted: Callable[[], bool], is_reached: Callable[[], bool] = lambda: True) -> None:
        """Start the API and the workers, and keep everything running as long as it is wanted.

        It is announced once Redis is reached.
        """
        self._api.start()
        self._pool.start()
        while is_wanted():
            if self._valkey is not None:
                self._valkey.look_after()
            self._api.look_after()
            self._pool.look_after()
            if is_reached():
                self._announce()
            time.sleep(_TICK)

    def stop(self, is_hurried: Callable[[], bool]) -> None:
        """End the API and the workers; unfinished chunks go back to the queue."""
        end_all([*self._api.processes(), *self._pool.processes()], is_hurried)
        self._pool.stop()

    def _announce(self) -> None:
        if not self._announcement or not self._api.is_ready():
            return
        self._announce_at = min(self._announce_at, time.monotonic() + _ANNOUNCE_PATIENCE)
        if self._pool.is_ready() or time.monotonic() >= self._announce_at:
            announce(self._announcement)
            self._announcement = ""
