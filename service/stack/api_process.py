"""The HTTP API as a child of `rpr-cusps serve`; Redis and all settings come from the environment."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import gc
import logging
import os
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import uvicorn
from fastapi import FastAPI

from service.api import Settings
from service.api.app import create_app
from service.api.http.protocol import uvicorn_options
from service.api.job_views import event_documents
from service.webhooks.deliverer import Deliverer
from worker import tracing
from worker.connection import connect
from worker.jobs.sweeper import Sweeper
from worker.logs import log_uncaught, set_up
from worker.process import die_with_parent, on_stop_signals
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.service")

_CLOSE_PATIENCE = 3  # seconds for open connections at the end
_COMPLAINT_PAUSE = 60.0


def main() -> int:
    """Serve until a signal comes, or the parent ends."""
    log_uncaught("rpr-cusps service")
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parent-pid", type=int, required=True, help="end with this parent process")
    parser.add_argument("listener", type=int, help="file descriptor of the listening socket")
    parser.add_argument("ready", type=int, help="that of a pipe to write to once requests are served")
    args = parser.parse_args()
    die_with_parent(args.parent_pid)
    settings = Settings()
    worker_settings = WorkerSettings()
    set_up((worker_settings.log_level or "WARNING").upper(), worker_settings.log_format, in_background=True)
    if tracing.prepare("api"):
        tracing.start()
    sweep(settings.redis_url)
    deliver(settings)
    server = ApiServer(create_app(settings), settings, args.ready, args.parent_pid)
    on_stop_signals(server.request_stop)
    gc.freeze()  # what was loaded is no garbage; searching it again and again took a fifth of the time
    server.run(sockets=[socket.socket(fileno=args.listener)])
    return 0


def server_config(app: FastAPI, settings: Settings) -> uvicorn.Config:
    """How uvicorn serves the application."""
    return uvicorn.Config(
        app,
        log_config=None,
        log_level=logging.getLevelName(logging.getLogger().level).lower(),
        access_log=False,
        timeout_graceful_shutdown=_CLOSE_PATIENCE,
        **uvicorn_options(settings),
    )


def sweep(redis_url: str) -> None:
    """Search for lost chunks as workers do, since none may be left."""
    sweeper = Sweeper(connect(redis_url), WorkerSettings())
    threading.Thread(target=sweeper.run, args=(threading.Event(),), daemon=True).start()


def deliver(settings: Settings) -> None:
    """Deliver webhooks, if there are any."""
    if settings.webhooks.is_on:
        own = WorkerSettings()
        deliverer = Deliverer(
            connect(settings.redis_url), settings.webhooks, own, event_documents(own, settings.root_path)
        )
        threading.Thread(target=deliverer.run, args=(threading.Event(),), daemon=True).start()


class ApiServer(uvicorn.Server):
    """A uvicorn server that says when it is ready, and ends with its parent."""

    def __init__(self, app: FastAPI, settings: Settings, ready: int, parent_pid: int) -> None:
        super().__init__(server_config(app, settings))
        self._begin_shutdown = app.state.begin_shutdown
        self._ready, self._parent_pid = ready, parent_pid
        self._next_complaint = 0.0

    def request_stop(self, _number: int, _frame: FrameType | None) -> None:
        """The first signal lets requests end, the second one does not."""
        self.force_exit, self.should_exit = self.should_exit, True

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave the signals to `main`; uvicorn would send itself the signal again at the end."""
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Serve the listening socket, and say so."""
        asyncio.get_running_loop().set_exception_handler(self._complain)
        await super().startup(sockets)
        with contextlib.suppress(OSError):
            os.write(self._ready, b"+")

    async def on_tick(self, counter: int) -> bool:
        """End with the parent."""
        if os.getppid() != self._parent_pid:
            self.should_exit = True
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Let the application answer waiting clients, then cut off the remaining connections."""
        self._begin_shutdown()
        logging.getLogger("uvicorn.error").addFilter(_is_no_cut_connection)
        await super().shutdown(sockets)

    def _complain(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Report a lack of file descriptors once a minute, not for each connection that has to wait."""
        if self.should_exit and "_start_serving" in context["message"]:
            return  # it would accept again after a pause, but the listening socket is closed now
        if "out of system resource" not in context["message"]:
            loop.default_exception_handler(context)
        elif time.monotonic() >= self._next_complaint:
            self._next_complaint = time.monotonic() + _COMPLAINT_PAUSE
            count = len(self.server_state.connections)
            log.warning("%s with %d connections; new ones wait", context["exception"], count)


def _is_no_cut_connection(record: logging.LogRecord) -> bool:
    error = record.exc_info[1] if record.exc_info else None
    cut = isinstance(error, asyncio.CancelledError) or "timeout graceful shutdown" in record.getMessage()
    return not cut
