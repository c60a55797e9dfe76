"""`rpr-cusps serve`: an embedded Valkey, worker processes and the API, started and stopped together.

The supervisor keeps them running, each in a process of its own, and does nothing else.
"""

from __future__ import annotations

import contextlib
import ipaddress
import logging
import os
import select
import signal
import socket
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

from pydantic import ValidationError
from redis.exceptions import RedisError

from rpr_solver.errors import InputError
from service.api import KeysPolicy, Settings
from service.api.keys import KeyStore
from service.errors import BadAddressError, NoServerError, StackError
from service.stack import API
from service.stack.embedded_valkey import EmbeddedValkey
from worker.connection import Search, UnreachableError, connect
from worker.logs import LogFormat, asked_form, line, program_line
from worker.process import on_stop_signals, usable_cores
from worker.process.pool import Child, Say, WorkerPool, end_all, running
from worker.process.programs import Process, Program
from worker.settings import WorkerSettings, settings_problem, written

_STOP_PATIENCE = 6.0
"""Seconds that the API may take to end; it gives open connections half of this."""

_TICK = 0.05
"""Seconds between two looks at the children."""

_ANNOUNCE_PATIENCE = 5.0
"""Seconds that the announcement waits for workers, once the API is ready."""


class Api(Child):
    """Keeps the API running. The listening socket stays open: clients wait for the next process.

    Args:
        listener: the listening socket.
        settings: those of the API that differ from the environment.
        say: reports what happens to the process.
    """

    def __init__(self, listener: socket.socket, settings: Mapping[str, str], say: Say) -> None:
        super().__init__("the API", self._launch_it, say, _STOP_PATIENCE)
        self._listener = listener
        own = {f"RPR_CUSPS_{name.upper()}": value for name, value in settings.items()}
        self._environment = {**os.environ, **own}
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._reader, False)
        self._is_ready = False

    def is_ready(self) -> bool:
        """Whether a process of the API has said that it serves requests."""
        with contextlib.suppress(BlockingIOError):
            self._is_ready = self._is_ready or bool(os.read(self._reader, 1))
        return self._is_ready

    def _launch_it(self) -> Process:
        descriptors = (self._listener.fileno(), self._writer)
        return Program(API, ("--parent-pid", str(os.getpid())), self._environment, descriptors).start()


class Supervisor:
    """The processes of one machine. All calls must come from one thread, since they end with it."""

    def __init__(self, valkey: Child | None, api: Api, pool: WorkerPool, announcement: str) -> None:
        self._api, self._pool = api, pool
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
            if is_reached():
                self._announce()
            time.sleep(_TICK)

    def stop(self, is_hurried: Callable[[], bool]) -> None:
        """End the API and the workers; unfinished chunks go back to the queue."""
        end_all(running([self._api, *self._pool.members]), is_hurried)
        self._pool.stop()

    def _announce(self) -> None:
        if not self._announcement or not self._api.is_ready():
            return
        self._announce_at = min(self._announce_at, time.monotonic() + _ANNOUNCE_PATIENCE)
        if self._pool.is_ready() or time.monotonic() >= self._announce_at:
            announce(self._announcement)
            self._announcement = ""


_STDOUT, _STDERR = 1, 2
_PROGRAM = "rpr-cusps serve"


def say(text: str, level: int = logging.WARNING) -> None:
    """Write a line to stderr."""
    _write(_STDERR, lambda part: program_line(_PROGRAM, part, level), text)


def note(form: LogFormat, text: str) -> None:
    """Write what happens while the stack runs to stderr, as the line of a log."""
    _write(_STDERR, lambda part: line("rpr_cusps.serve", part, form), text)


def announce(text: str) -> None:
    """Write a line to stdout."""
    is_text = asked_form() == "text"
    _write(_STDOUT, lambda part: part if is_text else program_line(_PROGRAM, part, logging.INFO), text)


def _write(fd: int, form: Callable[[str], str], text: str) -> None:
    """A full disk, or a reader that has ended or hangs, costs the line, not the service."""
    text = " ".join(text.split())
    while len(whole := f"{form(text)}\n".encode(errors="backslashreplace")) > select.PIPE_BUF:
        text = f"… {text[len(text) // 4 :]}"  # its end says why
    with contextlib.suppress(OSError, ValueError):
        _, is_writable, _ = select.select([], [fd], [], 0)
        if is_writable:
            os.write(fd, whole)


def is_loopback(listener: socket.socket) -> bool:
    """Whether only this computer reaches the address of a listening socket."""
    return ipaddress.ip_address(listener.getsockname()[0].partition("%")[0]).is_loopback


_FAILED, _BAD_INPUT = 1, 2


@dataclass(frozen=True)
class ServeSettings:
    """The options of `rpr-cusps serve`."""

    host: str = "127.0.0.1"
    port: int = 8000
    workers: int | None = None  # None: one per usable core, and one for small questions
    redis_url: str | None = None  # None: an embedded Valkey
    data_dir: Path | None = None  # None: the platform's directory for user data
    insecure: bool = False  # without keys, on whatever address
    root_path: str | None = None  # None: as the environment says

    @property
    def worker_count(self) -> int:
        """The number of worker processes."""
        return usable_cores() + 1 if self.workers is None else self.workers


def serve(settings: ServeSettings) -> int:
    """Run the whole stack until SIGINT, SIGTERM, SIGHUP or SIGQUIT; returns the exit status.

    Call it in the main thread. A second signal speeds up the shutdown.
    """
    signals = _Signals()
    try:
        with signals, ExitStack() as stack:
            _run(settings, signals, stack)
    except ValidationError as error:
        say(settings_problem(error), logging.ERROR)
        return _BAD_INPUT
    except (StackError, InputError) as error:
        say(str(error), logging.ERROR)
        return _BAD_INPUT if isinstance(error, BadAddressError | NoServerError | InputError) else _FAILED
    return 0


