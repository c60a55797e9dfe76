"""What one question costs Redis."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from redis import Redis

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import Workers, until
from tests.support.service_server import GEOMETRY, serving
from tests.support.stack import running
from worker.jobs.plan import queue_name
from worker.settings import WorkerSettings

WAIT = {"Prefer": "wait=30"}
FINISHED = f"rq:finished:{queue_name('small', WorkerSettings())}"
"""Where RQ notes that a worker is done with a job."""


def test_what_is_new_takes_few_commands(valkey: EmbeddedValkey, redis: Redis, workers: Workers) -> None:
    """From the request to the end of the chunk; 50 of clients, 30 more in scripts."""
    workers.start()
    with serving(Settings(redis_url=valkey.url)) as url, httpx.Client(base_url=url, timeout=60) as client:

        def ask(path: str, body: object) -> None:
            done = redis.zcard(FINISHED)
            assert client.post(path, json=body, headers=WAIT).status_code == 200
            until(lambda: redis.zcard(FINISHED) == done + 1)

        ask("/v1/cusp-tables", question("10"))  # loads the scripts
        ask("/v1/poses", poses("15"))
        slice_, document = (
            commands(redis, lambda path=path, body=body: ask(path, body))
            for path, body in (("/v1/cusp-tables", question("10.5")), ("/v1/poses", poses("15.5")))
        )
    slices, documents = ([x for x in found if not x.startswith("LUA ")] for found in (slice_, document))
    assert 10 < len(documents) < 55, documents
    assert 10 < len(slices) < 60, slices
    assert len(document) < 85, "with those inside scripts"
    assert len(slice_) < 95, slice_


@pytest.mark.long
def test_who_waits_asks_little(tmp_path: Path) -> None:
    """An API process and two workers without work: searches for lost chunks, registers, and waits."""
    with running(tmp_path, workers=2) as stack, stack.redis() as redis:
        until(lambda: redis.scard("rq:workers") == 2)
        time.sleep(2)  # their first searches load scripts
        before, begin = processed(redis), time.monotonic()
        time.sleep(10)  # twice the longest interval
        rate = (processed(redis) - before) / (time.monotonic() - begin)
    print(f"{rate:.1f} commands a second")  # shown by `pytest -rP`
    assert 0 < rate <= 10


def processed(redis: Redis) -> int:
    """How many commands the server has performed, with those inside scripts."""
    return int(redis.info("stats")["total_commands_processed"])


def commands(redis: Redis, act: Callable[[], object]) -> list[str]:
    """Returns the commands that clients send meanwhile, but for what waits, and those inside scripts."""
    seen: list[str] = []
    with redis.monitor() as monitor:
        reader = threading.Thread(target=read, args=(monitor, seen), daemon=True)
        reader.start()
        act()
        redis.echo("the end")
        reader.join(30)
    return [command for command in seen if not command.startswith(("BLMOVE", "BLPOP", f"ZCARD {FINISHED}"))]


def poses(l1: str) -> dict[str, Any]:
    return {"geometry": GEOMETRY, "l1": l1, "l2": "16", "l3": "30"}


def question(a3y: str) -> dict[str, Any]:
    return {"geometry": {**GEOMETRY, "a3y": a3y}, "l1": "14.98", "digits": 15}


def read(monitor: Any, commands: list[str]) -> None:
    for entry in monitor.listen():
        if entry["command"] == "ECHO the end":
            return
        inside = "LUA " if entry["client_type"] == "lua" else ""
        commands.append(inside + entry["command"])
