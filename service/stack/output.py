"""What a supervisor says: a line at a time, and never at the price of its work."""

from __future__ import annotations

import contextlib
import logging
import os
import select
from collections.abc import Callable

from worker.logs import LogFormat, asked_form, line, told

_STDOUT, _STDERR = 1, 2
_PROGRAM = "rpr-cusps serve"


def say(text: str, level: int = logging.WARNING) -> None:
    """Write a line to stderr."""
    _write(_STDERR, lambda part: told(_PROGRAM, part, level), text)


def note(form: LogFormat, text: str) -> None:
    """Write what happens while the stack runs to stderr, as the line of a log."""
    _write(_STDERR, lambda part: line("rpr_cusps.serve", part, form), text)


def announce(text: str) -> None:
    """Write a line to stdout."""
    is_text = asked_form() == "text"
    _write(_STDOUT, lambda part: part if is_text else told(_PROGRAM, part, logging.INFO), text)


def _write(fd: int, form: Callable[[str], str], text: str) -> None:
    """A full disk, or a reader that has ended or hangs, costs the line, not the service."""
    text = " ".join(text.split())
    while len(whole := f"{form(text)}\n".encode(errors="backslashreplace")) > select.PIPE_BUF:
        text = f"… {text[len(text) // 4 :]}"  # its end says why
    with contextlib.suppress(OSError, ValueError):
        _, is_writable, _ = select.select([], [fd], [], 0)
        if is_writable:
            os.write(fd, whole)