def _run(settings: ServeSettings, signals: _Signals, stack: ExitStack) -> None:
    environment = Settings()  # a bad environment ends the stack, not a child again and again
    worker_settings = WorkerSettings()
    level = (worker_settings.log_level or "WARNING").upper()
    tell = partial(note, worker_settings.log_format)
    listener = stack.enter_context(_bind(settings.host, settings.port))
    policy = "never" if settings.insecure else environment.require_keys
    if policy == "auto" and not is_loopback(listener):
        policy = "always"
    valkey = given = None
    if settings.redis_url is None:
        server = EmbeddedValkey(settings.data_dir, tell)
        stack.callback(server.stop, signals.is_repeated)
        server.start(signals.is_quiet)
        valkey = server.child(tell)
        url, where = server.url, f"data in {server.data_dir}"
    else:
        url, where = settings.redis_url, "data in the given Redis"
        check = partial(_check_keys, policy, settings, listener, url)
        given = Search(url, tell, check)
        while not (given.is_over or given.is_waiting) and signals.is_quiet():
            time.sleep(_TICK)
        _raise_problem_of(given)
    if not signals.is_quiet():
        return
    if given is None:
        _check_keys(policy, settings, listener, url)
    of_api = {
        "redis_url": url,
        "require_keys": policy,
        "allowed_hosts": written((*environment.allowed_hosts, settings.host)),
        "log_level": level,
        "root_path": environment.root_path if settings.root_path is None else settings.root_path,
    }
    pool = WorkerPool(settings.worker_count, url, level, tell)
    api = Api(listener, of_api, tell)
    supervisor = Supervisor(valkey, api, pool, _announcement(settings, listener, where))
    stack.callback(supervisor.stop, signals.is_repeated)
    if given is None:
        supervisor.run(signals.is_quiet)
        return
    supervisor.run(lambda: signals.is_quiet() and given.problem is None, lambda: given.is_reached)
    _raise_problem_of(given)


class _Signals:
    """The stop signals: the first starts an orderly shutdown, the second speeds it up."""

    def __init__(self) -> None:
        self._count = 0
        self._before: dict[signal.Signals, Any] = {}

    def is_quiet(self) -> bool:
        """Whether none has come."""
        return self._count == 0

    def is_repeated(self) -> bool:
        """Whether a second one has come."""
        return self._count > 1

    def __enter__(self) -> None:
        self._before = on_stop_signals(self._handle)

    def __exit__(self, *_: object) -> None:
        # after a signal ended the stack, another one must not interrupt the last steps of the process
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_IGN if self._count else handler)

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        self._count += 1


def _bind(host: str, port: int) -> socket.socket:
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        # of the two addresses of "localhost", the one that most clients try first
        family, kind, proto, _, address = min(addresses, key=lambda info: info[0] != socket.AF_INET)
        listener = socket.socket(family, kind, proto)
    except OSError as error:
        raise StackError(f"cannot listen on {host}: {error.strerror or error}") from error
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(1024)
    except (OSError, OverflowError) as error:
        listener.close()
        reason = getattr(error, "strerror", None) or error
        raise StackError(f"cannot listen on {host} port {port}: {reason}; choose another --port") from error
    return listener


def _announcement(settings: ServeSettings, listener: socket.socket, where: str) -> str:
    host = f"[{settings.host}]" if ":" in settings.host else settings.host
    count = settings.worker_count
    workers = f"{count} worker{'' if count == 1 else 's'}"
    port = listener.getsockname()[1]
    return f"rpr-cusps is ready at http://{host}:{port} ({workers}, {where}); Ctrl-C stops it"


def _check_keys(policy: KeysPolicy, settings: ServeSettings, listener: socket.socket, url: str) -> None:
    """Refuse to start if keys are required and there is none; say who has access.

    Raises:
        StackError: keys are required, and there is none.
    """
    address, port = listener.getsockname()[:2]
    if policy != "never":
        try:
            with connect(url) as redis:
                keys = KeyStore(redis, WorkerSettings().key_prefix).all().values()
        except RedisError as error:
            raise StackError(f"cannot read the keys from Redis: {error}") from error
        valid = sum(key.state(time.time()) == "valid" for key in keys)
        if keys and policy == "auto":
            have = f"{valid} valid key{'' if valid == 1 else 's'}"
            undo = "--insecure (or RPR_CUSPS_REQUIRE_KEYS=never) gives access without keys"
            say(f"every client needs a key, since keys were created; there are {have}; {undo}", logging.INFO)
        if policy == "always" and not valid:
            own = "" if settings.data_dir is None else f" --data-dir {settings.data_dir}"
            where = own if settings.redis_url is None else " --redis-url …"
            raise StackError(
                f"on {address} the service requires keys, and none exists: create one with "
                f"`rpr-cusps keys create NAME{where}`, or give access to everyone with --insecure"
            )
    if policy == "never" and not is_loopback(listener):
        say(f"no keys are required: anyone who reaches {settings.host} port {port} may use it")


def _raise_problem_of(search: Search) -> None:
    """Raise why the service cannot run with a Redis, if so.

    Raises:
        StackError: it cannot.
    """
    problem = search.problem
    if isinstance(problem, UnreachableError):
        is_address = isinstance(problem.__cause__, ValueError)
        raise (BadAddressError if is_address else StackError)(str(problem))
    if problem is not None:
        raise problem
