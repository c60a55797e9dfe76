"""The embedded Valkey, as its supervisor sees it."""

from __future__ import annotations

from collections.abc import Callable

from service.stack.embedded_valkey import EmbeddedValkey
from service.stack.health import ValkeyPing
from worker.process.child import Child, Say


class ValkeyChild:
    """Keeps the embedded Valkey running, with the same data at the same address."""

    def __init__(self, server: EmbeddedValkey, say: Say, hang_seconds: float) -> None:
        self._server = server
        self._child = Child("the embedded Valkey", server.spawn, say, hang_seconds)
        self._ping: ValkeyPing | None = None

    def start(self, is_wanted: Callable[[], bool]) -> None:
        """Start the server and wait until it answers, or is no longer wanted.

        Raises:
            EmbeddedError: it cannot be started.
        """
        self._server.start(is_wanted)
        self._child.adopt(self._server.process)
        self._ping = ValkeyPing(self._server.socket_path)

    def look_after(self) -> None:
        """Replace the process if it died, hangs or cannot be reached; takes no time."""
        if self._ping is not None:
            lost = "lost its socket" if self._ping.is_unreachable else None
            self._child.look_after(self._ping.last, lost)

    def stop(self, is_hurried: Callable[[], bool]) -> None:
        """Stop the server, with everything written to disk."""
        if self._ping is not None:
            self._ping.stop()
        self._server.stop(is_hurried)
