"""Shared computations: what several workers need at once is computed by one of them."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import TypeVar

T = TypeVar("T")

_FIRST_PAUSE, _LONGEST_PAUSE = 0.005, 0.05


def single_flight(
    known: Callable[[], T | None],
    lock: Callable[[], AbstractContextManager[bool]],
    make: Callable[[], T],
    *,
    is_unknown: bool = False,
) -> T:
    """Returns the known result, or makes it, or waits for the worker that holds the lock.

    `make` must keep its result, so that `known` returns it afterwards. `is_unknown`: there was none a moment
    ago, so that it is not looked for before the lock is held.
    """
    pause = _FIRST_PAUSE
    while True:
        result = None if is_unknown else known()
        if result is not None:
            return result
        is_unknown = False
        with lock() as held:
            if held:
                result = known()  # made between the look and the lock?
                return make() if result is None else result
        time.sleep(pause)
        pause = min(2 * pause, _LONGEST_PAUSE)
