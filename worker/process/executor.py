"""Processes that share the work of one command."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

from worker.process.processes import die_with_parent

_SAFE_PATH = "PYTHONSAFEPATH"


@contextmanager
def executor(count: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that run no module of the current folder, and end with this one even if it is killed.

    What `multiprocessing` starts would search the current folder for modules before all others, and the
    folder may be a stranger's; Python's variable PYTHONSAFEPATH forbids it. A PYTHONPATH holds as it is.
    """
    before = os.environ.get(_SAFE_PATH)
    os.environ[_SAFE_PATH] = "1"
    # without the parent's id the processes would wait for ever if it were killed
    pool = ProcessPoolExecutor(count, get_context("spawn"), die_with_parent, (os.getpid(),))
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)  # waits: a pool left to the exit may write to a closed pipe
        if before is None:
            del os.environ[_SAFE_PATH]
        else:
            os.environ[_SAFE_PATH] = before
