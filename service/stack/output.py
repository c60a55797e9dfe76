"""What a supervisor says: a line at a time, and never at the price of its work."""

from __future__ import annotations

import contextlib
import os
import select

from worker.logs import LogFormat, line

_STDOUT, _STDERR = 1, 2


def say(text: str) -> None:
    """Write a line to stderr."""
    _write(_STDERR, f"rpr-cusps serve: {' '.join(text.split())}\n")


def note(form: LogFormat, text: str) -> None:
    """Write what happens while the stack runs to stderr, as the line of a log."""
    _write(_STDERR, line("rpr_cusps.serve", " ".join(text.split()), form) + "\n")


def announce(text: str) -> None:
    """Write a line to stdout."""
    _write(_STDOUT, f"{text}\n")


def _write(fd: int, text: str) -> None:
    """A full disk, a reader that is gone or one that no longer reads loses the line, not the service."""
    with contextlib.suppress(OSError, ValueError):
        _, is_writable, _ = select.select([], [fd], [], 0)
        if is_writable:
            os.write(fd, text.encode(errors="backslashreplace")[-select.PIPE_BUF :])
