"""Keeps Valkey, the workers and the API running, each in a process of its own, and does nothing else."""

from __future__ import annotations

import contextlib
import logging
import os
import select
import socket
import threading
import time
from collections.abc import Callable, Mapping

from pydantic import Field

from service.stack import API
from service.stack.embedded_valkey import ValkeyChild
from worker.logs import LogFormat, asked_form, line, told
from worker.process import reap_orphans
from worker.process.pool import Child, WorkerPool, end_all, running
from worker.process.programs import Process, Program, Say, Start, Template
from worker.settings import EnvironmentSettings

_STOP_PATIENCE = 6.0  # it gives open connections half of this

_TICK = 0.05
_ANNOUNCE_PATIENCE = 5.0  # seconds that the announcement waits for workers, once the API answers


_PULSE, _PULSE_TIMEOUT = 1.0, 2.0  # seconds
_HEALTH = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
_HEALTHY = b"HTTP/1.1 200 "


class SupervisorSettings(EnvironmentSettings):
    """How the processes of one machine are looked after."""

    hang_seconds: float = Field(
        default=10.0,
        ge=3,
        allow_inf_nan=False,
        description="time without a sign of life after which `serve` kills Valkey, a worker or the API "
        "and starts another, in seconds",
    )


class Pulse:
    """Asks one API process for `/healthz` over a connection of their own, which no other client can use up.

    It ends with the process.
    """

    def __init__(self, ours: socket.socket) -> None:
        self.last = 0.0
        """When it was last healthy (`time.monotonic()`, 0 for never)."""
        self._socket = ours
        ours.settimeout(_PULSE_TIMEOUT)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        with self._socket:
            while self._ask():
                time.sleep(_PULSE)

    def _ask(self) -> bool:
        """Ping, and read an answer, even a late one to an earlier ping; False if nothing listens."""
        try:
            self._socket.sendall(_HEALTH)
            answer = self._socket.recv(1 << 16)
        except TimeoutError:
            return True
        except OSError:
            return False
        if _HEALTHY in answer:
            self.last = time.monotonic()
        return bool(answer)


class ApiChild(Child):
    """Keeps one API process running. The listening socket stays open: clients wait for the next one.

    Args:
        listener: the listening socket.
        settings: those of the API that differ from the environment.
        say: reports what happens to the process.
        hang_seconds: how long it may be silent.
        start: starts the process.
    """

    def __init__(
        self,
        listener: socket.socket,
        settings: Mapping[str, str],
        say: Say,
        hang_seconds: float,
        start: Start,
    ) -> None:
        super().__init__("the API", self._launch, say, hang_seconds, _STOP_PATIENCE)
        self._listener, self._start_program = listener, start
        self._environment = {
            **os.environ,
            **{f"RPR_CUSPS_{name.upper()}": value for name, value in settings.items()},
        }
        self._pulse: Pulse | None = None

    def sign(self) -> float:
        """When it last answered."""
        return 0.0 if self._pulse is None else self._pulse.last

    def _launch(self) -> Process:
        ours, theirs = socket.socketpair()
        with theirs:
            self._pulse = Pulse(ours)  # ends by itself if no process comes to hold the other end
            descriptors = (self._listener.fileno(), theirs.fileno())
            options = ("--parent-pid", str(os.getpid()))
            return self._start_program(Program(API, options, self._environment, descriptors))


class Supervisor:
    """The processes of one machine. All calls must come from one thread, since they end with it."""

    def __init__(
        self,
        template: Template,
        valkey: ValkeyChild | None,
        api: ApiChild,
        pool: WorkerPool,
        announcement: str,
    ) -> None:
        self._template, self._api, self._pool = template, api, pool
        self._children: list[Child] = [*([] if valkey is None else [valkey]), api, *pool.members]
        self._announcement = announcement
        self._announce_at = float("inf")

    def run(self, is_wanted: Callable[[], bool], is_reached: Callable[[], bool] = lambda: True) -> None:
        """Start the API and the workers, and keep everything running until a stop signal.

        It is announced once Redis is reached.
        """
        self._api.start()
        self._pool.start()
        while is_wanted():
            for child in self._children:
                child.look_after()
            own = [process for process, _ in running(self._children)]
            reap_orphans({process.pid for process in (*own, *self._template.processes())})
            if is_reached():
                self._announce()
            time.sleep(_TICK)

    def stop(self, is_hurried: Callable[[], bool]) -> None:
        """End the API and the workers; unfinished chunks go back to the queue."""
        end_all(running([self._api, *self._pool.members]), is_hurried)
        self._pool.stop()

    def _announce(self) -> None:
        if not self._announcement or not self._api.sign():
            return
        self._announce_at = min(self._announce_at, time.monotonic() + _ANNOUNCE_PATIENCE)
        if self._pool.is_ready() or time.monotonic() >= self._announce_at:
            announce(self._announcement)
            self._announcement = ""


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
