"""Everything that can be done with a kind of document, done with the toy kind; printed as one JSON object."""

from __future__ import annotations

import contextlib
import io
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import httpx

from rpr_solver import EXAMPLES
from rpr_solver.errors import InputError
from service.api.settings import Settings
from service.cli.main import main
from service.client import Asked, ServiceClient
from service.schemas.document import Source, read
from service.schemas.limits import Limits
from tests.support.jobs import perform
from tests.support.service_server import serving
from tests.support.toy import PerimeterRequest
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.process import tasks
from worker.settings import WorkerSettings

M = EXAMPLES["zein-flat"]


@contextmanager
def _worker(url: str) -> Iterator[None]:
    """This process as the worker: chunks are run as they come."""
    stop, settings = threading.Event(), WorkerSettings()
    with connect(url) as redis:
        tasks.set_context(tasks.Context(redis, settings, is_horse=True))
        queue = JobQueue(redis, settings)

        def work() -> None:
            while not stop.wait(0.02):
                with contextlib.suppress(InputError):  # the job has failed so
                    perform(queue)

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join()


def _command(*words: str) -> list[Any]:
    """The exit status of a command, and what it prints."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(words)
        except SystemExit as end:
            status = int(end.code or 0)
    return [status, out.getvalue(), err.getvalue()]


def _question(copies: int) -> PerimeterRequest:
    return read(PerimeterRequest, {"geometry": M, "copies": str(copies)}, Source(Limits(), is_text=True))


def run(redis_url: str) -> None:
    """Use the toy kind in every way."""
    body = {"geometry": M.to_json(), "copies": 3}
    with _worker(redis_url), serving(Settings(redis_url=redis_url)) as url:
        with httpx.Client(base_url=url, timeout=60) as http:
            contract = http.get("/openapi.json").json()
            first, second = (http.post("/v1/perimeters", json=body) for _ in range(2))
            refused = http.post("/v1/perimeters", json={**body, "copies": 0})
            result = http.get(f"/v1/jobs/{_question(3).job_request().job_id}/result?format=csv")
        with ServiceClient(url) as client:
            typed = client.ask(Asked.of(_question(4))).typed.perimeter
            asked = [Asked.of(_question(n)).named(str(n)) for n in (3, 5)]
            items = [[item.name, item.kind, item.status] for item in client.ask_all(asked)]
        there = _command("perimeter", "zein-flat", "--copies", "3", "--json", "--url", url)
    print(
        json.dumps(
            {
                "paths": list(contract["paths"]["/v1/perimeters"]),
                "schema": contract["components"]["schemas"]["PerimeterRequest"]["properties"]["copies"],
                "http": [first.status_code, first.json()],
                "again": second.content == first.content,
                "refused": [refused.status_code, refused.json()["type"]],
                "csv": result.text,
                "typed": typed,
                "items": items,
                "here": _command("perimeter", "zein-flat", "--copies", "3", "--json"),
                "there": there,
                "table": _command("perimeter", "zein-flat"),
                "as csv": _command("perimeter", "zein-flat", "--format", "csv"),
                "none": _command("perimeter", "zein-flat", "--copies", "0"),
                "help": _command("perimeter", "--help"),
                "commands": _command("--help"),
                "fetch": _command("fetch", "--help"),
            }
        )
    )
