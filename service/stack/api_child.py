"""The API process, as its supervisor sees it."""

from __future__ import annotations

import os
import socket
import subprocess
from collections.abc import Mapping

from service.stack.health import Pulse
from worker.process.child import Child, Process, Say, python_program

_STOP_PATIENCE = 6.0  # it gives open connections half of this
_FEW_ARENAS = {"MALLOC_ARENA_MAX": "2"}
"""Or else glibc spreads what some forty threads need over one arena each, and its memory grows for hours."""


class ApiChild:
    """Keeps one API process running. The listening socket stays open: clients wait for the next one.

    Args:
        listener: the listening socket.
        settings: those of the API that differ from the environment.
        say: tells what happens to the process.
        hang_seconds: how long it may be silent.
    """

    def __init__(
        self,
        listener: socket.socket,
        settings: Mapping[str, str],
        say: Say,
        hang_seconds: float,
    ) -> None:
        self._listener = listener
        self._environment = {
            **_FEW_ARENAS,
            **os.environ,
            **{f"RPR_CUSPS_{name.upper()}": value for name, value in settings.items()},
        }
        self._child = Child("the API", self._launch, say, hang_seconds)
        self._pulse: Pulse | None = None

    def start(self) -> None:
        """Start the process."""
        self._child.start()

    def is_ready(self) -> bool:
        """Whether it has answered."""
        return self._pulse is not None and self._pulse.last > 0

    def look_after(self) -> None:
        """Replace the process if it died or hangs; takes no time."""
        self._child.look_after(self._pulse.last if self._pulse is not None else 0.0)

    def processes(self) -> list[tuple[Process, float]]:
        """The process, if it is running, and how long it may take to end."""
        return [] if self._child.process is None else [(self._child.process, _STOP_PATIENCE)]

    def _launch(self) -> Process:
        ours, theirs = socket.socketpair()
        with theirs:
            self._pulse = Pulse(ours)  # ends by itself if no process comes to hold the other end
            fds = (self._listener.fileno(), theirs.fileno())
            options = ("--listener", str(fds[0]), "--health", str(fds[1]), "--parent-pid", str(os.getpid()))
            return subprocess.Popen(
                python_program("service.stack.api_process", *options),
                env=self._environment,
                stdin=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C on a terminal reaches the supervisor alone
                pass_fds=fds,
            )
