"""A Redis that `serve` was given: it need not be there yet."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from service.stack.errors import BadAddressError, StackError
from worker.connection import UnreachableError, wait_for

_TICK = 0.05


class GivenRedis:
    """Looks for Redis in a thread, until it answers.

    Args:
        url: its address.
        check: judges it once it answers; raises StackError if the service cannot run with it.
        is_wanted: whether to look on.
        tell: reports that `serve` waits for Redis.
    """

    def __init__(
        self,
        url: str,
        check: Callable[[], object],
        is_wanted: Callable[[], bool],
        tell: Callable[[str], object],
    ) -> None:
        self._url, self._check, self._is_wanted, self._tell = url, check, is_wanted, tell
        self._is_waiting = False
        self.is_reached = False
        self.problem: StackError | None = None
        """Why the service cannot run with it."""

    def look(self) -> None:
        """Begin to look; returns once it answers or is waited for.

        Raises:
            StackError: the service cannot run with it.
        """
        threading.Thread(target=self._run, daemon=True).start()
        while not (self.is_reached or self._is_waiting or self.problem) and self._is_wanted():
            time.sleep(_TICK)
        if self.problem is not None:
            raise self.problem

    def _run(self) -> None:
        try:
            if wait_for(self._url, self._is_wanted, self._wait):
                self._check()
                self.is_reached = True
        except UnreachableError as error:
            is_address = isinstance(error.__cause__, ValueError)
            self.problem = (BadAddressError if is_address else StackError)(str(error))
        except StackError as error:
            self.problem = error

    def _wait(self, why: str) -> None:
        self._tell(why)
        self._is_waiting = True
