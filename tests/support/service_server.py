"""A real server with the application, in a thread of the test process."""

from __future__ import annotations

import re
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import httpx
import uvicorn
from fastapi import FastAPI

from service.api.app import create_app
from service.api.http.protocol import uvicorn_options
from service.api.settings import Settings
from tests.support.processes import PATIENCE, until

GEOMETRY = {"a2x": 15.91, "a3x": 0, "a3y": 10, "d1": 17.04, "d2": 16.54, "d3": 20.84}


@contextmanager
def serving(settings: Settings, port: int = 0) -> Iterator[str]:
    """A server that runs as long as the block, on a free port if none is given; gives its base URL."""
    with serving_app(create_app(settings), port) as url:
        yield url


@contextmanager
def serving_app(app: FastAPI, port: int = 0) -> Iterator[str]:
    """The same for a given application."""
    with socket.socket() as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", port))
        options = uvicorn_options(app.state.context.settings)
        server = uvicorn.Server(uvicorn.Config(app, log_config=None, timeout_graceful_shutdown=1, **options))
        thread = threading.Thread(target=server.run, args=([listener],), daemon=True)
        thread.start()
        until(lambda: server.started or not thread.is_alive())
        assert thread.is_alive(), "the server did not start"
        try:
            yield f"http://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            server.should_exit = True
            thread.join(PATIENCE)


NO_WAIT = {"Prefer": "respond-async"}


def accepted(ask: Callable[[], httpx.Response]) -> httpx.Response:
    """Asks new questions until one is accepted as a job: on a busy machine the worker may be the first."""

    def job() -> httpx.Response | None:
        answer = ask()
        assert answer.status_code in (200, 202)
        return answer if answer.status_code == 202 else None

    return until(job)


def ended(client: httpx.Client, job_id: str) -> dict[str, Any]:
    """Waits for a job; returns its document once it has ended."""

    def terminal() -> dict[str, Any] | None:
        job: dict[str, Any] = client.get(f"/v1/jobs/{job_id}").json()
        return None if job["status"] in ("queued", "running") else job

    return until(terminal)


def looks(url: str) -> float:
    """Returns how often clients have looked at jobs."""
    metrics = httpx.get(f"{url}/metrics").text
    found = re.search(r'method="GET",route="/v1/jobs/\{job_id\}",status="200"\} (\S+)', metrics)
    return float(found[1]) if found else 0.0
