"""Chunks that misbehave, for tests of the worker process. Each runs in a forked work horse only."""

from __future__ import annotations

import ctypes
import inspect
import os
import signal
import time
from collections.abc import Callable
from typing import Any
from unittest import mock

import flint

import rpr_solver
from worker.answers import tables
from worker.answers.kind import JobRequest
from worker.answers.kinds import KINDS
from worker.answers.store import ResultStore
from worker.process import tasks

_KEEP = ResultStore.put_eliminant  # itself: a work horse performs several tasks


def stuck() -> None:
    """One C call that does not return and holds the interpreter's lock, so that no signal is handled.

    It takes no processor time, unlike a long computation: other tests run at the same time.
    """
    libc, mutex = ctypes.PyDLL(None), ctypes.create_string_buffer(128)
    libc.pthread_mutex_init(mutex, None)
    while True:  # the second time it waits for itself
        libc.pthread_mutex_lock(mutex)


def endless(*chunk: Any) -> None:
    """A long C call."""
    _run(stuck, chunk)


def endless_at_13(*chunk: Any) -> None:
    """The same, of the slice at 13."""
    _run_unlucky(stuck, chunk)


def greedy(*chunk: Any) -> None:
    """Needs more memory than there is, for a document and for the slice at 13."""
    _run_unlucky(lambda: flint.fmpz(3) ** (10**10), chunk)


def greedy_python(*chunk: Any) -> None:
    """Needs more memory than there is, outside FLINT."""
    _run_unlucky(lambda: bytearray(1 << 40), chunk)


def crash(*chunk: Any) -> None:
    """A segmentation fault, of a document and of the slice at 13."""
    _run_unlucky(lambda: os.kill(os.getpid(), signal.SIGSEGV), chunk)


def killed(*chunk: Any) -> None:
    """Killed from outside, each time."""
    _run_unlucky(lambda: os.kill(os.getpid(), signal.SIGKILL), chunk)


def leave(*chunk: Any) -> None:
    """Ends as if all were done."""
    _run_unlucky(lambda: os._exit(0), chunk)


def broken(*chunk: Any) -> None:
    """An unexpected error, before any slice or document."""

    def fail(*_: Any) -> None:
        raise ZeroDivisionError

    _put(ResultStore, eliminant=fail)
    _compute_by(fail)
    tasks.run_chunk(*chunk)


def slow(*chunk: Any) -> None:
    """A tenth of a second per slice."""
    _run(lambda: time.sleep(0.1), chunk)


def counted(*chunk: Any) -> None:
    """Counts how often the coefficients of an eliminant are computed and kept."""

    def count(store: ResultStore, request: JobRequest, eliminant: rpr_solver.Eliminant) -> None:
        store.redis.incr("eliminations")
        _KEEP(store, request, eliminant)

    _put(ResultStore, put_eliminant=count)
    tasks.run_chunk(*chunk)


def endless_elimination(*chunk: Any) -> None:
    """An elimination in one long C call."""
    _put(rpr_solver, eliminate=lambda *_: stuck())
    tasks.run_chunk(*chunk)


def slow_once(*chunk: Any) -> None:
    """The first attempt is a long C call, a later one works."""
    _run(lambda: chunk[3] or stuck(), chunk)


def gated(*chunk: Any) -> None:
    """Notes which attempt begins something, and goes on once the key `gate` is there; a document tells its
    progress meanwhile."""
    redis = tasks.context().redis

    def wait(progress: Callable[[int, int], None] = lambda _done, _total: None) -> None:
        redis.rpush("begun", chunk[3])
        done = 0
        while not redis.exists("gate"):
            done += 1
            progress(done, 10**6)
            time.sleep(0.02)

    _run(wait, chunk)


def _put(owner: object, **parts: Callable[..., Any]) -> None:
    """Replace parts of a module or a class until the work horse ends; fails if it has none of such a name."""
    mock.patch.multiple(owner, **parts).start()


def _compute_by(compute: Callable[..., Any]) -> None:
    """Have all documents in one piece computed by this, until the work horse ends."""
    for kind in KINDS:
        object.__setattr__(kind, "compute", compute)


def _run_unlucky(act: Callable[[], object], chunk: tuple[Any, ...]) -> None:
    _run(act, chunk, only_slice="13")


def _run(act: Callable[..., object], chunk: tuple[Any, ...], only_slice: str = "") -> None:
    def solve(l1: str) -> dict[str, Any]:
        if only_slice in ("", l1):
            act()
        return {
            "l1": l1,
            "count": 0,
            "cusps": [],
            "degenerate_points": [],
            "certificate": {"pid": os.getpid()},
        }

    def compute(_request: object, _store: object, progress: object) -> dict[str, Any]:
        act(*([progress] if inspect.signature(act).parameters else []))
        return {"pid": os.getpid()}

    def solver(_request: object, _parts: object, eliminant: Callable[[], object]) -> Any:
        eliminant()
        return solve

    _put(tables, slice_solver=solver)
    _compute_by(compute)
    _put(ResultStore, eliminant=lambda *_: None)
    tasks.run_chunk(*chunk)
