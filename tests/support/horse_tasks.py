"""Tasks of work horses, for tests of their stay."""

from __future__ import annotations

import os
import signal
import time


def sound() -> bool:
    """All goes well."""
    return True


def unsound() -> bool:
    """Something went wrong, and is recorded."""
    return False


def broken() -> bool:
    """Nothing is recorded."""
    raise ZeroDivisionError


def large() -> bool:
    """Needs 64 MiB for a moment."""
    return any(bytearray(os.urandom(1)) * (64 << 20)) or True


def killed() -> bool:
    """Ends by a signal."""
    os.kill(os.getpid(), signal.SIGKILL)
    return True


def endless() -> bool:
    """Takes longer than any test."""
    time.sleep(600)
    return True
