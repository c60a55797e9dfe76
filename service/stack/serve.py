"""`rpr-cusps serve`: an embedded Valkey, worker processes and the API, started and stopped together."""

from __future__ import annotations

import asyncio
import logging
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import uvicorn
from pydantic import ValidationError

from service.api.settings import KeysPolicy, Settings
from service.stack.embedded_valkey import EmbeddedValkey
from service.stack.errors import EmbeddedError, StackError
from service.stack.exposure import is_loopback, keys_policy
from worker.connection import UnreachableError, check, connect
from worker.jobs.sweeper import Sweeper
from worker.logs import set_up
from worker.process.os_limits import on_stop_signals, usable_cores
from worker.process.pool import WorkerPool
from worker.settings import WorkerSettings, settings_problem

_ANNOUNCE_PATIENCE = 50  # ticks of a tenth of a second
_CLOSE_PATIENCE = 3  # seconds for open connections at the end


@dataclass(frozen=True)
class ServeSettings:
    """The options of `rpr-cusps serve`."""

    host: str = "127.0.0.1"
    port: int = 8000
    workers: int | None = None  # None: one per usable core
    redis_url: str | None = None  # None: an embedded Valkey
    data_dir: Path | None = None  # None: the platform's directory for user data
    insecure: bool = False  # without keys, on whatever address

    @property
    def worker_count(self) -> int:
        """The number of worker processes."""
        return usable_cores() if self.workers is None else self.workers


def serve(settings: ServeSettings) -> int:
    """Run the whole stack until SIGINT, SIGTERM, SIGHUP or SIGQUIT; returns the exit status.

    Call it in the main thread. A second signal speeds up the shutdown.
    """
    signals = _Signals()
    try:
        with signals, ExitStack() as stack:
            _run(settings, signals, stack)
    except StackError as error:
        _say(str(error))
        return 1
    return 0


def _say(text: str) -> None:
    print(f"rpr-cusps serve: {text}", file=sys.stderr)


def _run(settings: ServeSettings, signals: _Signals, stack: ExitStack) -> None:
    worker_settings = _worker_settings()
    level = (worker_settings.log_level or "WARNING").upper()
    set_up(level, worker_settings.log_format, in_background=True)
    listener = stack.enter_context(_bind(settings.host, settings.port))
    valkey = None
    if settings.redis_url is None:
        valkey = stack.enter_context(EmbeddedValkey(settings.data_dir))
    url = settings.redis_url if valkey is None else valkey.url
    assert url is not None
    _check_redis(url)
    policy = _keys_policy(settings, listener, url)
    pool = WorkerPool(
        settings.worker_count, url, level, lambda how: _say(f"a worker died ({how}); starting another")
    )
    stack.callback(lambda: pool.stop(hurry=lambda: signals.count > 1))
    pool.start()  # before the application is imported: the workers import at the same time
    _start_sweeper(url, worker_settings, stack)
    config = uvicorn.Config(
        _create_app(url, policy),
        log_config=None,
        log_level=level.lower(),
        access_log=False,
        timeout_graceful_shutdown=_CLOSE_PATIENCE,
    )
    signals.server = server = _Server(config, pool, valkey, _announcement(settings, listener, valkey))
    if signals.count == 0:
        server.run(sockets=[listener])
    if server.problem is not None:
        raise StackError(server.problem)


class _Server(uvicorn.Server):
    """A uvicorn server that looks after the other processes between requests."""

    def __init__(
        self, config: uvicorn.Config, pool: WorkerPool, valkey: EmbeddedValkey | None, announcement: str
    ) -> None:
        super().__init__(config)
        self.pool = pool
        self.valkey = valkey
        self.announcement = announcement
        self.problem: str | None = None

    def run(self, sockets: list[socket.socket] | None = None) -> None:
        try:
            super().run(sockets)
        except SystemExit:
            self.problem = self.problem or "the application did not start"

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave the signals to the stack; uvicorn would send itself the signal again at the end."""
        yield

    async def on_tick(self, counter: int) -> bool:
        if not self.should_exit:
            self._look_after_the_others(counter)
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Let the application answer waiting clients, then cut off the remaining connections."""
        if begin := getattr(getattr(self.config.app, "state", None), "begin_shutdown", None):
            begin()
        logging.getLogger("uvicorn.error").addFilter(_is_no_cut_connection)
        await super().shutdown(sockets)

    def _look_after_the_others(self, counter: int) -> None:
        if self.valkey is not None and not self.valkey.is_alive():
            _say("the embedded Valkey died; restarting it")
            try:
                self.valkey.launch()
            except (EmbeddedError, OSError) as error:
                self.problem, self.should_exit = str(error), True
                return
        self.pool.look_after()
        if self.announcement and (counter >= _ANNOUNCE_PATIENCE or self.pool.is_ready()):
            print(self.announcement, flush=True)
            self.announcement = ""


def _is_no_cut_connection(record: logging.LogRecord) -> bool:
    error = record.exc_info[1] if record.exc_info else None
    cut = isinstance(error, asyncio.CancelledError) or "timeout graceful shutdown" in record.getMessage()
    return not cut


class _Signals:
    """The stop signals: the first starts an orderly shutdown, the second speeds it up."""

    def __init__(self) -> None:
        self.count = 0
        self.server: uvicorn.Server | None = None
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> None:
        self._before = on_stop_signals(self._handle)

    def __exit__(self, *_: object) -> None:
        # after a signal ended the stack, another one must not interrupt the last steps of the process
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_IGN if self.count else handler)

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        self.count += 1
        if self.server is not None:
            self.server.should_exit = True
            self.server.force_exit = self.count > 1


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


def _worker_settings() -> WorkerSettings:
    try:
        return WorkerSettings()
    except ValidationError as error:
        raise StackError(settings_problem(error)) from error


def _check_redis(url: str) -> None:
    try:
        check(url)
    except UnreachableError as error:
        raise StackError(str(error)) from error


def _start_sweeper(url: str, settings: WorkerSettings, stack: ExitStack) -> None:
    redis, stop = connect(url), threading.Event()
    stack.callback(redis.close)
    thread = threading.Thread(target=Sweeper(redis, settings).run, args=(stop,), daemon=True)
    stack.callback(thread.join, 2.0)
    stack.callback(stop.set)
    thread.start()


def _announcement(settings: ServeSettings, listener: socket.socket, valkey: EmbeddedValkey | None) -> str:
    host = f"[{settings.host}]" if ":" in settings.host else settings.host
    where = f"data in {valkey.data_dir}" if valkey is not None else "data in the given Redis"
    count = settings.worker_count
    workers = f"{count} worker{'' if count == 1 else 's'}"
    port = listener.getsockname()[1]
    return f"rpr-cusps is ready at http://{host}:{port} ({workers}, {where}); Ctrl-C stops it"


def _keys_policy(settings: ServeSettings, listener: socket.socket, url: str) -> KeysPolicy:
    asked = "never" if settings.insecure else Settings().require_keys
    where = "" if settings.data_dir is None else f" --data-dir {settings.data_dir}"
    policy = keys_policy(listener, asked, url, where if settings.redis_url is None else " --redis-url …")
    if policy == "never" and not is_loopback(listener):
        _say(f"without keys: whoever reaches {settings.host} port {listener.getsockname()[1]} may use it")
    return policy


def _create_app(redis_url: str, policy: KeysPolicy) -> Any:
    from service.api.app import create_app

    return create_app(Settings(redis_url=redis_url, require_keys=policy))
