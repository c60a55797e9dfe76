"""Limits that the operating system puts on a process, and the meaning of its wait status."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

Handler = Callable[[int, FrameType | None], object] | signal.Handlers

STOP_SIGNALS = tuple(
    number for number in signal.Signals if number.name in ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"]
)
"""The signals that ask a process to end: from a user, an operator, a closed terminal."""

_PR_SET_PDEATHSIG = 1
_SIGKILL = 9  # Windows has no name for it
_MACOS_OPEN_MAX = 10240  # macOS names no limit, and refuses more than this
_libc = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


def on_stop_signals(handler: Handler) -> dict[signal.Signals, Any]:
    """Install `handler` for the stop signals; returns the previous handlers.

    An ignored SIGHUP (`nohup`) stays ignored.
    """
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    if before[signal.SIGHUP] == signal.SIG_IGN:
        del before[signal.SIGHUP]
    for number in before:
        signal.signal(number, handler)
    return before


@contextmanager
def stop_signals_held(numbers: Container[signal.Signals] = STOP_SIGNALS) -> Iterator[None]:
    """Hold the stop signals, or some of them, until the end of the block; no effect on Windows."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [n for n in STOP_SIGNALS if n in numbers])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def die_with_parent(parent_pid: int, signum: int = _SIGKILL) -> None:
    """Have the kernel end this process with the thread that started it (Linux; no effect elsewhere).

    If `parent_pid` has already ended, the process ends at once.
    """
    if _libc is None:
        return
    _libc.prctl(_PR_SET_PDEATHSIG, int(signum), 0, 0, 0)
    if os.getppid() != parent_pid:
        os.kill(os.getpid(), signum)


def limit_memory(megabytes: int | None) -> None:
    """Limit the address space of this process, and disable core files."""
    import resource  # Windows has none, and commands that need no service import this module

    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    if megabytes is None:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = megabytes * 2**20
    soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    except (OSError, ValueError):
        return  # not supported by every system


def raise_file_limit() -> None:
    """Allow this process and its children as many open files as the system lets them have."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    for limit in (hard, _MACOS_OPEN_MAX):
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, limit), hard))
        except (OSError, ValueError):
            continue
        return


def lift_memory_limit() -> None:
    """Undo `limit_memory`, so that a process that ran out of memory can still report it."""
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


def usable_cores() -> int:
    """Returns the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def usable_memory(root: Path = Path("/")) -> int:
    """Returns the bytes of memory that this process may use: the machine's, or less by its control groups.

    `root` is where `/proc` and `/sys` are.
    """
    found = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    try:
        groups = (root / "proc/self/cgroup").read_text().splitlines()
    except OSError:  # not Linux
        groups = []
    for controllers, group in (line.split(":", 2)[1:] for line in groups):
        if controllers and "memory" not in controllers.split(","):
            continue
        mount, name = ("memory", "memory.limit_in_bytes") if controllers else ("", "memory.max")
        top = root / "sys/fs/cgroup" / mount
        inner = top / group.lstrip("/")  # in a container this is often not there, but its root is
        for directory in (inner, *inner.parents):
            with suppress(OSError, ValueError):  # no such file, or no limit ("max")
                found.append(int((directory / name).read_text()))
            if directory == top:
                break
    return min(size for size in found if size > 0)


def processor_seconds(pid: int) -> float | None:
    """Returns the processor time of a child process; None where the system does not report it."""
    if sys.platform != "linux":
        return None
    try:
        return time.clock_gettime(~pid << 3 | 2)  # the clock of another process; see clock_getcpuclockid
    except OSError:
        return None


def end_process(process: subprocess.Popen[Any], patience: float) -> None:
    """Terminate a child process, and kill it if it is still running after `patience` seconds."""
    process.terminate()
    try:
        process.wait(patience)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def signal_of(status: int) -> int | None:
    """Returns the signal that ended a process, given its wait status."""
    return os.WTERMSIG(status) if os.WIFSIGNALED(status) else None


def signal_name(number: int) -> str:
    """Returns the name of a signal, such as SIGSEGV."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
