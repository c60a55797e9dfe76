"""What one question costs Redis."""

from __future__ import annotations

import threading
from typing import Any

import httpx
from redis import Redis

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import Workers, until
from tests.support.service_server import GEOMETRY, serving

WAIT = {"Prefer": "wait=30"}


def test_a_new_slice_takes_few_commands(valkey: EmbeddedValkey, redis: Redis, workers: Workers) -> None:
    """From the request to the end of the chunk, without what workers do at every beat whatever happens."""
    workers.start(beat_interval=100, beat_ttl=300)
    commands: list[str] = []
    with serving(Settings(redis_url=valkey.url)) as url, httpx.Client(base_url=url, timeout=60) as client:
        client.post("/v1/cusp-tables", json=question("10"), headers=WAIT)  # loads the scripts
        until(lambda: not redis.keys("*:beat:*"))
        with redis.monitor() as monitor:
            reader = threading.Thread(target=read, args=(monitor, commands), daemon=True)
            reader.start()
            assert client.post("/v1/cusp-tables", json=question("10.5"), headers=WAIT).status_code == 200
            until(lambda: not redis.keys("*:beat:*"))  # the worker is done with it
            redis.echo("the end")
            reader.join(30)
    own = [command for command in commands if not command.startswith(("BLPOP", "KEYS"))]
    assert 10 < len(own) < 32, own


def question(a3y: str) -> dict[str, Any]:
    return {"geometry": {**GEOMETRY, "a3y": a3y}, "l1": "14.98", "digits": 15}


def read(monitor: Any, commands: list[str]) -> None:
    for entry in monitor.listen():
        if entry["command"] == "ECHO the end":
            return
        if entry["client_type"] != "lua":
            commands.append(entry["command"])
